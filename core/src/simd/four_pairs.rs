//! Tests and divides four pairs at a time, with 256-bit integers of x86-64.

use super::detect::Avx2;
use super::each_overlap;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use core::arch::x86_64::*;

/// For each mask of four pairs: the 32-bit halves of those that it has, in order, and then of others.
const FRONT: [[u32; 8]; 16] = places(false);

/// For each mask of four pairs: the halves of those that it has not, the first one last.
const BACK: [[u32; 8]; 16] = places(true);

const fn places(back: bool) -> [[u32; 8]; 16] {
    let mut table = [[0; 8]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut pair, mut count) = (0, 0);
        while pair < 4 {
            if (mask >> pair & 1 == 0) == back {
                let place = if back { 3 - count } else { count };
                table[mask][2 * place] = 2 * pair as u32;
                table[mask][2 * place + 1] = 2 * pair as u32 + 1;
                count += 1;
            }
            pair += 1;
        }
        mask += 1;
    }
    table
}

/// The same for pairs of 32 bits.
const fn narrow(wide: [[u32; 8]; 16]) -> [[u32; 4]; 16] {
    let mut table = [[0; 4]; 16];
    let mut mask = 0;
    while mask < 16 {
        let mut pair = 0;
        while pair < 4 {
            table[mask][pair] = wide[mask][2 * pair] / 2;
            pair += 1;
        }
        mask += 1;
    }
    table
}

const NARROW_FRONT: [[u32; 4]; 16] = narrow(FRONT);
const NARROW_BACK: [[u32; 4]; 16] = narrow(BACK);

/// As [`Simd::overlaps`](super::Simd::overlaps).
#[inline(always)]
pub(super) fn overlaps<I: Index>(simd: Avx2, boxes: &[KeyBox], pairs: &[Pair<I>; 4]) -> u32 {
    // Boxes are read with the eight bytes behind them, which the last one has not.
    let last = boxes.len().saturating_sub(1);
    // SAFETY: `simd` proves AVX2. Four pairs are 16 bytes of narrow slots and 32 of wide ones.
    let beyond = unsafe {
        if size_of::<I>() == 2 {
            let slots = _mm_loadu_si128(pairs.as_ptr().cast());
            let last = _mm_set1_epi16(last.min(u16::MAX.into()) as i16);
            let beyond = _mm_cmpeq_epi16(_mm_max_epu16(slots, last), slots);
            _mm_movemask_epi8(beyond)
        } else {
            let slots = _mm256_loadu_si256(pairs.as_ptr().cast());
            let last = _mm256_set1_epi32(last.min(u32::MAX as usize) as i32);
            let beyond = _mm256_cmpeq_epi32(_mm256_max_epu32(slots, last), slots);
            _mm256_movemask_epi8(beyond)
        }
    };
    if beyond != 0 {
        return each_overlap(simd, boxes, pairs);
    }
    // SAFETY: `simd` proves AVX2; all slots are below the last one.
    unsafe {
        let [p, q, r, s] = pairs;
        let first = _mm256_packs_epi32(apart(simd, boxes, p), apart(simd, boxes, q));
        let second = _mm256_packs_epi32(apart(simd, boxes, r), apart(simd, boxes, s));
        // Four bytes of each pair in the lower half, of its first four keys, and four in the upper half, of which two mean
        // nothing.
        let bytes = _mm256_packs_epi16(first, second);
        let upper = _mm_and_si128(_mm256_extracti128_si256::<1>(bytes), _mm_set1_epi32(0xffff));
        let all = _mm_or_si128(_mm256_castsi256_si128(bytes), upper);
        let overlapping = _mm_cmpeq_epi32(all, _mm_setzero_si128());
        _mm_movemask_ps(_mm_castsi128_ps(overlapping)) as u32
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

/// As [`Simd::part`](super::Simd::part).
#[inline(always)]
pub(super) fn part<I: Index>(_: Avx2, pairs: &[Pair<I>; 4], stay: u32, gap: &mut [Pair<I>]) {
    let mask = (stay & 15) as usize;
    // SAFETY: the token proves AVX2. Four pairs are 16 bytes of narrow slots and 32 of wide ones, here and at either end.
    unsafe {
        if size_of::<I>() == 2 {
            let pairs = _mm_loadu_ps(pairs.as_ptr().cast());
            let front = _mm_permutevar_ps(pairs, bytemuck::cast(NARROW_FRONT[mask]));
            let back = _mm_permutevar_ps(pairs, bytemuck::cast(NARROW_BACK[mask]));
            if let Some(to) = gap.first_chunk_mut::<4>() {
                _mm_storeu_ps(to.as_mut_ptr().cast(), front);
            }
            if let Some(to) = gap.last_chunk_mut::<4>() {
                _mm_storeu_ps(to.as_mut_ptr().cast(), back);
            }
        } else {
            let pairs = _mm256_loadu_si256(pairs.as_ptr().cast());
            let front = _mm256_permutevar8x32_epi32(pairs, bytemuck::cast(FRONT[mask]));
            let back = _mm256_permutevar8x32_epi32(pairs, bytemuck::cast(BACK[mask]));
            if let Some(to) = gap.first_chunk_mut::<4>() {
                _mm256_storeu_si256(to.as_mut_ptr().cast(), front);
            }
            if let Some(to) = gap.last_chunk_mut::<4>() {
                _mm256_storeu_si256(to.as_mut_ptr().cast(), back);
            }
        }
    }
}
