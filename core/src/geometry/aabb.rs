//! Boxes as callers give them.

use super::key::{KeyBox, key, value};
use bytemuck::{Pod, Zeroable};

/// An axis-aligned bounding box in `f32`, closed on all sides: touching boxes overlap.
///
/// Any unit is right if all boxes use the same. Infinite bounds are allowed (a ground plane, a half-space). The
/// [`World`](crate::World) refuses NaN and `min > max`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// The lowest corner: x, y, z.
    pub min: [f32; 3],
    /// The highest corner: x, y, z.
    pub max: [f32; 3],
}

impl Aabb {
    /// A box from its lowest and highest corners.
    #[must_use]
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min, max }
    }

    /// The least box that holds a box in `f64`, relative to `origin`. Minima are rounded down and maxima up, so boxes
    /// that overlap in `f64` overlap in `f32` too. Rounding to nearest would leave parts of objects outside their
    /// boxes.
    ///
    /// Keep `origin` near the objects: far from it boxes lose precision, but never a pair. Add margins of your own to
    /// the `f64` box, so that the rounding comes after them.
    #[must_use]
    pub fn from_f64(min: [f64; 3], max: [f64; 3], origin: [f64; 3]) -> Self {
        let low = |k: usize| round_down(min[k], origin[k]);
        let high = |k: usize| round_up(max[k], origin[k]);
        Self { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] }
    }

    /// The least box that holds a box in fixed point. A coordinate `x` means `x / 2^fraction_bits` of your unit: 16
    /// fraction bits are the usual Q16.16, and 0 are whole numbers. Minima are rounded down and maxima up, so boxes
    /// that overlap in fixed point overlap in `f32` too. Coordinates of at most 24 significant bits, such as all from
    /// -2^24 to 2^24, are exact, and so are their overlaps.
    ///
    /// Uses integer operations alone, so a processor without FPU calls no soft-float. With more than 126 fraction
    /// bits the box is not [valid](Self::is_valid), since `f32` does not go so low.
    ///
    /// ```
    /// use trisap_core::Aabb;
    ///
    /// const HALF: i32 = 1 << 15;
    /// assert_eq!(Aabb::from_fixed([-HALF; 3], [3 * HALF; 3], 16), Aabb::new([-0.5; 3], [1.5; 3]));
    /// ```
    #[must_use]
    pub const fn from_fixed(min: [i32; 3], max: [i32; 3], fraction_bits: u32) -> Self {
        Self {
            min: [
                fixed(min[0], fraction_bits, false),
                fixed(min[1], fraction_bits, false),
                fixed(min[2], fraction_bits, false),
            ],
            max: [
                fixed(max[0], fraction_bits, true),
                fixed(max[1], fraction_bits, true),
                fixed(max[2], fraction_bits, true),
            ],
        }
    }

    /// Whether a world accepts the box: no NaN, and `min <= max` on every axis.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        KeyBox::from_aabb(self).is_some()
    }

    /// Whether the closed boxes share a point; false if one of them is not [valid](Self::is_valid). Exact also if the
    /// host flushes denormals to zero, since integers are compared, as in a step.
    #[doc(alias("intersects", "intersects_aabb"))]
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        match (KeyBox::from_aabb(self), KeyBox::from_aabb(other)) {
            (Some(a), Some(b)) => a.overlaps(&b),
            _ => false,
        }
    }
}

/// The least `f32` that is not below `x - origin`, or NaN.
pub(crate) fn round_up(x: f64, origin: f64) -> f32 {
    -round_down(-x, -origin)
}

/// The greatest `f32` that is not above `x - origin`, or NaN.
pub(crate) fn round_down(x: f64, origin: f64) -> f32 {
    let (x, origin) = (without_denormals(x), -without_denormals(-origin));
    let difference = x - origin;
    // The exact rounding error of the subtraction; meaningless if a number is infinite.
    let back = difference - x;
    let error = (x - (difference - back)) - (origin + back);
    // A host that flushes denormals to zero may have flushed the difference itself.
    let is_above = error < 0.0 || difference == 0.0 && x < origin;
    narrowed(if is_above { difference.next_down() } else { difference })
}

/// The number, or the next lower one that is no denormal: a host may take a denormal for zero.
fn without_denormals(x: f64) -> f64 {
    match x.classify() {
        core::num::FpCategory::Subnormal if x.is_sign_negative() => -f64::MIN_POSITIVE,
        core::num::FpCategory::Subnormal => 0.0,
        _ => x,
    }
}

