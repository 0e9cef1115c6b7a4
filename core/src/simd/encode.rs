//! The keys of boxes, of one or of four at a time, with 256-bit integers of x86-64.

use super::detect::Avx2;
use crate::geometry::boxes::Four;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY};
use core::arch::x86_64::*;

/// The keys of eight floats: the magnitude with the sign, which turns -0.0 into zero. A plain function, since a closure would
/// not share the instruction set of its function.
#[inline(always)]
pub(super) fn keys(_: Avx2, bits: __m256i) -> __m256i {
    // SAFETY: the token proves AVX2.
    unsafe { _mm256_sign_epi32(_mm256_and_si256(bits, _mm256_set1_epi32(i32::MAX)), bits) }
}

/// As [`Simd::encode`](super::Simd::encode).
#[inline(always)]
pub(super) fn encode(simd: Avx2, min: &[u8; 12], max: &[u8; 12]) -> Option<__m256i> {
    // SAFETY: the token proves AVX2; each read stays inside one of the arrays of 12 bytes.
    unsafe {
        let [_, _, z]: [i32; 3] = bytemuck::cast(*min);
        let [x, _, _]: [i32; 3] = bytemuck::cast(*max);
        let first = _mm_loadl_epi64(min.as_ptr().cast());
        let first = _mm_insert_epi32::<3>(_mm_insert_epi32::<2>(first, z), x);
        let bits = _mm256_set_m128i(_mm_loadl_epi64(max.as_ptr().add(4).cast()), first);
        let keys = keys(simd, bits);
        // Minima from -infinity to the maxima, maxima to +infinity.
        let maxima = _mm256_permutevar8x32_epi32(keys, _mm256_setr_epi32(3, 4, 5, 6, 6, 6, 6, 6));
        let (low, high) = (NEGATIVE_INFINITY, POSITIVE_INFINITY);
        let least = _mm256_setr_epi32(low, low, low, i32::MIN, i32::MIN, i32::MIN, 0, 0);
        let most = _mm256_blend_epi32::<0b111000>(maxima, _mm256_set1_epi32(high));
        let bad = _mm256_or_si256(_mm256_cmpgt_epi32(least, keys), _mm256_cmpgt_epi32(keys, most));
        // By their signs: of a test of all bits the compiler makes two operations here.
        (_mm256_movemask_ps(_mm256_castsi256_ps(bad)) == 0).then_some(keys)
    }
}

/// All ones in some lane where a box is not inside the held one, a minimum is above its maximum, or an old box is empty: its first key
/// is above +infinity. `MAXIMA` has a bit for each lane of a maximum. A plain function for the same reason.
#[inline(always)]
fn bad<const MAXIMA: i32>(_: Avx2, keys: __m256i, maxima: __m256i, held: __m256i, old: __m256i) -> __m256i {
    // SAFETY: the token proves AVX2.
    unsafe {
        let (low, high) =
            (_mm256_blend_epi32::<MAXIMA>(keys, held), _mm256_blend_epi32::<MAXIMA>(held, keys));
        let upside_down = _mm256_cmpgt_epi32(keys, _mm256_blend_epi32::<MAXIMA>(maxima, keys));
        let empty = _mm256_cmpgt_epi32(old, _mm256_set1_epi32(POSITIVE_INFINITY));
        _mm256_or_si256(_mm256_cmpgt_epi32(high, low), _mm256_or_si256(upside_down, empty))
    }
}

/// A bit for each lane that is the same. A plain function for the same reason.
#[inline(always)]
fn same(_: Avx2, a: __m256i, b: __m256i) -> u32 {
    // SAFETY: the token proves AVX2.
    unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))) as u32 }
}

/// Eight lanes of two vectors: the lane of `a` at each place, or that of `b` where `B` has a bit. A plain function for the same
/// reason.
#[inline(always)]
fn lanes<const B: i32>(_: Avx2, a: __m256i, b: __m256i, [c, d, e, f, g, h, i, j]: [i32; 8]) -> __m256i {
    // SAFETY: the token proves AVX2.
    unsafe {
        let places = _mm256_setr_epi32(c, d, e, f, g, h, i, j);
        let (a, b) = (_mm256_permutevar8x32_epi32(a, places), _mm256_permutevar8x32_epi32(b, places));
        _mm256_blend_epi32::<B>(a, b)
    }
}

