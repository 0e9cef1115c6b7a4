//! The six keys of a box in two vectors of four.

use super::vectors::{NO_BYTE, Vectors};
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY};
use crate::geometry::record::{Frame, GRID_MAX, Record};

/// The lanes of three axes.
const FIRST_THREE: [u32; 4] = [u32::MAX, u32::MAX, u32::MAX, 0];

/// The places of the second to the fourth word, the last one twice.
const FROM_SECOND: [u8; 16] = [4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 12, 13, 14, 15];

/// The places of the first three words, the last one twice.
const FROM_FIRST: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 8, 9, 10, 11];

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

/// The floats of four keys.
#[inline(always)]
pub(super) fn floats<V: Vectors>(v: V, keys: V::Vector) -> V::Vector {
    v.or(v.magnitude32(keys), v.and(keys, v.splat(1 << 31)))
}

/// The keys of four floats.
#[inline(always)]
fn keys<V: Vectors>(v: V, bits: V::Vector) -> V::Vector {
    let negative = v.above32(v.splat(0), bits);
    // The magnitude with the sign, which turns -0.0 into zero.
    let magnitude = v.and(bits, v.splat(i32::MAX as u32));
    v.minus32(v.xor(magnitude, negative), negative)
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

    /// The maxima on the three axes, the last one twice.
    #[inline(always)]
    pub(super) fn maxima(self, v: V) -> V::Vector {
        v.shuffle(self.last, v.load(&FROM_SECOND))
    }

    /// As [`Simd::encode`](crate::simd::Simd::encode).
    #[inline(always)]
    pub(super) fn encode(v: V, min: &[u8; 12], max: &[u8; 12]) -> Option<Self> {
        let [a, b, c]: [u32; 3] = bytemuck::cast(*min);
        let [d, e, f]: [u32; 3] = bytemuck::cast(*max);
        let found = Self { first: keys(v, v.words([a, b, c, d])), last: keys(v, v.words([c, d, e, f])) };
        let (minima, maxima) = (v.shuffle(found.first, v.load(&FROM_FIRST)), found.maxima(v));
        // Minima must be from -infinity to the maxima, maxima up to +infinity.
        let below = v.above32(v.splat(NEGATIVE_INFINITY as u32), minima);
        let above = v.above32(maxima, v.splat(POSITIVE_INFINITY as u32));
        let bad = v.or(v.above32(minima, maxima), v.or(below, above));
        if v.any(bad) { None } else { Some(found) }
    }

    /// As [`KeyBox::overlaps`].
    #[inline(always)]
    pub(super) fn overlap(self, v: V, other: Self) -> bool {
        let apart = v.or(v.above32(self.first, other.maxima(v)), v.above32(other.first, self.maxima(v)));
        !v.any(v.and(apart, v.words(FIRST_THREE)))
    }

    /// As [`KeyBox::is_narrow`].
    #[inline(always)]
    pub(super) fn is_narrow(self, v: V) -> bool {
        let apart = v.minus32(self.maxima(v), self.first);
        let few = v.equal32(apart, v.least32(apart, v.splat(3)));
        v.any(v.and(few, v.words(FIRST_THREE)))
    }

    /// As [`Simd::record`](crate::simd::Simd::record).
    #[inline(always)]
    pub(super) fn record(self, v: V, frame: &Frame, tag: u32) -> Record {
        let (origins, scales) = (ends(six(&frame.origin)), ends(six(&frame.scale)));
        let mut steps = [self.first, self.last];
        for (half, keys) in steps.iter_mut().enumerate() {
            let at = v.subtract(floats(v, *keys), v.load(origins[half]));
            let at = v.multiply(at, v.load(scales[half]));
            // NaN falls to the second operand: zero.
            let at = v.minimum(v.maximum(at, v.splat(0)), v.splat(GRID_MAX.to_bits()));
            *keys = v.whole(at);
        }
        let [first, last] = steps;
        let lanes = v.shuffle(v.lower_halves(first, last), v.load(&SIX_LANES));
        let mut bytes = [0; 16];
        // Maxima are complemented.
        v.store(&mut bytes, v.xor(lanes, v.words([0, 0xffff_0000, u32::MAX, tag])));
        bytemuck::cast(bytes)
    }
}