/// The greatest `f32` that is not above `x`, or NaN. It is computed from the bits, so a host that flushes denormals
/// gets the same.
pub(crate) const fn narrowed(x: f64) -> f32 {
    const MANTISSA: u32 = 52;
    /// Bits of an `f64` below the last one of an `f32`.
    const LOST: u32 = MANTISSA - 23;
    /// Stored exponents: of the least normal `f32`, of the first number beyond the greatest, and of infinity.
    const LEAST: u64 = 1023 - 126;
    const BEYOND: u64 = 1023 + 128;
    const INFINITY: u64 = 2047;
    let bits = x.to_bits();
    let sign = (bits >> 63) as u32;
    let magnitude = bits & (u64::MAX >> 1);
    let (exponent, fraction) = (magnitude >> MANTISSA, magnitude & (u64::MAX >> (64 - MANTISSA)));
    // The number rounded towards zero, and whether that has changed it.
    let (toward_zero, is_less) = if exponent == INFINITY {
        if fraction != 0 {
            return f32::NAN;
        }
        (f32::INFINITY.to_bits(), false)
    } else if exponent >= BEYOND {
        (f32::MAX.to_bits(), true)
    } else if exponent >= LEAST {
        let narrow = (magnitude - ((LEAST - 1) << MANTISSA)) >> LOST;
        (narrow as u32, magnitude << (64 - LOST) != 0)
    } else {
        // A denormal `f32`, or less than the least.
        let down = LOST as u64 + LEAST - exponent;
        let mantissa = fraction | 1 << MANTISSA;
        match down {
            0..64 if exponent > 0 => ((mantissa >> down) as u32, mantissa << (64 - down) != 0),
            _ => (0, magnitude != 0),
        }
    };
    // The next number away from zero has the next bits; after the greatest comes infinity.
    f32::from_bits(sign << 31 | (toward_zero + (is_less && sign != 0) as u32))
}

/// A number as `f64`. A denormal is converted by its bits, for the same reason.
#[inline(always)]
pub(crate) const fn widened(x: f32) -> f64 {
    const DENORMAL: f64 = f64::from_bits((1023 - 149) << 52);
    let magnitude = x.to_bits() & (u32::MAX >> 1);
    if magnitude >= f32::MIN_POSITIVE.to_bits() {
        return x as f64;
    }
    let value = magnitude as f64 * DENORMAL;
    if x.is_sign_negative() { -value } else { value }
}

/// `x / 2^fraction_bits` rounded up or down to `f32`, or NaN if that may be denormal.
const fn fixed(x: i32, fraction_bits: u32, up: bool) -> f32 {
    const MANTISSA: u32 = 23;
    const BIAS: u32 = 127;
    if x == 0 {
        return 0.0;
    }
    if fraction_bits >= BIAS {
        return f32::NAN;
    }
    // The highest set bit goes to the top. Bits below the mantissa are lost.
    let zeros = x.unsigned_abs().leading_zeros();
    let amount = x.unsigned_abs() << zeros;
    let lost = amount << (MANTISSA + 1) != 0;
    let away_from_zero = up == (x > 0);
    let sign = (x < 0) as u32;
    let exponent = BIAS + 31 - zeros - fraction_bits;
    // The mantissa's highest bit is not stored: it adds one to the exponent. So does a mantissa that overflows.
    let bits = ((exponent - 1) << MANTISSA) + (amount >> (31 - MANTISSA)) + (lost && away_from_zero) as u32;
    f32::from_bits(sign << 31 | bits)
}

#[cfg(feature = "glam")]
impl From<(glam::Vec3, glam::Vec3)> for Aabb {
    fn from((min, max): (glam::Vec3, glam::Vec3)) -> Self {
        Self::new(min.to_array(), max.to_array())
    }
}

#[cfg(feature = "glam")]
impl From<Aabb> for (glam::Vec3, glam::Vec3) {
    fn from(aabb: Aabb) -> Self {
        (aabb.min.into(), aabb.max.into())
    }
}

#[cfg(feature = "mint")]
impl From<[mint::Point3<f32>; 2]> for Aabb {
    fn from([min, max]: [mint::Point3<f32>; 2]) -> Self {
        Self::new(min.into(), max.into())
    }
}

#[cfg(feature = "mint")]
impl From<Aabb> for [mint::Point3<f32>; 2] {
    fn from(aabb: Aabb) -> Self {
        [aabb.min.into(), aabb.max.into()]
    }
}

