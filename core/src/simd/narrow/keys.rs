//! The six keys of a box in two vectors of four.

use super::vectors::{NO_BYTE, Vectors};
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY};
use crate::geometry::record::{Frame, Record};

/// The places of the second to the fourth word, then of the first one.
pub(super) const FROM_SECOND: [u8; 16] = [4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3];

/// The places of six lanes of 16 bits among the four and four of [`Keys`].
const SIX_LANES: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 12, 13, 14, 15, NO_BYTE, NO_BYTE, NO_BYTE, NO_BYTE];

/// The first four and the last four keys of a box. Two keys are in both, so no lane is empty. They are loaded and
/// stored in the order of memory.
#[derive(Clone, Copy)]
pub(crate) struct Keys<V: Vectors> {
    pub(super) first: V::Vector,
    pub(super) last: V::Vector,
}

/// The first four and the last four words.
#[inline(always)]
fn ends<const N: usize>(words: &[f32; N]) -> [&[u8; 16]; 2] {
    // There are six or more.
    let first = words.first_chunk::<4>().unwrap_or(&[0.0; 4]);
    let last = words.last_chunk::<4>().unwrap_or(&[0.0; 4]);
    [bytemuck::cast_ref(first), bytemuck::cast_ref(last)]
}

/// The first six numbers of a frame's row.
#[inline(always)]
fn six(row: &[f32; 8]) -> &[f32; 6] {
    row.first_chunk().unwrap_or(&[0.0; 6])
}

impl<V: Vectors> Keys<V> {
    #[inline(always)]
    pub(super) fn load(v: V, bounds: &KeyBox) -> Self {
        let [first, last] = ends::<6>(bytemuck::cast_ref(bounds));
        Self { first: v.load(first), last: v.load(last) }
    }

    #[inline(always)]
    pub(super) fn bounds(self, v: V) -> KeyBox {
        let mut words = [0_u32; 6];
        // There are four.
        if let Some(first) = words.first_chunk_mut::<4>() {
            v.store(bytemuck::cast_mut(first), self.first);
        }
        if let Some(last) = words.last_chunk_mut::<4>() {
            v.store(bytemuck::cast_mut(last), self.last);
        }
        bytemuck::cast(words)
    }

    /// The maxima on the three axes, then the minimum on the third one.
    #[inline(always)]
    pub(super) fn maxima(self, v: V) -> V::Vector {
        v.shuffle(self.last, v.load(&FROM_SECOND))
    }

    /// As [`Simd::encode`](crate::simd::Simd::encode).
    #[inline(always)]
    pub(super) fn encode(v: V, min: &[u8; 12], max: &[u8; 12]) -> Option<Self> {
        let [a, b, c]: [u32; 3] = bytemuck::cast(*min);
        let [d, e, f]: [u32; 3] = bytemuck::cast(*max);
        let found = Self { first: v.keys(v.words([a, b, c, d])), last: v.keys(v.words([c, d, e, f])) };
        let (minima, maxima) = (found.first, found.maxima(v));
        // Minima must be from -infinity to the maxima, maxima up to +infinity.
        let below = v.above32(v.splat(NEGATIVE_INFINITY as u32), minima);
        let above = v.above32(maxima, v.splat(POSITIVE_INFINITY as u32));
        let bad = v.or(v.above32(minima, maxima), v.or(below, above));
        if v.any_of_three(bad) { None } else { Some(found) }
    }

    /// As [`KeyBox::overlaps`].
    #[inline(always)]
    pub(super) fn overlap(self, v: V, other: Self) -> bool {
        let apart = v.or(v.above32(self.first, other.maxima(v)), v.above32(other.first, self.maxima(v)));
        !v.any_of_three(apart)
    }

    /// As [`KeyBox::is_narrow`].
    #[inline(always)]
    pub(super) fn is_narrow(self, v: V) -> bool {
        let apart = v.minus32(self.maxima(v), self.first);
        let few = v.equal32(apart, v.least32(apart, v.splat(3)));
        v.any_of_three(few)
    }

    /// As [`Simd::record`](crate::simd::Simd::record).
    #[inline(always)]
    pub(super) fn record(self, v: V, frame: &Frame, tag: u32) -> Record {
        let (origins, scales) = (ends(six(&frame.origin)), ends(six(&frame.scale)));
        let mut at = [self.first, self.last];
        for (half, at) in at.iter_mut().enumerate() {
            *at = v.multiply(v.subtract(v.floats(*at), v.load(origins[half])), v.load(scales[half]));
        }
        let lanes = v.shuffle(v.steps16(at[0], at[1]), v.load(&SIX_LANES));
        let mut bytes = [0; 16];
        // Maxima are complemented.
        let lanes = v.xor(lanes, v.words([0, 0xffff_0000, u32::MAX, 0]));
        v.store(&mut bytes, v.with_fourth(lanes, tag));
        bytemuck::cast(bytes)
    }
}
