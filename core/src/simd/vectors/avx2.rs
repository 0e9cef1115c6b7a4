//! 256-bit vectors of x86-64: Haswell, Zen and later.

use super::operations::{Halves, Vectors, kept, operations, proven};
use super::sse41::Sse41;
use crate::geometry::key::KeyBox;
use crate::geometry::record::GRID_MAX;
use crate::simd::Row;
use core::arch::x86_64::*;

cpufeatures::new!(detected, "avx2", "bmi1", "bmi2", "popcnt");

/// Proof that the CPU has AVX2, BMI1, BMI2 and POPCNT, and the operating system saves wide registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx2(());

/// Which of 32 rows have no byte below the query's. A plain function: a closure would not have the
/// instruction set of its function.
#[inline(always)]
fn reached(_: Avx2, [a, b, c, d]: &[[u8; 32]; 4], query: __m256i) -> u32 {
    // SAFETY: the token proves AVX2; each load reads eight rows.
    unsafe {
        // How much the query's bytes exceed a row's: zero where none does.
        let a = _mm256_subs_epu8(query, _mm256_loadu_si256(a.as_ptr().cast()));
        let b = _mm256_subs_epu8(query, _mm256_loadu_si256(b.as_ptr().cast()));
        let c = _mm256_subs_epu8(query, _mm256_loadu_si256(c.as_ptr().cast()));
        let d = _mm256_subs_epu8(query, _mm256_loadu_si256(d.as_ptr().cast()));
        // A byte for each row, zero where all four are: saturation keeps every other number above zero. The
        // packing interleaves the halves of the vectors, so groups of four are put back in order.
        let bytes = _mm256_packs_epi16(_mm256_packs_epi32(a, b), _mm256_packs_epi32(c, d));
        let inside = _mm256_cmpeq_epi8(bytes, _mm256_setzero_si256());
        _mm256_movemask_epi8(_mm256_permutevar8x32_epi32(inside, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7)))
            as u32
    }
}

/// The places of the words that a mask of four keeps.
const KEPT: [[u8; 8]; 16] = kept();

impl Vectors for Avx2 {
    const NAME: &'static str = "avx2";

    const GUARANTEED: Option<Self> = if cfg!(all(
        target_feature = "avx2",
        target_feature = "bmi1",
        target_feature = "bmi2",
        target_feature = "popcnt"
    )) {
        Some(Self(()))
    } else {
        None
    };

    #[inline(always)]
    fn detect() -> Option<Self> {
        detected::get().then_some(Self(()))
    }

    type Vector = __m256i;

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

    proven! {
        words(words: [u32; 4]) = _mm256_broadcastsi128_si256(_mm_loadu_si128(words.as_ptr().cast()));
        splat(word: u32) = _mm256_set1_epi32(word as i32);
        any(a) -> bool = _mm256_testz_si256(a, a) == 0;
        // Of a test with a mask the compiler makes four operations.
        any_of_three(a) -> bool = _mm256_movemask_epi8(a) & 0x0fff_0fff != 0;
        and(a, b) = _mm256_and_si256(a, b);
        or(a, b) = _mm256_or_si256(a, b);
        xor(a, b) = _mm256_xor_si256(a, b);
        select(mask, a, b) = _mm256_blendv_epi8(b, a, mask);
        shuffle(a, places) = _mm256_shuffle_epi8(a, places);
        equal16(a, b) = _mm256_cmpeq_epi16(a, b);
        equal32(a, b) = _mm256_cmpeq_epi32(a, b);
        excess16(a, b) = _mm256_subs_epu16(a, b);
        join8(a, b) = _mm256_packs_epi16(a, b);
        join16(a, b) = _mm256_packs_epi32(a, b);
        zip_first16(a, b) = _mm256_unpacklo_epi16(a, b);
        zip_last16(a, b) = _mm256_unpackhi_epi16(a, b);
        zip_first32(a, b) = _mm256_unpacklo_epi32(a, b);
        zip_last32(a, b) = _mm256_unpackhi_epi32(a, b);
        zip_first64(a, b) = _mm256_unpacklo_epi64(a, b);
        zip_last64(a, b) = _mm256_unpackhi_epi64(a, b);
        fourth_on(a, b) = _mm256_alignr_epi8::<12>(b, a);
        above32(a, b) = _mm256_cmpgt_epi32(a, b);
        upper32(a, b) = _mm256_max_epi32(a, b);
        minus32(a, b) = _mm256_sub_epi32(a, b);
        magnitude32(a) = _mm256_abs_epi32(a);
        turned(a, ways) = _mm256_sign_epi32(a, ways);
        add(a, b) = _mm256_castps_si256(_mm256_add_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b)));
        subtract(a, b) = _mm256_castps_si256(_mm256_sub_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b)));
        multiply(a, b) = _mm256_castps_si256(_mm256_mul_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b)));
        maximum(a, b) = _mm256_castps_si256(_mm256_max_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b)));
        minimum(a, b) = _mm256_castps_si256(_mm256_min_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b)));
        at_most(a, b) =
            _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b)));
    }
}

