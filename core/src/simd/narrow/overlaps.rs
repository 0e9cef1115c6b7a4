//! Tests four pairs at a time, with 128-bit vectors.

use super::vectors::Vectors;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::simd::{Simd, each_overlap};

/// As [`Simd::overlaps`].
#[inline(always)]
pub(super) fn overlaps<V: Vectors, S: Simd, I: Index>(
    v: V,
    simd: S,
    boxes: &[KeyBox],
    pairs: &[Pair<I>],
) -> usize {
    let (fours, rest) = pairs.as_chunks();
    // Boxes are read with the word behind them, which the last one has not. Asked once for all pairs.
    let Some(most) = boxes.len().checked_sub(2).filter(|most| !any_above(v, fours, *most)) else {
        return each_overlap(simd, boxes, pairs);
    };
    debug_assert!(fours.as_flattened().iter().flatten().all(|slot| slot.at() <= most));
    let mut bits = 0;
    for (index, four) in fours.iter().enumerate() {
        // SAFETY: behind the box of each slot there is another one.
        bits |= (unsafe { four_overlap(v, boxes, four) } as usize) << (4 * index);
    }
    if rest.is_empty() { bits } else { bits | each_overlap(simd, boxes, rest) << (4 * fours.len()) }
}

/// Whether a slot is above a number.
#[inline(always)]
fn any_above<V: Vectors, I: Index>(v: V, fours: &[[Pair<I>; 4]], most: usize) -> bool {
    let vectors: &[[u8; 16]] = bytemuck::cast_slice(fours.as_flattened());
    let mut all = v.splat(0);
    if size_of::<I>() == 2 {
        let most = u16::try_from(most).unwrap_or(u16::MAX);
        let most = v.splat(u32::from(most) * 0x1_0001);
        for vector in vectors {
            all = v.or(all, v.excess16(v.load(vector), most));
        }
        v.any(all)
    } else {
        let most = v.splat(u32::try_from(most).unwrap_or(u32::MAX));
        for vector in vectors {
            all = v.most32(all, v.load(vector));
        }
        v.any(v.xor(v.most32(all, most), most))
    }
}

/// Which of four pairs overlap.
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
unsafe fn four_overlap<V: Vectors, I: Index>(v: V, boxes: &[KeyBox], [p, q, r, s]: &[Pair<I>; 4]) -> u32 {
    // SAFETY: the caller vouches for the slots.
    let (first, last) = unsafe {
        (v.join16(apart(v, boxes, p), apart(v, boxes, q)), v.join16(apart(v, boxes, r), apart(v, boxes, s)))
    };
    // Four bytes of each pair, of which the last one means nothing.
    let all = v.and(v.join8(first, last), v.splat(0x00ff_ffff));
    v.bits4(v.equal32(all, v.splat(0)))
}

/// The axes on which the boxes of a pair are apart. The last lane means nothing.
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
unsafe fn apart<V: Vectors, I: Index>(v: V, boxes: &[KeyBox], pair: &Pair<I>) -> V::Vector {
    // SAFETY: the caller vouches for the slots.
    let ([a_min, a_max], [b_min, b_max]) =
        unsafe { (sides(v, boxes, pair[0].at()), sides(v, boxes, pair[1].at())) };
    v.or(v.above32(a_min, b_max), v.above32(b_min, a_max))
}

/// The minima and the maxima of a box, with a word more each.
///
/// # Safety
/// Behind the box there must be another one.
#[inline(always)]
unsafe fn sides<V: Vectors>(v: V, boxes: &[KeyBox], at: usize) -> [V::Vector; 2] {
    // SAFETY: a box is 24 bytes, three minima and three maxima; 28 bytes from its start on are read, all of them in the slice.
    unsafe {
        let bytes: *const u8 = boxes.as_ptr().add(at).cast();
        [v.load(&*bytes.cast()), v.load(&*bytes.add(12).cast())]
    }
}
