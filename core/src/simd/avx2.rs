//! 256-bit integers of x86-64: Haswell, Zen and later.

use super::casts;
use super::detect::Avx2;
use super::encode;
use super::fours::{self, HALVES};
use super::overlaps;
use super::predict;
use super::{Contact, EIGHT, MINIMA, Row, Simd, WINDOW, query_lanes, row_lanes};
use crate::geometry::boxes::Four;
use crate::geometry::key::KeyBox;
use crate::geometry::line::{Crossing, Slabs, Walk};
use crate::geometry::record::{Frame, GRID_MAX, Record};
use crate::id::{Index, Pair};
use core::arch::x86_64::*;

/// One bit for each of 32 rows. A plain function: a closure would not have the instruction set of its function.
#[inline(always)]
fn half(_: Avx2, [a, b, c, d]: &[[u8; 32]; 4], query: __m256i) -> u32 {
    // SAFETY: the token proves AVX2; each load reads eight rows.
    unsafe {
        // How much the query's bytes exceed a row's: zero where none does.
        let a = _mm256_subs_epu8(query, _mm256_loadu_si256(a.as_ptr().cast()));
        let b = _mm256_subs_epu8(query, _mm256_loadu_si256(b.as_ptr().cast()));
        let c = _mm256_subs_epu8(query, _mm256_loadu_si256(c.as_ptr().cast()));
        let d = _mm256_subs_epu8(query, _mm256_loadu_si256(d.as_ptr().cast()));
        // A byte for each row, zero where all four are: saturation keeps every other number above zero. The packing
        // interleaves the halves of the vectors, so groups of four are put back in order.
        let bytes = _mm256_packs_epi16(_mm256_packs_epi32(a, b), _mm256_packs_epi32(c, d));
        let inside = _mm256_cmpeq_epi8(bytes, _mm256_setzero_si256());
        let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
        _mm256_movemask_epi8(_mm256_permutevar8x32_epi32(inside, order)) as u32
    }
}

/// The places of the high bytes of four lanes. A plain function for the same reason.
#[inline(always)]
fn high_bytes(_: Avx2, lanes: [usize; 4]) -> __m128i {
    let [a, b, c, d] = [2 * lanes[0] + 1, 2 * lanes[1] + 1, 2 * lanes[2] + 1, 2 * lanes[3] + 1];
    // SAFETY: the token proves AVX2.
    unsafe { _mm_set1_epi32(i32::from_le_bytes([a as u8, b as u8, c as u8, d as u8])) }
}

/// Bits of eight records in order, by a mask that has those of the even records in its lower half.
const IN_ORDER: [u8; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut record = 0;
        while record < EIGHT {
            let bit = record / 2 + 4 * (record % 2);
            table[mask] |= ((mask >> bit & 1) << record) as u8;
            record += 1;
        }
        mask += 1;
    }
    table
};

/// The bits of eight records in their order.
#[inline(always)]
const fn in_order(mask: i32) -> u32 {
    IN_ORDER[(mask & 0xff) as usize] as u32
}

impl Simd for Avx2 {
    /// The last two lanes are zero.
    type Keys = __m256i;

    type Axis = [__m128i; 2];

    type Query = __m256i;

    const ENCODES_FOUR: bool = true;
    const TESTS_SOME_PAIRS: bool = true;

