//! Tests eight pairs at a time, with 256-bit integers of x86-64.

use super::detect::Avx2;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use core::arch::x86_64::*;

/// As [`Simd::eight_overlap`](super::Simd::eight_overlap).
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
pub(super) unsafe fn eight_overlap<I: Index>(simd: Avx2, boxes: &[KeyBox], pairs: &[Pair<I>; 8]) -> u32 {
    let [a, b, c, d, e, f, g, h] = pairs;
    // SAFETY: the token proves AVX2; the caller vouches for the slots.
    unsafe {
        let first = four_apart(simd, boxes, [a, b, c, d]);
        let second = four_apart(simd, boxes, [e, f, g, h]);
        // Four bytes of each pair: of its first four keys, and of the others, of which two mean nothing.
        let four = _mm256_permute2x128_si256::<0x20>(first, second);
        let others = _mm256_permute2x128_si256::<0x31>(first, second);
        let all = _mm256_or_si256(four, _mm256_and_si256(others, _mm256_set1_epi32(0xffff)));
        let overlapping = _mm256_cmpeq_epi32(all, _mm256_setzero_si256());
        _mm256_movemask_ps(_mm256_castsi256_ps(overlapping)) as u32
    }
}

/// The keys by which four pairs are apart: four bytes of each pair in the lower half, and four in the upper one.
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
unsafe fn four_apart<I: Index>(simd: Avx2, boxes: &[KeyBox], [a, b, c, d]: [&Pair<I>; 4]) -> __m256i {
    // SAFETY: the token proves AVX2; the caller vouches for the slots.
    unsafe {
        let first = _mm256_packs_epi32(apart(simd, boxes, a), apart(simd, boxes, b));
        let second = _mm256_packs_epi32(apart(simd, boxes, c), apart(simd, boxes, d));
        _mm256_packs_epi16(first, second)
    }
}

/// The keys by which two boxes are apart. The last two mean nothing.
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
unsafe fn apart<I: Index>(_: Avx2, boxes: &[KeyBox], pair: &Pair<I>) -> __m256i {
    // SAFETY: the token proves AVX2; a box is 24 bytes, and there is another one behind it, of which eight are read.
    unsafe {
        let a = _mm256_loadu_si256(boxes.as_ptr().add(pair[0].at()).cast());
        let b = _mm256_loadu_si256(boxes.as_ptr().add(pair[1].at()).cast());
        let across = _mm256_permutevar8x32_epi32(b, _mm256_setr_epi32(3, 4, 5, 0, 1, 2, 6, 7));
        let minima = _mm256_blend_epi32::<0b111000>(a, across);
        let maxima = _mm256_blend_epi32::<0b111000>(across, a);
        _mm256_cmpgt_epi32(minima, maxima)
    }
}
