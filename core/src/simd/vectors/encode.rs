//! The keys of four boxes at a time.
//!
//! Each half of three vectors has the twelve numbers of two boxes: the first one of a box to the first of its
//! maxima; its other two maxima and the first two minima of the next box; the rest of that.

use super::operations::{Halves, NO_BYTE, places};
use crate::geometry::boxes::Four;
use crate::geometry::key::{KeyBox, POSITIVE_INFINITY};

/// The places of the bytes of two boxes, six each, as lanes of eight bytes.
const SIX_EACH: [u8; 16] = [0, 1, 2, 3, 4, 5, NO_BYTE, NO_BYTE, 6, 7, 8, 9, 10, 11, NO_BYTE, NO_BYTE];

/// Where minima stand in these vectors.
const MINIMA: [[u32; 4]; 3] =
    [[u32::MAX, u32::MAX, u32::MAX, 0], [0, 0, u32::MAX, u32::MAX], [u32::MAX, 0, 0, 0]];

/// The 24 numbers of four boxes.
#[inline(always)]
fn numbers<W: Halves>(w: W, boxes: Four<'_>) -> [W::Vector; 3] {
    match boxes {
        Four::Packed(boxes) => three(w, bytemuck::cast_ref(boxes)),
        Four::Padded(boxes) => {
            let [a, b]: &[[[u8; 16]; 4]; 2] = bytemuck::cast_ref(boxes);
            let (min, max) = (w.pick(&a[0], &b[0]), w.pick(&a[1], &b[1]));
            let (next_min, next_max) = (w.pick(&a[2], &b[2]), w.pick(&a[3], &b[3]));
            let max = w.shuffle(max, w.both(&places([1, 2, 2, 0])));
            let third = w.shuffle(next_min, w.both(&places([2; 4])));
            [
                w.select(w.words([u32::MAX, u32::MAX, u32::MAX, 0]), min, max),
                w.zip_first64(max, next_min),
                w.fourth_on(third, next_max),
            ]
        }
    }
}

/// The three vectors of 96 bytes.
#[inline(always)]
fn three<W: Halves>(w: W, [a, b, c, d, e, f]: &[[u8; 16]; 6]) -> [W::Vector; 3] {
    [w.pick(a, d), w.pick(b, e), w.pick(c, f)]
}

/// As [`Simd::encode_four`](crate::simd::Simd::encode_four).
#[inline(always)]
pub(super) fn encode_four<W: Halves>(
    w: W,
    boxes: Four<'_>,
    held: Option<(&[KeyBox; 4], bool)>,
    old: &[KeyBox; 4],
    new: &mut [KeyBox; 4],
) -> Option<(u32, bool)> {
    let [a, b, c] = numbers(w, boxes);
    let (a, b, c) = (w.keys(a), w.keys(b), w.keys(c));
    let [old_a, old_b, old_c] = three(w, bytemuck::cast_ref(old));
    // The minima and the maxima of the first box, then of the second one. Nothing behind them counts.
    let first = above(w, a, w.fourth_on(a, b));
    let second_minima = w.zip_first64(w.shuffle(b, w.both(&places([2, 3, 2, 3]))), c);
    let second = above(w, second_minima, w.shuffle(c, w.both(&places([1, 2, 3, 0]))));
    let upside_down = w.and(w.or(first, second), w.words([u32::MAX, u32::MAX, u32::MAX, 0]));
    // No key of an object is above +infinity, but the first one of an empty box is.
    let empty = above(w, w.upper32(old_a, old_b), w.splat(POSITIVE_INFINITY as u32));
    let wrong = w.or(upside_down, empty);
    let (are_held, must) = match held {
        Some((held, must)) => (!w.any(w.or(wrong, outside(w, [a, b, c], held))), must),
        None => (false, false),
    };
    if !are_held && (must || w.any(w.or(wrong, outside(w, [a, b, c], &[KeyBox::ALL; 4])))) {
        return None;
    }
    let [first, second, third, fourth, fifth, sixth]: &mut [[u8; 16]; 6] = bytemuck::cast_mut(new);
    w.put(first, fourth, a);
    w.put(second, fifth, b);
    w.put(third, sixth, c);
    // Two bytes for each two keys, zero if they are the same.
    let (a, b, c) = (w.xor(a, old_a), w.xor(b, old_b), w.xor(c, old_c));
    let others = w.join16(w.join16(a, b), w.join16(c, c));
    Some((!w.zeros64(w.shuffle(others, w.both(&SIX_EACH))) & 0b1111, are_held))
}

/// Not zero where `a` is above `b`. The compiler makes ten operations more of a test of comparisons.
#[inline(always)]
fn above<W: Halves>(w: W, a: W::Vector, b: W::Vector) -> W::Vector {
    w.xor(w.upper32(a, b), b)
}

/// Not zero where the keys of four boxes are outside of other boxes.
#[inline(always)]
fn outside<W: Halves>(w: W, keys: [W::Vector; 3], held: &[KeyBox; 4]) -> W::Vector {
    let (held, mut outside) = (three(w, bytemuck::cast_ref(held)), w.splat(0));
    for k in 0..3 {
        let inner = w.select(w.words(MINIMA[k]), keys[k], held[k]);
        outside = w.or(outside, w.xor(w.upper32(keys[k], held[k]), inner));
    }
    outside
}
