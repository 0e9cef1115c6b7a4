//! Tests four candidates at a time, with 256-bit integers of x86-64.

use super::detect::Avx2;
use crate::geometry::record::Record;
use crate::id::{Index, Pair};
use core::arch::x86_64::*;

/// The bytes of a record with the halves of its six lanes swapped, and its tag.
pub(super) const HALVES: [i8; 16] = [6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5, 12, 13, 14, 15];

/// For each mask of pairs 0, 2, 1 and 3: the places of the first halves of those that it keeps, in the order of the
/// pairs.
const KEPT: [[u32; 4]; 16] = {
    let mut table = [[0; 4]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut pair, mut kept) = (0, 0);
        while pair < 4 {
            let at = [0, 2, 1, 3][pair];
            if mask >> at & 1 != 0 {
                table[mask][kept] = 2 * at as u32;
                kept += 1;
            }
            pair += 1;
        }
        mask += 1;
    }
    table
};

/// The same for both halves.
const KEPT_WIDE: [[u32; 8]; 16] = {
    let mut table = [[0; 8]; 16];
    let mut mask = 0;
    while mask < 16 {
        let mut half = 0;
        while half < 8 {
            table[mask][half] = KEPT[mask][half / 2] + half as u32 % 2;
            half += 1;
        }
        mask += 1;
    }
    table
};

/// As [`Simd::four`](super::Simd::four).
#[inline(always)]
pub(super) fn four<I: Index>(
    simd: Avx2,
    sorted: &[Record],
    base: u32,
    bits: u64,
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
    let second = bits & bits.wrapping_sub(1);
    let third = second & second.wrapping_sub(1);
    let fourth = third & third.wrapping_sub(1);
    let first = base & 0xffff;
    let (p, q) = (first + bits.trailing_zeros(), first + second.trailing_zeros());
    let (r, s) = (first + third.trailing_zeros(), first + fourth.trailing_zeros());
    let at = base >> 16;
    if at.max(s) as usize >= sorted.len() {
        return None;
    }
    // SAFETY: `simd` proves AVX2; the positions of the bits ascend, and the last one is in the slice, as is `at`.
    unsafe {
        let limit = limit(simd, pick(simd, sorted, at, at));
        keep(simd, [pick(simd, sorted, p, q), pick(simd, sorted, r, s)], [limit, limit], pairs)
    }
}

/// As [`Simd::any_four`](super::Simd::any_four).
#[inline(always)]
pub(super) fn any_four<I: Index>(
    simd: Avx2,
    sorted: &[Record],
    candidates: &[u32; 4],
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
    let end = sorted.len().min(usize::from(u16::MAX)) as i16;
    // SAFETY: `simd` proves AVX2; the four candidates are 16 bytes, and all their halves are compared with the length before
    // they are taken for positions.
    unsafe {
        let positions = _mm_loadu_si128(candidates.as_ptr().cast());
        let beyond = _mm_cmpeq_epi16(_mm_max_epu16(positions, _mm_set1_epi16(end)), positions);
        if _mm_testz_si128(beyond, beyond) == 0 {
            return None;
        }
        let [p, q, r, s] = *candidates;
        let (a, b) = (pick(simd, sorted, p >> 16, q >> 16), pick(simd, sorted, r >> 16, s >> 16));
        let (c, d) = (pick(simd, sorted, p & 0xffff, q & 0xffff), pick(simd, sorted, r & 0xffff, s & 0xffff));
        keep(simd, [a, b], [limit(simd, c), limit(simd, d)], pairs)
    }
}

/// Two records, side by side.
///
/// # Safety
/// The positions must be in the slice.
#[inline(always)]
unsafe fn pick(_: Avx2, records: &[Record], a: u32, b: u32) -> __m256i {
    let start: *const __m128i = records.as_ptr().cast();
    // SAFETY: the caller vouches for the positions; the token proves AVX2.
    unsafe { _mm256_loadu2_m128i(start.add(b as usize), start.add(a as usize)) }
}

/// The limits of two records: what the lanes of another record must not exceed to touch them; and the tags as they
/// are.
#[inline(always)]
fn limit(_: Avx2, records: __m256i) -> __m256i {
    // SAFETY: the token proves AVX2.
    unsafe {
        let halves = _mm256_shuffle_epi8(records, _mm256_broadcastsi128_si256(bytemuck::cast(HALVES)));
        _mm256_xor_si256(halves, _mm256_setr_epi32(-1, -1, -1, 0, -1, -1, -1, 0))
    }
}

/// By how much two records exceed the limits of two others, and the marks that they share: zero in both halves of a
/// pair that is reported here.
#[inline(always)]
fn excess(_: Avx2, records: __m256i, limit: __m256i) -> __m256i {
    // SAFETY: the token proves AVX2.
    unsafe {
        let marks = _mm256_set1_epi32(Record::MARKS as i32);
        let shared = _mm256_and_si256(_mm256_and_si256(records, limit), marks);
        _mm256_blend_epi32::<0b1000_1000>(_mm256_subs_epu16(records, limit), shared)
    }
}

/// Writes the pairs of four records with those of the limits, as far as they touch, and returns how many do. `None`
/// if only the keys can decide one of the four.
#[inline(always)]
fn keep<I: Index>(
    simd: Avx2,
    [a, b]: [__m256i; 2],
    [first, second]: [__m256i; 2],
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
    // SAFETY: the token proves AVX2. The pairs are four of two slots each, 16 bytes of narrow ones and 32 of wide ones.
    unsafe {
        let ties = _mm256_or_si256(_mm256_cmpeq_epi16(a, first), _mm256_cmpeq_epi16(b, second));
        // Ties of the tags do not count. Of a test with a mask the compiler makes four operations.
        if _mm256_movemask_epi8(ties) & 0x0fff_0fff != 0 {
            return None;
        }
        // The packing interleaves the halves of the vectors: the order is 0, 2, 1, 3 from here on.
        let apart = _mm256_packs_epi16(excess(simd, a, first), excess(simd, b, second));
        let kept = _mm256_cmpeq_epi64(apart, _mm256_setzero_si256());
        let kept = _mm256_movemask_pd(_mm256_castsi256_pd(kept)) as usize & 15;
        // The tags of both records.
        let tags = _mm256_unpackhi_epi64(_mm256_unpackhi_epi32(a, first), _mm256_unpackhi_epi32(b, second));
        let slots = _mm256_and_si256(tags, _mm256_set1_epi32(Record::SLOT as i32));
        let crossed = _mm256_shuffle_epi32::<0b10_11_00_01>(slots);
        let (lower, upper) = (_mm256_min_epu32(slots, crossed), _mm256_max_epu32(slots, crossed));
        if size_of::<I>() == 2 {
            // Both slots in the first half of their pair.
            let halves = _mm256_blend_epi16::<0b1010_1010>(lower, _mm256_slli_epi32::<16>(upper));
            let kept = _mm256_castsi128_si256(bytemuck::cast(KEPT[kept]));
            let packed = _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(halves, kept));
            _mm_storeu_si128(pairs.as_mut_ptr().cast(), packed);
        } else {
            let lower_first = _mm256_blend_epi32::<0b1010_1010>(lower, upper);
            let packed = _mm256_permutevar8x32_epi32(lower_first, bytemuck::cast(KEPT_WIDE[kept]));
            _mm256_storeu_si256(pairs.as_mut_ptr().cast(), packed);
        }
        Some(kept.count_ones() as usize)
    }
}
