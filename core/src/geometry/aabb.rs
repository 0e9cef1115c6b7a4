//! Boxes as callers give them.

use super::key::{KeyBox, key, value};
use bytemuck::{Pod, Zeroable};

/// An axis-aligned bounding box in `f32`, closed on all sides: touching boxes overlap.
///
/// Any unit is right if all boxes use the same. Infinite bounds are allowed (a ground plane, a half-space).
/// The [`World`](crate::World) refuses NaN and `min > max`.
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

    /// The least box that holds a box in `f64`, relative to `origin`. Minima are rounded down and maxima up,
    /// so boxes that overlap in `f64` overlap in `f32` too. Rounding to nearest would leave parts of objects
    /// outside their boxes.
    ///
    /// Keep `origin` near the objects: far from it boxes lose precision, but never a pair. Add margins of
    /// your own to the `f64` box, so that the rounding comes after them.
    #[must_use]
    pub fn from_f64(min: [f64; 3], max: [f64; 3], origin: [f64; 3]) -> Self {
        let low = |k: usize| round_down(min[k], origin[k]);
        let high = |k: usize| round_up(max[k], origin[k]);
        Self { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] }
    }

    /// The least box that holds a box in fixed point. A coordinate `x` means `x / 2^fraction_bits` units: 16
    /// fraction bits are the usual Q16.16, 0 whole numbers. Minima are rounded down, maxima up, so boxes that
    /// overlap in fixed point overlap in `f32`. Coordinates of at most 24 significant bits, such as all from
    /// -2^24 to 2^24, are exact, and so are their overlaps.
    ///
    /// Uses integer operations alone, so a processor without FPU calls no soft-float. With more than 126
    /// fraction bits the box is not [valid](Self::is_valid), since `f32` does not go so low.
    ///
    /// ```
    /// use trisap_core::Aabb;
    ///
    /// const HALF: i32 = 1 << 15;
    /// assert_eq!(Aabb::from_fixed([-HALF; 3], [3 * HALF; 3], 16), Aabb::new([-0.5; 3], [1.5; 3]));
    /// ```
    #[must_use]
    pub const fn from_fixed(min: [i32; 3], max: [i32; 3], fraction_bits: u32) -> Self {
        const fn corner([x, y, z]: [i32; 3], fraction_bits: u32, up: bool) -> [f32; 3] {
            [fixed(x, fraction_bits, up), fixed(y, fraction_bits, up), fixed(z, fraction_bits, up)]
        }
        Self { min: corner(min, fraction_bits, false), max: corner(max, fraction_bits, true) }
    }

    /// Whether a world accepts the box: no NaN, and `min <= max` on every axis.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        KeyBox::from_aabb(self).is_some()
    }

    /// Whether the closed boxes share a point; false if one of them is not [valid](Self::is_valid). Exact
    /// also if the host flushes denormals to zero, since integers are compared, as in a step.
    #[doc(alias("intersects", "intersects_aabb"))]
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        match (KeyBox::from_aabb(self), KeyBox::from_aabb(other)) {
            (Some(a), Some(b)) => a.overlaps(&b),
            _ => false,
        }
    }

    /// A box from its centre and its half extents.
    ///
    /// ```
    /// use trisap_core::Aabb;
    ///
    /// let cube = Aabb::from_center([1.0; 3], [0.5; 3]);
    /// assert_eq!(cube, Aabb::new([0.5; 3], [1.5; 3]));
    /// assert_eq!((cube.center(), cube.half_extents()), ([1.0; 3], [0.5; 3]));
    /// assert!(cube.contains_point([1.5; 3]) && !cube.contains_point([1.0, 1.0, 2.0]));
    /// ```
    #[doc(alias = "from_half_extents")]
    #[must_use]
    pub fn from_center(center: [f32; 3], half_extents: [f32; 3]) -> Self {
        let corner = |sign: f32| [0, 1, 2].map(|k| center[k] + sign * half_extents[k]);
        Self::new(corner(-1.0), corner(1.0))
    }

    /// The centre; NaN on an axis without bounds.
    #[must_use]
    pub fn center(&self) -> [f32; 3] {
        // Halves first, so that the sum cannot overflow.
        [0, 1, 2].map(|k| 0.5 * self.min[k] + 0.5 * self.max[k])
    }

    /// The lengths of the sides.
    #[must_use]
    pub fn extents(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| self.max[k] - self.min[k])
    }

    /// Half of the lengths of the sides.
    #[must_use]
    pub fn half_extents(&self) -> [f32; 3] {
        self.extents().map(|length| 0.5 * length)
    }

    /// The least box that holds both.
    #[doc(alias("merged", "merge"))]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    /// The part that both have, which may be flat; `None` if they do not [overlap](Self::overlaps).
    ///
    /// ```
    /// use trisap_core::Aabb;
    ///
    /// let (a, b) = (Aabb::new([0.0; 3], [2.0; 3]), Aabb::new([1.0, 1.0, 2.0], [5.0; 3]));
    /// assert_eq!(a.intersection(&b), Some(Aabb::new([1.0, 1.0, 2.0], [2.0; 3])));
    /// assert_eq!((a.volume(), a.distance_to_point([5.0, 6.0, 1.0])), (8.0, 5.0));
    /// ```
    #[doc(alias = "intersect")]
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let larger = |k: usize| self.min[k].max(other.min[k]);
        let smaller = |k: usize| self.max[k].min(other.max[k]);
        self.overlaps(other).then(|| Self::new([0, 1, 2].map(larger), [0, 1, 2].map(smaller)))
    }

    /// The product of the lengths of the sides; NaN where one is zero and another has no bounds.
    #[must_use]
    pub fn volume(&self) -> f32 {
        self.extents().iter().product()
    }

    /// How far a finite point is from the box, in `f64` as in [`Hit`](crate::Hit); zero inside.
    #[doc(alias = "distance_to_local_point")]
    #[must_use]
    pub fn distance_to_point(&self, point: [f32; 3]) -> f64 {
        libm::sqrt(self.squared_distance(&point))
    }

    /// The square of that.
    #[inline(always)]
    pub(crate) fn squared_distance(&self, point: &[f32; 3]) -> f64 {
        let gap = |k: usize| {
            let (x, low, high) = (widened(point[k]), widened(self.min[k]), widened(self.max[k]));
            let beyond = if low - x > x - high { low - x } else { x - high };
            let gap = if beyond > 0.0 { beyond } else { 0.0 };
            gap * gap
        };
        gap(0) + gap(1) + gap(2)
    }

    /// Whether the other box is inside this one, sides included. False if a number is NaN.
    #[must_use]
    pub fn contains(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }

    /// Whether a point is inside, sides included.
    #[must_use]
    pub fn contains_point(&self, point: [f32; 3]) -> bool {
        self.contains(&Self::new(point, point))
    }

    /// The box grown by a length on every side; a negative length makes it smaller.
    #[doc(alias("loosened", "inflate", "expand"))]
    #[must_use]
    pub fn grown(&self, length: f32) -> Self {
        Self { min: self.min.map(|low| low - length), max: self.max.map(|high| high + length) }
    }

    /// The box moved by a vector.
    #[must_use]
    pub fn translated(&self, by: [f32; 3]) -> Self {
        Self { min: [0, 1, 2].map(|k| self.min[k] + by[k]), max: [0, 1, 2].map(|k| self.max[k] + by[k]) }
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
    match (x.is_subnormal(), x.is_sign_negative()) {
        (true, true) => -f64::MIN_POSITIVE,
        (true, false) => 0.0,
        _ => x,
    }
}

