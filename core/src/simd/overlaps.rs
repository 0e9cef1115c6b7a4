//! Tests eight pairs at a time, with 256-bit integers of x86-64.

use super::detect::Avx2;
use super::each_overlap;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use core::arch::x86_64::*;

/// As [`Simd::overlaps`](super::Simd::overlaps).
#[inline(always)]
pub(super) fn overlaps<I: Index>(simd: Avx2, boxes: &[KeyBox], pairs: &[Pair<I>]) -> usize {
    let (eights, rest) = pairs.as_chunks();
    // Boxes are read with the eight bytes behind them, which the last one has not. Asked once for all pairs, since a
    // branch for each eight takes half as long again as the tests.
    if any_from(simd, eights, boxes.len().saturating_sub(1)) {
        return each_overlap(simd, boxes, pairs);
    }
    let mut bits = 0;
    for (index, eight) in eights.iter().enumerate() {
        // SAFETY: all slots are below the last one.
        bits |= usize::from(unsafe { eight_overlap(simd, boxes, eight) }) << (8 * index);
    }
    if rest.is_empty() { bits } else { bits | each_overlap(simd, boxes, rest) << (8 * eights.len()) }
}

/// Whether a slot is at least `limit`.
#[inline(always)]
fn any_from<I: Index>(_: Avx2, eights: &[[Pair<I>; 8]], limit: usize) -> bool {
    let vectors: &[[u8; 32]] = bytemuck::cast_slice(eights.as_flattened());
    // SAFETY: the token proves AVX2; each vector is 32 bytes.
    unsafe {
        let mut most = _mm256_setzero_si256();
        if size_of::<I>() == 2 {
            for vector in vectors {
                most = _mm256_max_epu16(most, _mm256_loadu_si256(vector.as_ptr().cast()));
            }
            let limit = _mm256_set1_epi16(limit.min(u16::MAX.into()) as i16);
            _mm256_movemask_epi8(_mm256_cmpeq_epi16(_mm256_max_epu16(most, limit), most)) != 0
        } else {
            for vector in vectors {
                most = _mm256_max_epu32(most, _mm256_loadu_si256(vector.as_ptr().cast()));
            }
            let limit = _mm256_set1_epi32(limit.min(u32::MAX as usize) as i32);
            _mm256_movemask_epi8(_mm256_cmpeq_epi32(_mm256_max_epu32(most, limit), most)) != 0
        }
    }
}

/// Which of eight pairs overlap.
///
/// # Safety
/// All slots must be below the last one.
#[inline(always)]
unsafe fn eight_overlap<I: Index>(simd: Avx2, boxes: &[KeyBox], pairs: &[Pair<I>; 8]) -> u8 {
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
        _mm256_movemask_ps(_mm256_castsi256_ps(overlapping)) as u8
    }
}

/// The keys by which four pairs are apart: four bytes of each pair in the lower half, and four in the upper one.
///
/// # Safety
/// All slots must be below the last one.
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
/// Both slots must be below the last one.
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