impl KeyBox {
    /// The keys of a box; `None` if it has NaN in it or a minimum above its maximum.
    #[inline(always)]
    pub(crate) fn from_aabb(aabb: &Aabb) -> Option<Self> {
        let [a, b, c] = aabb.min;
        let [d, e, f] = aabb.max;
        let keys = Self { min: [key(a), key(b), key(c)], max: [key(d), key(e), key(f)] };
        keys.is_valid().then_some(keys)
    }

    pub(crate) fn to_aabb(self) -> Aabb {
        Aabb { min: self.min.map(value), max: self.max.map(value) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::boxes::Boxes;
    use proptest::prelude::*;

    /// Boxes whose corners are anywhere, near the ends of the range, or near powers of two.
    fn corner() -> impl Strategy<Value = i32> {
        let near = (0u32..32, -2i32..3, any::<bool>()).prop_map(|(bit, off, negative)| {
            let x = (1u32 << bit).wrapping_add_signed(off) as i32;
            if negative { x.wrapping_neg() } else { x }
        });
        prop_oneof![any::<i32>(), -99i32..99, near, Just(i32::MIN), Just(i32::MAX)]
    }

    fn fixed_box() -> impl Strategy<Value = [[i32; 3]; 2]> {
        let corners = || [corner(), corner(), corner()];
        (corners(), corners()).prop_map(|(a, b)| {
            let each = |choose: fn(i32, i32) -> i32| [0, 1, 2].map(|k| choose(a[k], b[k]));
            [each(i32::min), each(i32::max)]
        })
    }

    fn in_f64(corner: [i32; 3], fraction_bits: u32) -> [f64; 3] {
        corner.map(|x| f64::from(x) / 2f64.powi(fraction_bits as i32))
    }

    fn overlap([a, b]: [[i32; 3]; 2], [c, d]: [[i32; 3]; 2]) -> bool {
        (0..3).all(|k| a[k] <= d[k] && c[k] <= b[k])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn fixed_point_is_rounded_as_f64_is([min, max] in fixed_box(), fraction_bits in 0u32..=126) {
            let aabb = Aabb::from_fixed(min, max, fraction_bits);
            let [low, high] = [min, max].map(|corner| in_f64(corner, fraction_bits));
            prop_assert_eq!(aabb, Aabb::from_f64(low, high, [0.0; 3]));
            prop_assert!(aabb.is_valid());
        }

        #[test]
        fn fixed_point_loses_no_overlap(a in fixed_box(), b in fixed_box(), fraction_bits in 0u32..=126) {
            let [first, second] = [a, b].map(|[min, max]| Aabb::from_fixed(min, max, fraction_bits));
            prop_assert!(first.overlaps(&second) || !overlap(a, b));
        }

        #[test]
        fn fixed_point_of_24_bits_is_exact(a in fixed_box(), b in fixed_box(), fraction_bits in 0u32..=126) {
            // 24 bits of amount, and the sign.
            let [a, b] = [a, b].map(|corners| corners.map(|corner| corner.map(|x| x >> 7)));
            let [first, second] = [a, b].map(|[min, max]| Aabb::from_fixed(min, max, fraction_bits));
            prop_assert_eq!(first.overlaps(&second), overlap(a, b));
            prop_assert_eq!(first.min.map(f64::from), in_f64(a[0], fraction_bits));
            prop_assert_eq!(first.max.map(f64::from), in_f64(a[1], fraction_bits));
        }
    }

    #[test]
    fn items_end_where_one_is_cut_off() {
        let bytes = [0u8; 3 * 40 + 31];
        for (max_at, count) in [(12, 4), (19, 4), (20, 3)] {
            let boxes = Boxes::strided(&bytes, 40, max_at).unwrap();
            assert_eq!(boxes.len(), count);
            for index in [0, 1, 2, 3, 4, usize::MAX / 40 + 2, usize::MAX] {
                assert_eq!(boxes.get(index).is_some(), index < count, "{max_at}, {index}");
            }
        }
    }

    #[test]
    fn too_many_fraction_bits_are_refused() {
        assert!(Aabb::from_fixed([1; 3], [i32::MAX; 3], 126).is_valid());
        assert!(!Aabb::from_fixed([1; 3], [i32::MAX; 3], 127).is_valid());
        assert!(!Aabb::from_fixed([i32::MIN; 3], [0; 3], u32::MAX).is_valid());
    }
}