impl Halves for Avx2 {
    type Half = Sse41;

    #[inline(always)]
    fn half(self) -> Sse41 {
        Sse41(())
    }

    proven! {
        split(a) -> [__m128i; 2] = [_mm256_castsi256_si128(a), _mm256_extracti128_si256::<1>(a)];
        joined(first: __m128i, last: __m128i) = _mm256_set_m128i(last, first);
        halved(sides) = _mm256_permutevar8x32_epi32(sides, _mm256_setr_epi32(0, 1, 2, 6, 3, 4, 5, 6));
        opposed(boxes: [&[u8; 32]; 2]) -> [__m256i; 2] = {
            let [a, b] = boxes.map(|bytes| _mm256_loadu_si256(bytes.as_ptr().cast()));
            let a = _mm256_permutevar8x32_epi32(a, _mm256_setr_epi32(0, 1, 2, 7, 3, 4, 5, 7));
            let b = _mm256_permutevar8x32_epi32(b, _mm256_setr_epi32(3, 4, 5, 7, 0, 1, 2, 7));
            [_mm256_blend_epi32::<0xf0>(a, b), _mm256_blend_epi32::<0xf0>(b, a)]
        };
        steps16(a) -> __m128i = {
            let steps = _mm256_cvttps_epi32(_mm256_min_ps(_mm256_set1_ps(GRID_MAX), _mm256_castsi256_ps(a)));
            _mm_packus_epi32(_mm256_castsi256_si128(steps), _mm256_extracti128_si256::<1>(steps))
        };
        six(mask) -> u32 = _mm256_movemask_ps(_mm256_castsi256_ps(mask)) as u32;
        bits8(mask) -> u32 = _mm256_movemask_ps(_mm256_castsi256_ps(mask)) as u32;
        zeros64(a) -> u32 = {
            let zeros = _mm256_cmpeq_epi64(a, _mm256_setzero_si256());
            _mm256_movemask_pd(_mm256_castsi256_pd(zeros)) as u32
        };
        kept64(a, mask: u32, to: &mut [[u8; 16]; 2]) -> () = {
            let kept = _mm256_cvtepu8_epi32(_mm_loadl_epi64(KEPT[mask as usize & 15].as_ptr().cast()));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(a, kept));
        };
    }

    /// Behind them stands zero.
    #[inline(always)]
    fn sides(self, bounds: &KeyBox) -> __m256i {
        let keys: &[i32; 6] = bytemuck::cast_ref(bounds);
        // SAFETY: `self` proves AVX2; the mask keeps the read inside the 24 bytes.
        unsafe { _mm256_maskload_epi32(keys.as_ptr(), _mm256_setr_epi32(-1, -1, -1, -1, -1, -1, 0, 0)) }
    }

    #[inline(always)]
    fn window<const N: usize>(self, rows: &[Row; N], count: usize, query: __m256i) -> u64 {
        let mut mask = 0;
        for (at, rows) in rows.as_flattened().as_chunks::<128>().0.iter().enumerate() {
            mask |= u64::from(reached(self, bytemuck::cast_ref(rows), query)) << (32 * at);
        }
        // SAFETY: `self` proves BMI2.
        unsafe { _bzhi_u64(mask, count.min(N) as u32) }
    }
}
