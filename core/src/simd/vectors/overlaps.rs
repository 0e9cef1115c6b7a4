//! Tests pairs of boxes.

use super::operations::{Halves, Vectors};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};

/// Which of eight pairs of slots have overlapping boxes, a bit each.
///
/// # Safety
/// `boxes` must have the box of each slot, and another one behind it.
#[inline(always)]
pub(super) unsafe fn eight_overlap<W: Halves, I: Index>(w: W, boxes: &[KeyBox], pairs: &[Pair<I>; 8]) -> u32 {
    let [a, b, c, d, e, f, g, h] = pairs;
    // SAFETY: the caller vouches for the slots.
    let (first, last) = unsafe { (four_apart(w, boxes, [a, b, c, d]), four_apart(w, boxes, [e, f, g, h])) };
    // Four bytes of each pair, of which the last one means nothing.
    let ([a, b], [c, d]) = (w.split(first), w.split(last));
    let apart = w.and(w.joined(w.half().or(a, b), w.half().or(c, d)), w.splat(0x00ff_ffff));
    w.bits8(w.equal32(apart, w.splat(0)))
}

/// The axes on which either box of four pairs begins beyond the other: four bytes a pair in each half.
///
/// # Safety
/// `boxes` must have the box of each slot, and another one behind it.
#[inline(always)]
unsafe fn four_apart<W: Halves, I: Index>(w: W, boxes: &[KeyBox], [p, q, r, s]: [&Pair<I>; 4]) -> W::Vector {
    // SAFETY: the caller vouches for the slots.
    unsafe {
        let first = w.join16(apart(w, boxes, p), apart(w, boxes, q));
        w.join8(first, w.join16(apart(w, boxes, r), apart(w, boxes, s)))
    }
}

/// The same of one pair, as masks. The last lane of a half means nothing.
///
/// # Safety
/// `boxes` must have the box of each slot, and another one behind it.
#[inline(always)]
unsafe fn apart<W: Halves, I: Index>(w: W, boxes: &[KeyBox], [a, b]: &Pair<I>) -> W::Vector {
    // SAFETY: a box is 24 bytes; 32 bytes from its start on are read, all of them in the slice, as the caller
    // vouches.
    let boxes = unsafe { [a, b].map(|slot| &*boxes.as_ptr().add(slot.at()).cast()) };
    let [minima, maxima] = w.opposed(boxes);
    w.above32(minima, maxima)
}
