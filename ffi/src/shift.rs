//! Moves the origin of a world close to its objects.

use crate::aabb::point;
use crate::border;
use crate::call::{Call, trisap_world, with};
use crate::status::trisap_status;

/// Moves the origin to a point: subtracts the three numbers `by` from all boxes. Give boxes relative to the new
/// origin from then on. Pairs and events stay right. O(n), and the next step takes as long as the first one.
///
/// If a difference is no `float`, minima are rounded down and maxima up: no pair is lost, but boxes may come to
/// overlap. `rounded`, which may be null, tells how many objects had their boxes rounded; it is zero for shifts by
/// multiples of the finest step of all coordinates.
///
/// Errors: `TRISAP_STATUS_BAD_SHIFT`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_shift_origin(
    world: *mut trisap_world,
    by: *const f64,
    rounded: *mut u32,
) -> trisap_status {
    let shift = |call: &mut Call| {
        let range = call.range();
        border::span(by, 3, &range)?;
        if !rounded.is_null() {
            border::span(rounded, 1, &range)?;
        }
        // SAFETY: not null, and the caller's promise.
        let by = unsafe { point(by, f64::NAN) };
        let count = call.world.shift_origin(by)?;
        if !rounded.is_null() {
            // SAFETY: aligned, and outside of the world.
            unsafe { rounded.write(count) };
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, shift) }
}
