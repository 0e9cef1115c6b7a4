//! The keys of four boxes at a time, with 128-bit vectors.
//!
//! Two boxes are three vectors: the first number of one box to the first of its maxima; its other two maxima and the first two
//! minima of the next box; the rest of that.

use super::keys::FROM_SECOND;
use super::vectors::{NO_BYTE, Vectors};
use crate::geometry::boxes::Four;
use crate::geometry::key::{KeyBox, POSITIVE_INFINITY};

/// The places of the second and the third word, the third again, and the first one.
const FIRST_BEHIND: [u8; 16] = [4, 5, 6, 7, 8, 9, 10, 11, 8, 9, 10, 11, 0, 1, 2, 3];

/// The places of the bytes of four boxes, three each, in a word for each.
const THREE_EACH: [u8; 16] = [0, 1, 2, NO_BYTE, 3, 4, 5, NO_BYTE, 6, 7, 8, NO_BYTE, 9, 10, 11, NO_BYTE];

/// The 24 numbers of four boxes.
#[inline(always)]
fn numbers<V: Vectors>(v: V, boxes: Four<'_>) -> [V::Vector; 6] {
    match boxes {
        Four::Packed(boxes) => {
            let [a, b, c, d, e, f]: &[[u8; 16]; 6] = bytemuck::cast_ref(boxes);
            [v.load(a), v.load(b), v.load(c), v.load(d), v.load(e), v.load(f)]
        }
        Four::Padded(boxes) => {
            let [first, last]: &[[[u8; 16]; 4]; 2] = bytemuck::cast_ref(boxes);
            let ([a, b, c], [d, e, f]) = (packed(v, first), packed(v, last));
            [a, b, c, d, e, f]
        }
    }
}

/// The twelve numbers of the padded corners of two boxes.
#[inline(always)]
fn packed<V: Vectors>(v: V, [min, max, next_min, next_max]: &[[u8; 16]; 4]) -> [V::Vector; 3] {
    let (min, max, next_min, next_max) = (v.load(min), v.load(max), v.load(next_min), v.load(next_max));
    let max = v.shuffle(max, v.load(&FIRST_BEHIND));
    let third = v.shuffle(next_min, v.splat(0x0b0a_0908));
    [v.three_and_last(min, max), v.zip_first64(max, next_min), v.fourth_on(third, next_max)]
}

/// As [`Simd::encode_four`](crate::simd::Simd::encode_four).
#[inline(always)]
pub(super) fn encode_four<V: Vectors>(
    v: V,
    boxes: Four<'_>,
    held: &[KeyBox; 4],
    old: &[KeyBox; 4],
    new: &mut [KeyBox; 4],
) -> Option<u32> {
    let [a, b, c, d, e, f] = numbers(v, boxes);
    let (a, b, c) = (v.keys(a), v.keys(b), v.keys(c));
    let (d, e, f) = (v.keys(d), v.keys(e), v.keys(f));
    let [held, old]: [&[[u8; 16]; 6]; 2] = [held, old].map(bytemuck::cast_ref);
    let (old_a, old_b, old_c) = (v.load(&old[0]), v.load(&old[1]), v.load(&old[2]));
    let (old_d, old_e, old_f) = (v.load(&old[3]), v.load(&old[4]), v.load(&old[5]));
    // The minima of each box and, behind them, another key of a box; the maxima likewise.
    let minima = [a, v.third_on(b, c), d, v.third_on(e, f)];
    let from_second = v.load(&FROM_SECOND);
    let maxima = [v.fourth_on(a, b), v.shuffle(c, from_second), v.fourth_on(d, e), v.shuffle(f, from_second)];
    let mut bad = v.above32(minima[0], maxima[0]);
    for k in 1..4 {
        bad = v.or(bad, v.above32(minima[k], maxima[k]));
    }
    // What stands behind the three minima or maxima of a box means nothing.
    let mut bad = v.and(bad, v.words([u32::MAX, u32::MAX, u32::MAX, 0]));
    let minima = [[u32::MAX, u32::MAX, u32::MAX, 0], [0, 0, u32::MAX, u32::MAX], [u32::MAX, 0, 0, 0]];
    for (k, keys) in [a, b, c, d, e, f].into_iter().enumerate() {
        let (held, minima) = (v.load(&held[k]), v.words(minima[k % 3]));
        let (low, high) = (v.select(minima, keys, held), v.select(minima, held, keys));
        bad = v.or(bad, v.above32(high, low));
    }
    // No key of an object is above +infinity, but the first one of an empty box is.
    let highest_old = v.upper32(v.upper32(old_a, old_b), v.upper32(old_d, old_e));
    if v.any(v.or(bad, v.above32(highest_old, v.splat(POSITIVE_INFINITY as u32)))) {
        return None;
    }
    let to: &mut [[u8; 16]; 6] = bytemuck::cast_mut(new);
    for (to, keys) in to.iter_mut().zip([a, b, c, d, e, f]) {
        v.store(to, keys);
    }
    // A lane of 16 bits for each key, zero if it is the same.
    let first = v.join16(v.xor(a, old_a), v.xor(b, old_b));
    let second = v.join16(v.xor(c, old_c), v.xor(d, old_d));
    let third = v.join16(v.xor(e, old_e), v.xor(f, old_f));
    // A byte for each two keys, so three for each box.
    let bytes = v.join8(v.join16(first, second), v.join16(third, third));
    let same = v.equal32(v.shuffle(bytes, v.load(&THREE_EACH)), v.splat(0));
    Some(!v.bits4(same) & 0b1111)
}
