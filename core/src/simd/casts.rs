//! Casts against boxes and records, for AVX2. Plain functions: a closure would not have the instruction set of its function.

use super::EIGHT;
use super::detect::Avx2;
use crate::geometry::key::KeyBox;
use crate::geometry::line::{Crossing, Slabs, Walk};
use crate::geometry::record::Record;
use core::arch::x86_64::*;

/// The least denormal `f32`.
const LEAST_DENORMAL: f64 = f64::from_bits((1023 - 149) << 52);

/// The floats of four keys. A plain function for the same reason.
#[inline(always)]
fn values(_: Avx2, keys: __m128i) -> __m256d {
    // SAFETY: the token proves AVX2.
    unsafe {
        let sign = _mm_and_si128(keys, _mm_set1_epi32(i32::MIN));
        let magnitude = _mm_abs_epi32(keys);
        let normal = _mm256_cvtps_pd(_mm_castsi128_ps(_mm_or_si128(magnitude, sign)));
        // The key of a denormal counts the least one. A conversion of floats might flush it to zero.
        let denormal = _mm256_mul_pd(_mm256_cvtepi32_pd(keys), _mm256_set1_pd(LEAST_DENORMAL));
        let is_denormal = _mm_cmpgt_epi32(_mm_set1_epi32(f32::MIN_POSITIVE.to_bits() as i32), magnitude);
        let is_denormal = _mm256_castsi256_pd(_mm256_cvtepi32_epi64(is_denormal));
        _mm256_blendv_pd(normal, denormal, is_denormal)
    }
}

/// The floats of eight keys. A plain function for the same reason.
#[inline(always)]
pub(super) fn floats(_: Avx2, keys: __m256i) -> __m256 {
    // SAFETY: the token proves AVX2.
    unsafe {
        let sign = _mm256_and_si256(keys, _mm256_set1_epi32(i32::MIN));
        _mm256_castsi256_ps(_mm256_or_si256(_mm256_abs_epi32(keys), sign))
    }
}

/// Four numbers, twice. A plain function for the same reason.
#[inline(always)]
fn twice(_: Avx2, numbers: &[f32; 4]) -> __m256 {
    // SAFETY: the token proves AVX2; four numbers are read.
    unsafe { _mm256_broadcast_ps(&bytemuck::cast(*numbers)) }
}

/// When a cast enters the boxes of eight records, and a mask of those that it may touch. Even records come in the
/// lower half. A plain function for the same reason.
#[inline(always)]
pub(super) fn met(_: Avx2, records: &[Record; EIGHT], crossing: &Crossing) -> (__m256, __m256) {
    let [a, b, c, d]: [__m256i; 4] = bytemuck::cast(*records);
    // SAFETY: the token proves AVX2.
    unsafe {
        let order = _mm256_broadcastsi128_si256(bytemuck::cast(crossing.order));
        // The lanes of two records side by side, then those of four: each vector has two lanes, of the even records
        // in its lower half.
        let (a, b) = (_mm256_shuffle_epi8(a, order), _mm256_shuffle_epi8(b, order));
        let (c, d) = (_mm256_shuffle_epi8(c, order), _mm256_shuffle_epi8(d, order));
        let (ab, cd) = (_mm256_unpacklo_epi16(a, b), _mm256_unpacklo_epi16(c, d));
        let (first, second) = (_mm256_unpacklo_epi32(ab, cd), _mm256_unpackhi_epi32(ab, cd));
        let third = _mm256_unpacklo_epi32(_mm256_unpackhi_epi16(a, b), _mm256_unpackhi_epi16(c, d));
        let mut times = [_mm256_setzero_ps(); 6];
        for (pair, lanes) in [first, second, third].into_iter().enumerate() {
            // A float that has the lane as its lower half; NaN for a lane of zero.
            let zero = _mm256_cmpeq_epi16(lanes, _mm256_setzero_si256());
            let upper = _mm256_or_si256(zero, _mm256_set1_epi16(0x4b00));
            for (lane, x) in [
                (2 * pair, _mm256_unpacklo_epi16(lanes, upper)),
                (2 * pair + 1, _mm256_unpackhi_epi16(lanes, upper)),
            ] {
                let scaled = _mm256_mul_ps(_mm256_castsi256_ps(x), _mm256_set1_ps(crossing.scale[lane]));
                times[lane] = _mm256_add_ps(scaled, _mm256_set1_ps(crossing.offset[lane]));
            }
        }
        let [x0, y0, z0, x1, y1, z1] = times;
        // NaN falls to the second operand.
        let from = _mm256_max_ps(x0, _mm256_max_ps(y0, _mm256_max_ps(z0, _mm256_setzero_ps())));
        let to = _mm256_min_ps(x1, _mm256_min_ps(y1, _mm256_min_ps(z1, _mm256_set1_ps(crossing.until))));
        let from = _mm256_min_ps(from, _mm256_set1_ps(Crossing::LATEST));
        (from, _mm256_cmp_ps::<_CMP_LE_OQ>(from, to))
    }
}

