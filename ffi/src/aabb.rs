//! Boxes and points as callers have them.

use trisap_core::Aabb;

/// An axis-aligned bounding box, closed on all sides: touching boxes overlap. Any unit of length. Infinite bounds are
/// allowed; NaN and a minimum above its maximum are refused.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct trisap_aabb {
    /// The lowest corner: x, y, z.
    pub min: [f32; 3],
    /// The highest corner: x, y, z.
    pub max: [f32; 3],
}

impl From<trisap_aabb> for Aabb {
    fn from(aabb: trisap_aabb) -> Self {
        Self::new(aabb.min, aabb.max)
    }
}

impl From<Aabb> for trisap_aabb {
    fn from(aabb: Aabb) -> Self {
        Self { min: aabb.min, max: aabb.max }
    }
}

/// The least box in `f32` that holds a box in `f64`, seen from `origin`. Minima are rounded down and maxima up, so
/// boxes that overlap in `f64` overlap in `f32` too; nearest rounding would lose pairs far from the origin. All three
/// arguments are three numbers. O(1).
///
/// Keep `origin` near the objects: far from it precision is lost, never a pair. Add a margin of your own to the `f64`
/// box, so that the rounding comes after it.
///
/// If an argument is null, or a number is NaN, the result is a box that every function refuses.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_aabb_from_f64(
    min: *const f64,
    max: *const f64,
    origin: *const f64,
) -> trisap_aabb {
    // SAFETY: the caller's promise.
    let corners = unsafe { [point(min, f64::NAN), point(max, f64::NAN), point(origin, f64::NAN)] };
    let [min, max, origin] = corners;
    Aabb::from_f64(min, max, origin).into()
}

/// The least box that holds a box in fixed point: integers that count `2^-fraction_bits` each. It takes integer
/// operations alone, and is exact where 24 significant bits suffice, rounded outward beyond. Both corners are three
/// numbers. O(1).
///
/// If an argument is null, or there are more than 126 fraction bits, the result is a box that every function refuses.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_aabb_from_fixed(
    min: *const i32,
    max: *const i32,
    fraction_bits: u32,
) -> trisap_aabb {
    if min.is_null() || max.is_null() {
        return trisap_aabb { min: [f32::NAN; 3], max: [f32::NAN; 3] };
    }
    // SAFETY: not null, and the caller's promise.
    let [min, max] = unsafe { [point(min, 0), point(max, 0)] };
    Aabb::from_fixed(min, max, fraction_bits).into()
}

/// The caller's point. For null a point of NaN, which every use refuses.
///
/// # Safety
/// A pointer that is not null points to three numbers.
pub(crate) unsafe fn point<T: Copy>(first: *const T, nan: T) -> [T; 3] {
    if first.is_null() {
        return [nan; 3];
    }
    // SAFETY: not null, and by the caller's promise three numbers; no alignment is asked for.
    unsafe { first.cast::<[T; 3]>().read_unaligned() }
}
