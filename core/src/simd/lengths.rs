//! Tests fat boxes with 256-bit vectors: do they hold a box, and are they far too large for it?

use super::detect::Avx2;
use super::{MAXIMA, MINIMA, Simd};
use crate::geometry::key::{KeyBox, SHORTEST};
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

/// The lengths between numbers. What is too short to be a length is zero.
#[inline(always)]
fn apart(_: Avx2, a: __m256, b: __m256) -> __m256 {
    // SAFETY: the token proves AVX2.
    unsafe {
        let length = _mm256_andnot_ps(_mm256_set1_ps(-0.0), _mm256_sub_ps(a, b));
        _mm256_and_ps(length, _mm256_cmp_ps::<_CMP_NLT_UQ>(length, _mm256_set1_ps(SHORTEST)))
    }
}

/// See [`Simd::suits`].
#[inline(always)]
pub(super) fn suits(simd: Avx2, fat: &KeyBox, inner: __m256i, margin: Option<f32>) -> bool {
    let fat = simd.keys(fat);
    let outside = simd.above(fat, inner) & MINIMA | simd.above(inner, fat) & MAXIMA;
    let Some(margin) = margin else { return outside == 0 };
    outside == 0 && !dwarfs(simd, fat, inner, margin)
}

/// As [`KeyBox::dwarfs`].
#[inline(always)]
fn dwarfs(simd: Avx2, fat: __m256i, inner: __m256i, margin: f32) -> bool {
    let (fat, inner) = (values(simd, fat), values(simd, inner));
    // SAFETY: the token proves AVX2.
    unsafe {
        let across = _mm256_permutevar8x32_ps(inner, _mm256_setr_epi32(3, 4, 5, 0, 1, 2, 6, 7));
        let half = _mm256_mul_ps(_mm256_set1_ps(0.5), apart(simd, inner, across));
        let near = _mm256_add_ps(_mm256_set1_ps(4.0 * margin), half);
        let dwarfs = _mm256_cmp_ps::<_CMP_GT_OQ>(apart(simd, fat, inner), near);
        _mm256_movemask_ps(dwarfs) as u32 & (MINIMA | MAXIMA) != 0
    }
}