/// As [`Simd::span`](super::Simd::span).
#[inline(always)]
pub(super) fn span(simd: Avx2, slabs: &Slabs, min: [i32; 4], max: [i32; 4], far: f64) -> (f64, f64) {
    // SAFETY: the token proves AVX2; the slabs' rows are four floats each.
    unsafe {
        let (min, max): (__m128i, __m128i) = (bytemuck::cast(min), bytemuck::cast(max));
        let back: __m128i = bytemuck::cast(slabs.back);
        let inverse = _mm256_loadu_pd(slabs.inverse.as_ptr());
        let first = _mm256_sub_pd(
            values(simd, _mm_blendv_epi8(min, max, back)),
            _mm256_loadu_pd(slabs.first.as_ptr()),
        );
        let last = _mm256_sub_pd(
            values(simd, _mm_blendv_epi8(max, min, back)),
            _mm256_loadu_pd(slabs.last.as_ptr()),
        );
        // NaN falls to the second operand. The fourth axis is NaN always: zero times infinity.
        let from = _mm256_max_pd(_mm256_mul_pd(first, inverse), _mm256_setzero_pd());
        let to = _mm256_min_pd(_mm256_mul_pd(last, inverse), _mm256_set1_pd(far));
        let from = _mm_max_pd(_mm256_castpd256_pd128(from), _mm256_extractf128_pd::<1>(from));
        let to = _mm_min_pd(_mm256_castpd256_pd128(to), _mm256_extractf128_pd::<1>(to));
        let from = _mm_max_sd(from, _mm_unpackhi_pd(from, from));
        let to = _mm_min_sd(to, _mm_unpackhi_pd(to, to));
        (_mm_cvtsd_f64(from), _mm_cvtsd_f64(to))
    }
}

/// As [`Simd::enter`](super::Simd::enter).
#[inline(always)]
pub(super) fn enter(simd: Avx2, walk: &Walk, nodes: [&KeyBox; 2], until: f32) -> [f32; 2] {
    // SAFETY: the token proves AVX2; the walk's rows are four numbers each. Of the six keys of a box four are read, from the first
    // one and from the third one on.
    unsafe {
        let [a, b] = nodes.map(|node| bytemuck::cast_ref::<KeyBox, [i32; 6]>(node).as_ptr());
        // The low sides and one more, then one and the high sides.
        let low = _mm256_loadu2_m128i(b.cast(), a.cast());
        let high = _mm256_loadu2_m128i(b.add(2).cast(), a.add(2).cast());
        let high = _mm256_shuffle_epi32::<0b11_11_10_01>(high);
        let (low, high) = (floats(simd, low), floats(simd, high));
        let back = _mm256_castsi256_ps(_mm256_broadcastsi128_si256(bytemuck::cast(walk.back)));
        let first = _mm256_sub_ps(_mm256_blendv_ps(low, high, back), twice(simd, &walk.first));
        let last = _mm256_sub_ps(_mm256_blendv_ps(high, low, back), twice(simd, &walk.last));
        // NaN falls to the second operand.
        let from = _mm256_max_ps(_mm256_mul_ps(first, twice(simd, &walk.come)), _mm256_setzero_ps());
        let to = _mm256_min_ps(_mm256_mul_ps(last, twice(simd, &walk.leave)), _mm256_set1_ps(until));
        // The first lane of each half also takes the second and the third one.
        let two = _mm256_max_ps(from, _mm256_permute_ps::<0b01>(from));
        let from = _mm256_max_ps(two, _mm256_permute_ps::<0b10>(from));
        let two = _mm256_min_ps(to, _mm256_permute_ps::<0b01>(to));
        let to = _mm256_min_ps(two, _mm256_permute_ps::<0b10>(to));
        let met = _mm256_cmp_ps::<_CMP_LE_OQ>(from, _mm256_add_ps(to, _mm256_set1_ps(Walk::LEAST)));
        let from = _mm256_blendv_ps(_mm256_set1_ps(f32::NAN), from, met);
        [_mm256_cvtss_f32(from), _mm_cvtss_f32(_mm256_extractf128_ps::<1>(from))]
    }
}
