//! 128-bit integers of x86: SSE4.1 with POPCNT. Nehalem, Bulldozer, Jaguar and later.

use super::operations::{Half, Vectors, operations, proven};
use crate::geometry::record::GRID_MAX;
#[cfg(target_arch = "x86")]
use core::arch::x86::*;
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::*;

cpufeatures::new!(detected, "ssse3", "sse4.1", "popcnt");

/// Proof that the CPU has SSSE3, SSE4.1 and POPCNT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sse41(pub(super) ());

impl Vectors for Sse41 {
    const NAME: &'static str = "sse4.1";

    const GUARANTEED: Option<Self> =
        if cfg!(all(target_feature = "sse4.1", target_feature = "popcnt")) { Some(Self(())) } else { None };

    #[inline(always)]
    fn detect() -> Option<Self> {
        detected::get().then_some(Self(()))
    }

    type Vector = __m128i;

    #[inline(always)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        #[inline(never)]
        #[target_feature(enable = "ssse3,sse4.1,popcnt")]
        fn compiled<R>(work: impl FnOnce() -> R) -> R {
            work()
        }
        // SAFETY: `self` proves that the CPU has these features.
        unsafe { compiled(work) }
    }

    proven! {
        words(words: [u32; 4]) = _mm_loadu_si128(words.as_ptr().cast());
        splat(word: u32) = _mm_set1_epi32(word as i32);
        any(a) -> bool = _mm_testz_si128(a, a) == 0;
        and(a, b) = _mm_and_si128(a, b);
        or(a, b) = _mm_or_si128(a, b);
        xor(a, b) = _mm_xor_si128(a, b);
        select(mask, a, b) = _mm_blendv_epi8(b, a, mask);
        shuffle(a, places) = _mm_shuffle_epi8(a, places);
        equal16(a, b) = _mm_cmpeq_epi16(a, b);
        equal32(a, b) = _mm_cmpeq_epi32(a, b);
        excess16(a, b) = _mm_subs_epu16(a, b);
        // Zero only where both are: saturation keeps every other number above zero.
        join8(a, b) = _mm_packs_epi16(a, b);
        join16(a, b) = _mm_packs_epi32(a, b);
        zip_first16(a, b) = _mm_unpacklo_epi16(a, b);
        zip_last16(a, b) = _mm_unpackhi_epi16(a, b);
        zip_first32(a, b) = _mm_unpacklo_epi32(a, b);
        zip_last32(a, b) = _mm_unpackhi_epi32(a, b);
        zip_first64(a, b) = _mm_unpacklo_epi64(a, b);
        zip_last64(a, b) = _mm_unpackhi_epi64(a, b);
        fourth_on(a, b) = _mm_alignr_epi8::<12>(b, a);
        above32(a, b) = _mm_cmpgt_epi32(a, b);
        upper32(a, b) = _mm_max_epi32(a, b);
        minus32(a, b) = _mm_sub_epi32(a, b);
        magnitude32(a) = _mm_abs_epi32(a);
        turned(a, ways) = _mm_sign_epi32(a, ways);
        add(a, b) = _mm_castps_si128(_mm_add_ps(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        subtract(a, b) = _mm_castps_si128(_mm_sub_ps(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        multiply(a, b) = _mm_castps_si128(_mm_mul_ps(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        maximum(a, b) = _mm_castps_si128(_mm_max_ps(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        minimum(a, b) = _mm_castps_si128(_mm_min_ps(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        at_most(a, b) = _mm_castps_si128(_mm_cmple_ps(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
    }
}

impl Half for Sse41 {
    proven! {
        load(bytes: &[u8; 16]) = _mm_loadu_si128(bytes.as_ptr().cast());
        store(bytes: &mut [u8; 16], a) -> () = _mm_storeu_si128(bytes.as_mut_ptr().cast(), a);
        first(a) -> u32 = _mm_cvtsi128_si32(a) as u32;
        bits4(mask) -> u32 = _mm_movemask_ps(_mm_castsi128_ps(mask)) as u32;
        even32(a, b) = _mm_castps_si128(_mm_shuffle_ps::<0b10_00_10_00>(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        odd32(a, b) = _mm_castps_si128(_mm_shuffle_ps::<0b11_01_11_01>(_mm_castsi128_ps(a), _mm_castsi128_ps(b)));
        // NaN stays, as the second operand. Of it and of what is too low the conversion makes the least
        // number, of which the packing makes zero, as of all below zero.
        steps16(a, b) = _mm_packus_epi32(
            _mm_cvttps_epi32(_mm_min_ps(_mm_set1_ps(GRID_MAX), _mm_castsi128_ps(a))),
            _mm_cvttps_epi32(_mm_min_ps(_mm_set1_ps(GRID_MAX), _mm_castsi128_ps(b)))
        );
        reached(rows: [__m128i; 4], query) = {
            // How much the query's bytes exceed the record's: zero where none does.
            let (a, b) = (_mm_subs_epu8(query, rows[0]), _mm_subs_epu8(query, rows[1]));
            let (c, d) = (_mm_subs_epu8(query, rows[2]), _mm_subs_epu8(query, rows[3]));
            let bytes = _mm_packs_epi16(_mm_packs_epi32(a, b), _mm_packs_epi32(c, d));
            _mm_cmpeq_epi8(bytes, _mm_setzero_si128())
        };
        bits64(masks: [__m128i; 4]) -> u64 = {
            let first = _mm_movemask_epi8(masks[0]) | _mm_movemask_epi8(masks[1]) << 16;
            let last = _mm_movemask_epi8(masks[2]) | _mm_movemask_epi8(masks[3]) << 16;
            u64::from(first as u32) | u64::from(last as u32) << 32
        };
    }
}
