//! Tests four pairs at a time, with 128-bit vectors.

use super::vectors::Vectors;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};

/// Which of four pairs overlap.
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
pub(super) unsafe fn four_overlap<V: Vectors, I: Index>(
    v: V,
    boxes: &[KeyBox],
    [p, q, r, s]: &[Pair<I>; 4],
) -> u32 {
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