/// The 24 numbers of four boxes, and behind them, where a minimum stands, its maximum.
#[inline(always)]
fn numbers(simd: Avx2, boxes: Four<'_>) -> [__m256i; 6] {
    // SAFETY: the token proves AVX2. Four packed boxes are 96 bytes: each load of 32 starts at most 64 bytes from the first one.
    // Four padded ones are 128: at most 96.
    unsafe {
        match boxes {
            Four::Packed(boxes) => {
                let from = boxes.as_ptr();
                let c = _mm256_loadu_si256(from.add(64).cast());
                [
                    _mm256_loadu_si256(from.cast()),
                    _mm256_loadu_si256(from.add(32).cast()),
                    c,
                    // Three numbers further on.
                    _mm256_loadu_si256(from.add(12).cast()),
                    _mm256_loadu_si256(from.add(44).cast()),
                    _mm256_permutevar8x32_epi32(c, _mm256_setr_epi32(0, 0, 5, 6, 7, 0, 0, 0)),
                ]
            }
            Four::Padded(boxes) => {
                let from = boxes.as_ptr().cast::<__m256i>();
                let (a, b) = (_mm256_loadu_si256(from), _mm256_loadu_si256(from.add(1)));
                let (c, d) = (_mm256_loadu_si256(from.add(2)), _mm256_loadu_si256(from.add(3)));
                [
                    lanes::<0b1100_0000>(simd, a, b, [0, 1, 2, 4, 5, 6, 0, 1]),
                    lanes::<0b1111_0000>(simd, b, c, [2, 4, 5, 6, 0, 1, 2, 4]),
                    lanes::<0b1111_1100>(simd, c, d, [5, 6, 0, 1, 2, 4, 5, 6]),
                    lanes::<0b1100_0000>(simd, a, b, [4, 5, 6, 0, 0, 0, 4, 5]),
                    lanes::<0b1111_0000>(simd, b, c, [6, 0, 0, 0, 4, 5, 6, 0]),
                    lanes::<0b1111_1100>(simd, c, d, [0, 0, 4, 5, 6, 0, 0, 0]),
                ]
            }
        }
    }
}

/// As [`Simd::encode_four`](super::Simd::encode_four).
#[inline(always)]
pub(super) fn encode_four(
    simd: Avx2,
    boxes: Four<'_>,
    held: &[KeyBox; 4],
    old: &[KeyBox; 4],
    new: &mut [KeyBox; 4],
) -> Option<u32> {
    let [a, b, c, a_maxima, b_maxima, c_maxima] = numbers(simd, boxes);
    let (a, b, c) = (keys(simd, a), keys(simd, b), keys(simd, c));
    let (a_maxima, b_maxima, c_maxima) = (keys(simd, a_maxima), keys(simd, b_maxima), keys(simd, c_maxima));
    let held = held.as_ptr().cast::<__m256i>();
    let (from, to) = (old.as_ptr().cast::<__m256i>(), new.as_mut_ptr().cast::<__m256i>());
    // SAFETY: the token proves AVX2. Four boxes of keys are three times 32 bytes.
    unsafe {
        let (old_a, old_b) = (_mm256_loadu_si256(from), _mm256_loadu_si256(from.add(1)));
        let old_c = _mm256_loadu_si256(from.add(2));
        // A bit of each mask for each lane of a maximum.
        let bad_a = bad::<0b0011_1000>(simd, a, a_maxima, _mm256_loadu_si256(held), old_a);
        let bad_b = bad::<0b1000_1110>(simd, b, b_maxima, _mm256_loadu_si256(held.add(1)), old_b);
        let bad_c = bad::<0b1110_0011>(simd, c, c_maxima, _mm256_loadu_si256(held.add(2)), old_c);
        let bad = _mm256_or_si256(_mm256_or_si256(bad_a, bad_b), bad_c);
        if _mm256_movemask_ps(_mm256_castsi256_ps(bad)) != 0 {
            return None;
        }
        _mm256_storeu_si256(to, a);
        _mm256_storeu_si256(to.add(1), b);
        _mm256_storeu_si256(to.add(2), c);
        let same = same(simd, a, old_a) | same(simd, b, old_b) << 8 | same(simd, c, old_c) << 16;
        Some(changed_boxes(!same))
    }
}

/// Which of four boxes have changed, from a bit for each of their 24 keys; bits above these mean nothing.
#[inline(always)]
const fn changed_boxes(keys: u32) -> u32 {
    // The sixth bit of each box, set where any of its six is.
    const SIXTH: u32 = 0b100000_100000_100000_100000;
    const FIRST_FIVE: u32 = SIXTH - (SIXTH >> 5);
    let boxes = (((keys & FIRST_FIVE) + FIRST_FIVE) | keys) & SIXTH;
    // Those bits, 6 apart, side by side: the product has them at 18, 19, 20 and 21, and no two others in one place.
    (boxes >> 5).wrapping_mul(1 << 18 | 1 << 13 | 1 << 8 | 1 << 3) >> 18 & 0b1111
}