    #[inline(always)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        #[inline(never)]
        #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
        fn compiled<R>(work: impl FnOnce() -> R) -> R {
            work()
        }
        // SAFETY: `self` proves that the CPU has these features.
        unsafe { compiled(work) }
    }

    #[inline(always)]
    fn keys(self, bounds: &KeyBox) -> __m256i {
        let keys: &[i32; 6] = bytemuck::cast_ref(bounds);
        // SAFETY: `self` proves AVX2; the mask keeps the read inside the 24 bytes.
        unsafe { _mm256_maskload_epi32(keys.as_ptr(), _mm256_setr_epi32(-1, -1, -1, -1, -1, -1, 0, 0)) }
    }

    #[inline(always)]
    fn bounds(self, keys: __m256i) -> KeyBox {
        let mut bounds = [0; 6];
        // SAFETY: `self` proves AVX2; 16 and then 8 of the 24 bytes are written.
        unsafe {
            _mm_storeu_si128(bounds.as_mut_ptr().cast(), _mm256_castsi256_si128(keys));
            _mm_storel_epi64(bounds.as_mut_ptr().add(4).cast(), _mm256_extracti128_si256::<1>(keys));
        }
        bytemuck::cast(bounds)
    }

    #[inline(always)]
    fn encode(self, min: &[u8; 12], max: &[u8; 12]) -> Option<__m256i> {
        encode::encode(self, min, max)
    }

    #[inline(always)]
    fn encode_four(
        self,
        boxes: Four<'_>,
        held: &[KeyBox; 4],
        old: &[KeyBox; 4],
        new: &mut [KeyBox; 4],
    ) -> Option<u32> {
        encode::encode_four(self, boxes, held, old, new)
    }

    #[inline(always)]
    fn above(self, a: __m256i, b: __m256i) -> u32 {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(a, b))) as u32 }
    }

    #[inline(always)]
    fn overlap(self, a: &KeyBox, b: &KeyBox) -> bool {
        let (a, b) = (self.keys(a), self.keys(b));
        // SAFETY: `self` proves AVX2.
        unsafe {
            let across = _mm256_permutevar8x32_epi32(b, _mm256_setr_epi32(3, 4, 5, 0, 1, 2, 6, 7));
            // The minima of both boxes, and the maxima of the other box, which they must not exceed.
            let minima = _mm256_blend_epi32::<0b111000>(a, across);
            let maxima = _mm256_blend_epi32::<0b111000>(across, a);
            let apart = _mm256_cmpgt_epi32(minima, maxima);
            _mm256_testz_si256(apart, apart) != 0
        }
    }

    #[inline(always)]
    unsafe fn eight_overlap<I: Index>(self, boxes: &[KeyBox], pairs: &[Pair<I>; 8]) -> u32 {
        // SAFETY: the caller vouches for the slots.
        unsafe { overlaps::eight_overlap(self, boxes, pairs) }
    }

    #[inline(always)]
    fn prefetch<T>(self, items: &[T], index: usize) {
        // SAFETY: `self` proves AVX2, which includes SSE. A prefetch has no effect on the program, wherever it
        // points.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(items.as_ptr().wrapping_add(index).cast()) }
    }

    #[inline(always)]
    fn same(self, a: __m256i, b: __m256i) -> bool {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let differs = _mm256_xor_si256(a, b);
            _mm256_testz_si256(differs, differs) != 0
        }
    }

    #[inline(always)]
    fn lower(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_min_epi32(a, b) }
    }

    #[inline(always)]
    fn upper(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_max_epi32(a, b) }
    }

    #[inline(always)]
    fn narrow(self, keys: __m256i) -> bool {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let maxima = _mm256_permutevar8x32_epi32(keys, _mm256_setr_epi32(3, 4, 5, 6, 6, 6, 6, 6));
            let apart = _mm256_sub_epi32(maxima, keys);
            let few = _mm256_cmpeq_epi32(apart, _mm256_min_epu32(apart, _mm256_set1_epi32(3)));
            _mm256_movemask_ps(_mm256_castsi256_ps(few)) as u32 & MINIMA != 0
        }
    }

    #[inline(always)]
    fn predict(self, old: &KeyBox, bounds: &KeyBox, margin: f32) -> KeyBox {
        predict::predict(self, old, bounds, margin)
    }

    #[inline(always)]
    fn axis(self, axis: usize) -> [__m128i; 2] {
        [high_bytes(self, row_lanes(axis)), high_bytes(self, query_lanes(axis))]
    }

    #[inline(always)]
    fn row(self, [row, _]: [__m128i; 2], record: &Record) -> Row {
        // SAFETY: `self` proves AVX2, which includes SSSE3.
        (!unsafe { _mm_cvtsi128_si32(_mm_shuffle_epi8(bytemuck::cast(*record), row)) }).to_le_bytes()
    }

    #[inline(always)]
    fn query(self, [_, query]: [__m128i; 2], record: &Record) -> __m256i {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_broadcastd_epi32(_mm_shuffle_epi8(bytemuck::cast(*record), query)) }
    }

    #[inline(always)]
    fn window(self, rows: &[Row; WINDOW], count: usize, query: __m256i) -> u64 {
        let [first, second]: &[[[u8; 32]; 4]; 2] = bytemuck::cast_ref(rows);
        let mask = u64::from(half(self, first, query)) | (u64::from(half(self, second, query)) << 32);
        // SAFETY: `self` proves BMI2.
        unsafe { _bzhi_u64(mask, count.min(WINDOW) as u32) }
    }

    #[inline(always)]
    fn four<I: Index>(
        self,
        sorted: &[Record],
        base: u32,
        bits: u64,
        pairs: &mut [Pair<I>; 4],
    ) -> Option<usize> {
        fours::four(self, sorted, base, bits, pairs)
    }

    #[inline(always)]
    fn any_four<I: Index>(
        self,
        sorted: &[Record],
        candidates: &[u32; 4],
        pairs: &mut [Pair<I>; 4],
    ) -> Option<usize> {
        fours::any_four(self, sorted, candidates, pairs)
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        let (a, b): (__m128i, __m128i) = (bytemuck::cast(*a), bytemuck::cast(*b));
        // SAFETY: `self` proves AVX2, which includes SSE4.1.
        unsafe {
            // Swap the halves of b's six lanes and complement them: its maxima, then its complemented minima.
            let limit = _mm_xor_si128(_mm_shuffle_epi8(b, bytemuck::cast(HALVES)), _mm_set1_epi8(-1));
            let zero = _mm_setzero_si128();
            let inside = _mm_cmpeq_epi16(_mm_subs_epu16(a, limit), zero);
            let equal = _mm_cmpeq_epi16(a, limit);
            // A bit for each lane; equal ones in the upper byte.
            let mask = _mm_movemask_epi8(_mm_packs_epi16(inside, equal));
            Contact { touches: mask & 0x3f == 0x3f, tied: mask & 0x3f00 != 0 }
        }
    }

    #[inline(always)]
    fn touching(self, records: &[Record; EIGHT], limit: Record) -> u32 {
        let [a, b, c, d]: [__m256i; 4] = bytemuck::cast(*records);
        // SAFETY: `self` proves AVX2.
        let mask = unsafe {
            let limit = _mm256_broadcastsi128_si256(bytemuck::cast(limit));
            let (a, b) = (_mm256_subs_epu16(a, limit), _mm256_subs_epu16(b, limit));
            let (c, d) = (_mm256_subs_epu16(c, limit), _mm256_subs_epu16(d, limit));
            // Eight bytes a record now, zero if it touches.
            let (first, last) = (_mm256_packs_epi16(a, b), _mm256_packs_epi16(c, d));
            let zero = _mm256_setzero_si256();
            let (first, last) = (_mm256_cmpeq_epi64(first, zero), _mm256_cmpeq_epi64(last, zero));
            let (first, last) = (_mm256_castsi256_ps(first), _mm256_castsi256_ps(last));
            _mm256_movemask_ps(_mm256_shuffle_ps::<0b10_00_10_00>(first, last))
        };
        in_order(mask)
    }

    #[inline(always)]
    fn span(self, slabs: &Slabs, min: [i32; 4], max: [i32; 4], far: f64) -> (f64, f64) {
        casts::span(self, slabs, min, max, far)
    }

    #[inline(always)]
    fn enter(self, walk: &Walk, nodes: [&KeyBox; 2], until: f32) -> [f32; 2] {
        casts::enter(self, walk, nodes, until)
    }

    #[inline(always)]
    fn crossed(self, records: &[Record; EIGHT], crossing: &Crossing) -> u32 {
        let (_, met) = casts::met(self, records, crossing);
        // SAFETY: `self` proves AVX2.
        in_order(unsafe { _mm256_movemask_ps(met) })
    }

    #[inline(always)]
    fn met(self, records: &[Record; EIGHT], crossing: &Crossing) -> [f32; EIGHT] {
        let (times, met) = casts::met(self, records, crossing);
        // SAFETY: `self` proves AVX2.
        unsafe {
            let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
            let times = _mm256_blendv_ps(_mm256_set1_ps(f32::NAN), times, met);
            bytemuck::cast(_mm256_permutevar8x32_ps(times, order))
        }
    }

    #[inline(always)]
    fn pop_min(self, numbers: &mut [u32; EIGHT]) -> u32 {
        let all: __m256i = bytemuck::cast(*numbers);
        // SAFETY: `self` proves AVX2.
        unsafe {
            let least = _mm256_min_epu32(all, _mm256_permute2x128_si256::<1>(all, all));
            let least = _mm256_min_epu32(least, _mm256_shuffle_epi32::<0b01_00_11_10>(least));
            let least = _mm256_min_epu32(least, _mm256_shuffle_epi32::<0b10_11_00_01>(least));
            *numbers = bytemuck::cast(_mm256_or_si256(all, _mm256_cmpeq_epi32(all, least)));
            _mm256_cvtsi256_si32(least) as u32
        }
    }

    #[inline(always)]
    fn record(self, frame: &Frame, keys: __m256i, tag: u32) -> Record {
        // SAFETY: `self` proves AVX2; the frame's rows are eight floats each.
        unsafe {
            let at = _mm256_sub_ps(casts::floats(self, keys), _mm256_loadu_ps(frame.origin.as_ptr()));
            let at = _mm256_mul_ps(at, _mm256_loadu_ps(frame.scale.as_ptr()));
            // NaN falls to the second operand and becomes the lowest integer; what is below zero is packed as zero.
            let at = _mm256_cvttps_epi32(_mm256_min_ps(_mm256_set1_ps(GRID_MAX), at));
            let lanes = _mm_packus_epi32(_mm256_castsi256_si128(at), _mm256_extracti128_si256::<1>(at));
            let lanes = _mm_xor_si128(lanes, _mm_setr_epi16(0, 0, 0, -1, -1, -1, 0, 0));
            bytemuck::cast(_mm_insert_epi32::<3>(lanes, tag as i32))
        }
    }
}