/// The greatest `f32` that is not above `x`, or NaN. No operation makes or takes a denormal, so a host that
/// flushes these gets the same.
pub(crate) const fn narrowed(x: f64) -> f32 {
    if x.abs() < f32::MIN_POSITIVE as f64 {
        // In steps of the least denormal, the keys there. A denormal `f64` below zero is a whole step, too.
        let steps = x * (1.0 / DENORMAL);
        let toward_zero = steps as i32;
        let is_less = toward_zero as f64 > steps || toward_zero == 0 && x.to_bits() > 1 << 63;
        return value(toward_zero - is_less as i32);
    }
    let nearest = x as f32;
    if nearest as f64 > x { nearest.next_down() } else { nearest }
}

/// The least `f32` above zero.
const DENORMAL: f64 = f64::from_bits((1023 - 149) << 52);

/// A number as `f64`; a denormal by its bits, for the same reason.
#[inline(always)]
pub(crate) const fn widened(x: f32) -> f64 {
    let (bits, least) = (x.to_bits(), f32::MIN_POSITIVE.to_bits());
    if bits & f32::INFINITY.to_bits() != 0 {
        return x as f64;
    }
    // With the least normal number added, and without it again.
    f32::from_bits(bits | least) as f64 - f32::from_bits(bits & 1 << 31 | least) as f64
}

/// `x / 2^fraction_bits` rounded up or down to `f32`, or NaN if that may be denormal.
const fn fixed(x: i32, fraction_bits: u32, up: bool) -> f32 {
    const MANTISSA: u32 = 23;
    const BIAS: u32 = 127;
    if fraction_bits >= BIAS {
        return f32::NAN;
    }
    if x == 0 {
        return 0.0;
    }
    // The highest set bit goes to the top. Bits below the mantissa are lost.
    let zeros = x.unsigned_abs().leading_zeros();
    let amount = x.unsigned_abs() << zeros;
    let lost = amount << (MANTISSA + 1) != 0;
    let away_from_zero = up == (x > 0);
    let sign = (x < 0) as u32;
    let exponent = BIAS + 31 - zeros - fraction_bits;
    // The mantissa's highest bit is not stored: it adds one to the exponent, as an overflow does.
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
