//! 256-bit integers of x86-64: Haswell, Zen and later.

use super::{Contact, Phase, Simd};
use crate::key::KeyBox;
use crate::tree::{Frame, GRID_MAX, Record};
use core::arch::x86_64::*;

cpufeatures::new!(detected, "avx2", "bmi1", "bmi2", "popcnt");

/// Proof that the CPU has AVX2, BMI1, BMI2 and POPCNT, and that the operating system keeps the wide registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// Asks the CPU.
    pub(crate) fn detect() -> Option<Self> {
        detected::get().then_some(Self(()))
    }

    /// Runs a phase compiled for this level.
    #[inline]
    pub(crate) fn run<P: Phase>(self, phase: P) -> P::Output {
        #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
        fn compiled<P: Phase>(simd: Avx2, phase: P) -> P::Output {
            phase.run(simd)
        }
        // SAFETY: `self` proves that the CPU has these features.
        unsafe { compiled(self, phase) }
    }
}

impl Simd for Avx2 {
    const ROWS: usize = 32;

    type Query = [__m256i; 4];

    #[inline(always)]
    fn query(self, bytes: [u8; 4]) -> Self::Query {
        // SAFETY: `self` proves AVX2.
        bytes.map(|byte| unsafe { _mm256_set1_epi8(byte as i8) })
    }

    #[inline(always)]
    fn rows_at_most(self, block: &[u8], query: Self::Query) -> u64 {
        let Some((block, _)) = block.split_first_chunk::<128>() else { return 0 };
        // SAFETY: `self` proves AVX2; the four loads stay inside the 128 bytes.
        unsafe {
            let column = |k: usize| _mm256_loadu_si256(block.as_ptr().add(32 * k).cast());
            // Saturated subtraction leaves zero exactly where a byte is at most the query's.
            let over = |k: usize| _mm256_subs_epu8(column(k), query[k]);
            let over = _mm256_or_si256(_mm256_or_si256(over(0), over(1)), _mm256_or_si256(over(2), over(3)));
            let inside = _mm256_cmpeq_epi8(over, _mm256_setzero_si256());
            u64::from(_mm256_movemask_epi8(inside) as u32)
        }
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        let (a, b): (__m128i, __m128i) = (bytemuck::cast(*a), bytemuck::cast(*b));
        // SAFETY: `self` proves AVX2, which includes SSE4.1.
        unsafe {
            // Change the halves of b's six lanes and complement them: its maxima, then its complemented minima.
            let halves = _mm_setr_epi8(6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5, -1, -1, -1, -1);
            let limit = _mm_xor_si128(_mm_shuffle_epi8(b, halves), _mm_set1_epi8(-1));
            let zero = _mm_setzero_si128();
            let inside = _mm_movemask_epi8(_mm_cmpeq_epi16(_mm_subs_epu16(a, limit), zero));
            let equal = _mm_movemask_epi8(_mm_cmpeq_epi16(a, limit));
            Contact { touches: inside & 0xfff == 0xfff, tied: equal & 0xfff != 0 }
        }
    }

    #[inline(always)]
    fn touching(self, records: &[Record; 4], limit: Record) -> u32 {
        let [a, b]: [__m256i; 2] = bytemuck::cast(*records);
        // SAFETY: `self` proves AVX2.
        unsafe {
            let limit = _mm256_broadcastsi128_si256(bytemuck::cast(limit));
            let (a, b) = (_mm256_subs_epu16(a, limit), _mm256_subs_epu16(b, limit));
            // Eight bytes a record now, zero if it touches. The halves of the vectors are packed apart, which
            // puts the records in the order 0, 2, 1, 3.
            let over = _mm256_packs_epi16(a, b);
            let inside = _mm256_cmpeq_epi64(over, _mm256_setzero_si256());
            let mask = _mm256_movemask_pd(_mm256_castsi256_pd(inside)) as u32;
            mask & 0b1001 | (mask & 0b0010) << 1 | (mask & 0b0100) >> 1
        }
    }

    #[inline(always)]
    fn record(self, frame: &Frame, bounds: &KeyBox, tag: u32) -> Record {
        let [x0, y0, z0] = bounds.min;
        let [x1, y1, z1] = bounds.max;
        let [ox, oy, oz] = frame.origin;
        let [sx, sy, sz] = frame.scale;
        // SAFETY: `self` proves AVX2.
        unsafe {
            let keys = _mm256_setr_epi32(x0, y0, z0, x1, y1, z1, 0, 0);
            let sign = _mm256_srli_epi32::<1>(_mm256_srai_epi32::<31>(keys));
            let x = _mm256_castsi256_ps(_mm256_xor_si256(keys, sign));
            let origin = _mm256_setr_ps(ox, oy, oz, ox, oy, oz, 0.0, 0.0);
            let scale = _mm256_setr_ps(sx, sy, sz, sx, sy, sz, 0.0, 0.0);
            let at = _mm256_mul_ps(_mm256_sub_ps(x, origin), scale);
            // NaN falls to the second operand: zero.
            let at = _mm256_min_ps(_mm256_max_ps(at, _mm256_setzero_ps()), _mm256_set1_ps(GRID_MAX));
            let at = _mm256_cvttps_epi32(at);
            let low = _mm256_castsi256_si128(at);
            let high = _mm256_extracti128_si256::<1>(at);
            let lanes = _mm_xor_si128(_mm_packus_epi32(low, high), _mm_setr_epi16(0, 0, 0, -1, -1, -1, 0, 0));
            let mut record: Record = bytemuck::cast(lanes);
            record.tag = tag;
            record
        }
    }
}
