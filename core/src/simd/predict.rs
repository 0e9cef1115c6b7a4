//! Predicted boxes, with 256-bit vectors.

use super::Simd;
use super::detect::Avx2;
use super::encode::keys;
use crate::geometry::key::{AHEAD, AROUND, KeyBox, SHORTEST};
use core::arch::x86_64::*;

/// The numbers of eight keys.
#[inline(always)]
fn values(_: Avx2, keys: __m256i) -> __m256 {
    // SAFETY: the token proves AVX2.
    unsafe {
        let negative = _mm256_sub_epi32(_mm256_set1_epi32(i32::MIN), keys);
        let [keys, negative] = [_mm256_castsi256_ps(keys), _mm256_castsi256_ps(negative)];
        _mm256_blendv_ps(keys, negative, keys)
    }
}

/// Lengths, but those that are too short to be one are zero.
#[inline(always)]
fn flushed(_: Avx2, lengths: __m256) -> __m256 {
    // SAFETY: the token proves AVX2.
    unsafe { _mm256_and_ps(lengths, _mm256_cmp_ps::<_CMP_NLT_UQ>(lengths, _mm256_set1_ps(SHORTEST))) }
}

/// See [`KeyBox::predicted`].
#[inline(always)]
pub(super) fn predict(simd: Avx2, old: &KeyBox, bounds: &KeyBox, margin: f32) -> KeyBox {
    let sides = simd.keys(bounds);
    let (now, old) = (values(simd, sides), values(simd, simd.keys(old)));
    // SAFETY: the token proves AVX2.
    unsafe {
        let (zero, most) = (_mm256_setzero_ps(), _mm256_set1_ps(f32::MAX));
        let magnitude = _mm256_castsi256_ps(_mm256_set1_epi32(i32::MAX));
        let across = _mm256_permutevar8x32_ps(now, _mm256_setr_epi32(3, 4, 5, 0, 1, 2, 6, 7));
        let side = flushed(simd, _mm256_and_ps(_mm256_sub_ps(now, across), magnitude));
        // Only what is above zero and finite; so not NaN.
        let counts =
            _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(side, zero), _mm256_cmp_ps::<_CMP_LT_OQ>(side, most));
        let side = _mm256_blendv_ps(most, side, counts);
        let second = _mm256_permutevar8x32_ps(side, _mm256_setr_epi32(1, 2, 0, 4, 5, 3, 6, 7));
        let third = _mm256_permutevar8x32_ps(side, _mm256_setr_epi32(2, 0, 1, 5, 3, 4, 6, 7));
        let smallest = _mm256_min_ps(side, _mm256_min_ps(second, third));
        let size = _mm256_and_ps(smallest, _mm256_cmp_ps::<_CMP_LT_OQ>(smallest, most));
        let around = _mm256_max_ps(_mm256_mul_ps(size, _mm256_set1_ps(AROUND)), _mm256_set1_ps(margin));
        let around = flushed(simd, around);
        let step = _mm256_sub_ps(now, old);
        let far = _mm256_and_ps(step, magnitude);
        let counts = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GE_OQ>(far, _mm256_set1_ps(SHORTEST)),
            _mm256_cmp_ps::<_CMP_LE_OQ>(far, size),
        );
        let reach = _mm256_and_ps(_mm256_mul_ps(step, _mm256_set1_ps(AHEAD)), counts);
        let down = _mm256_sub_ps(_mm256_min_ps(reach, zero), around);
        let up = _mm256_add_ps(_mm256_max_ps(reach, zero), around);
        let by = _mm256_blend_ps::<0b111000>(down, up);
        let to = _mm256_add_ps(now, by);
        let least = _mm256_max_ps(to, _mm256_set1_ps(f32::MIN));
        let to = _mm256_blend_ps::<0b111000>(least, _mm256_min_ps(to, most));
        let to = keys(simd, _mm256_castps_si256(to));
        let to = _mm256_blend_epi32::<0b111000>(_mm256_min_epi32(to, sides), _mm256_max_epi32(to, sides));
        let stays = _mm256_castps_si256(_mm256_cmp_ps::<_CMP_EQ_OQ>(by, zero));
        simd.bounds(_mm256_blendv_epi8(to, sides, stays))
    }
}
