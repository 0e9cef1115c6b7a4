//! Four boxes at a time: their keys, and what they become if they go on.
//!
//! Each half of three vectors has the twelve numbers of two boxes: the first one of a box to the first of its
//! maxima; its other two maxima and the first two minima of the next box; the rest of that.

use super::operations::{Halves, NO_BYTE, places};
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{KeyBox, KeyFour, SHORTEST};

/// The places of the bytes of two boxes, six each, as lanes of eight bytes.
const SIX_EACH: [u8; 16] = [0, 1, 2, 3, 4, 5, NO_BYTE, NO_BYTE, 6, 7, 8, 9, 10, 11, NO_BYTE, NO_BYTE];

/// Where minima stand in these vectors.
pub(super) const MINIMA: [[u32; 4]; 3] =
    [[u32::MAX, u32::MAX, u32::MAX, 0], [0, 0, u32::MAX, u32::MAX], [u32::MAX, 0, 0, 0]];

/// Which way outwards is: minima go down.
pub(super) const OUTWARDS: [[u32; 4]; 3] =
    [[u32::MAX, u32::MAX, u32::MAX, 1], [1, 1, u32::MAX, u32::MAX], [u32::MAX, 1, 1, 1]];

/// The 24 numbers of four boxes, if there are as many.
#[inline(always)]
pub(super) fn numbers<W: Halves>(
    w: W,
    Boxes { bytes: items, stride, end, .. }: Boxes<'_>,
) -> Option<[W::Vector; 3]> {
    if stride == size_of::<KeyBox>() {
        return Some(three(w, bytemuck::cast_ref(items.first_chunk::<96>()?)));
    }
    if end < 16 || stride > items.len() / 3 || end > items.len() - 3 * stride {
        return None;
    }
    // SAFETY: of each item the first 16 bytes are read, and the last; the slice has four items.
    let corners = |a: usize, b: usize| unsafe {
        w.pick(&*items.as_ptr().add(a).cast(), &*items.as_ptr().add(b).cast())
    };
    let (min, max) = (corners(0, 2 * stride), corners(end - 16, 2 * stride + end - 16));
    let (next_min, next_max) =
        (corners(stride, 3 * stride), corners(stride + end - 16, 3 * stride + end - 16));
    // The maxima come last.
    let max = w.shuffle(max, w.both(&places([2, 3, 3, 1])));
    let third = w.shuffle(next_min, w.both(&places([2; 4])));
    let first = w.select(w.words(MINIMA[0]), min, max);
    Some([first, w.zip_first64(max, next_min), w.select(w.words(MINIMA[2]), third, next_max)])
}

/// The three vectors of 96 bytes.
#[inline(always)]
pub(super) fn three<W: Halves>(w: W, [a, b, c, d, e, f]: &[[u8; 16]; 6]) -> [W::Vector; 3] {
    [w.pick(a, d), w.pick(b, e), w.pick(c, f)]
}

#[inline(always)]
pub(super) fn put_three<W: Halves>(w: W, [x, y, z]: [W::Vector; 3], boxes: &mut KeyFour) {
    let [a, b, c, d, e, f]: &mut [[u8; 16]; 6] = bytemuck::cast_mut(boxes);
    w.put(a, d, x);
    w.put(b, e, y);
    w.put(c, f, z);
}

/// The minima and the maxima of the second of two boxes. Nothing behind them counts.
#[inline(always)]
pub(super) fn second<W: Halves>(w: W, b: W::Vector, c: W::Vector) -> [W::Vector; 2] {
    let minima = w.zip_first64(w.shuffle(b, w.both(&places([2, 3, 2, 3]))), c);
    [minima, w.shuffle(c, w.both(&places([1, 2, 3, 0])))]
}

/// Which of four boxes have nothing but zeros, a bit each.
#[inline(always)]
pub(super) fn zeros<W: Halves>(w: W, [a, b, c]: [W::Vector; 3]) -> u32 {
    // Two bytes for each two numbers, zero if these are.
    w.zeros64(w.shuffle(w.join16(w.join16(a, b), w.join16(c, c)), w.both(&SIX_EACH)))
}

/// Not zero where `a` is above `b`. The compiler makes ten operations more of a test of comparisons.
#[inline(always)]
pub(super) fn above<W: Halves>(w: W, a: W::Vector, b: W::Vector) -> W::Vector {
    w.xor(w.upper32(a, b), b)
}

/// Not zero where the keys of four boxes are outside of other boxes.
#[inline(always)]
pub(super) fn outside<W: Halves>(w: W, keys: [W::Vector; 3], held: &KeyFour) -> [W::Vector; 3] {
    let (held, mut outside) = (three(w, bytemuck::cast_ref(held)), keys);
    for k in 0..3 {
        let inner = w.select(w.words(MINIMA[k]), keys[k], held[k]);
        outside[k] = w.xor(w.upper32(keys[k], held[k]), inner);
    }
    outside
}

/// Which of the two boxes of a half the words of these vectors are of.
pub(super) const OWNERS: [[u8; 4]; 3] = [[0; 4], [0, 0, 1, 1], [1; 4]];

/// The smallest side of each of the two boxes of a half, by their numbers, that is neither flat nor unbounded;
/// zero if none is.
#[inline(always)]
pub(super) fn smallest<W: Halves>(w: W, [a, b, c]: [W::Vector; 3]) -> W::Vector {
    let [minima, maxima] = second(w, b, c);
    let (first, second) = (w.subtract(w.fourth_on(a, b), a), w.subtract(maxima, minima));
    // Two sides along the first axis and two along the second one; two along the third one.
    let (two, third) = (usable(w, w.zip_first32(first, second)), usable(w, w.zip_last32(first, second)));
    let least = w.minimum(w.minimum(two, w.shuffle(two, w.both(&places([2, 3, 2, 3])))), third);
    w.select(w.at_most(w.splat(f32::MAX.to_bits()), least), w.splat(0), least)
}

/// Sides that are neither flat nor unbounded, else the largest float.
#[inline(always)]
fn usable<W: Halves>(w: W, sides: W::Vector) -> W::Vector {
    let most = w.splat(f32::MAX.to_bits());
    w.minimum(w.select(w.at_most(w.splat(SHORTEST.to_bits()), sides), sides, most), most)
}
