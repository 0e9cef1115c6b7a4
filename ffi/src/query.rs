//! Answers questions between two steps: what is in a region, what a moving box meets, what is nearest.
//!
//! Answers are about the boxes as they are now. No query needs a step before it.

use crate::aabb::{point, trisap_aabb};
use crate::among::{accepts, trisap_condition};
use crate::border::{self, Answers};
use crate::call::{Call, look, trisap_world};
use crate::status::{Refusal, trisap_status};
use crate::structs::{trisap_hit, trisap_id};
use core::ffi::c_void;
use core::ops::ControlFlow;
use trisap_core::{Cast, Error, Hit, Id, Region, heapsort};

/// A box: for `trisap_region::kind`.
pub const TRISAP_REGION_AABB: u32 = 0;
/// A ball: for `trisap_region::kind`.
pub const TRISAP_REGION_SPHERE: u32 = 1;

/// A closed part of space to look for objects: touching counts. Made by `trisap_region_aabb`, `trisap_region_point`
/// or `trisap_region_sphere`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_region {
    /// One of `TRISAP_REGION_...`.
    pub kind: u32,
    /// The radius of a ball, zero or more. An infinite ball holds everything.
    pub radius: f32,
    /// The lowest corner of a box; the centre of a ball.
    pub min: [f32; 3],
    /// The highest corner of a box.
    pub max: [f32; 3],
}

impl trisap_region {
    /// The region, if it is of a known kind.
    pub(crate) fn to_core(self) -> Option<Region> {
        match self.kind {
            TRISAP_REGION_AABB => Some(Region::Aabb(trisap_core::Aabb::new(self.min, self.max))),
            TRISAP_REGION_SPHERE => Some(Region::Sphere { center: self.min, radius: self.radius }),
            _ => None,
        }
    }
}

/// A box, or a point, that moves along a line. Made by `trisap_cast_ray` or `trisap_cast_swept`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_cast {
    /// Where it starts. For a ray, a box of one point. Finite.
    pub start: trisap_aabb,
    /// How it moves in one unit of distance. Finite, of any length; zero tests the start alone.
    pub direction: [f32; 3],
    /// How far it moves, in units of `direction`. Zero or more; may be infinite.
    pub distance: f32,
}

impl From<trisap_cast> for Cast {
    fn from(cast: trisap_cast) -> Self {
        Self { start: cast.start.into(), direction: cast.direction, distance: cast.distance }
    }
}

/// A box to look in. For null a region that is refused. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_region_aabb(aabb: *const trisap_aabb) -> trisap_region {
    // SAFETY: the caller's promise.
    let min = unsafe { point(aabb.cast::<f32>(), f32::NAN) };
    let max = if aabb.is_null() { aabb.cast::<f32>() } else { aabb.cast::<f32>().wrapping_add(3) };
    // SAFETY: the caller's promise.
    let max = unsafe { point(max, f32::NAN) };
    trisap_region { kind: TRISAP_REGION_AABB, radius: 0.0, min, max }
}

/// A point to look at, of three numbers. For null a region that is refused. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_region_point(position: *const f32) -> trisap_region {
    // SAFETY: the caller's promise.
    let min = unsafe { point(position, f32::NAN) };
    trisap_region { kind: TRISAP_REGION_AABB, radius: 0.0, min, max: min }
}

/// A ball to look in; its centre is three numbers. For null a region that is refused. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_region_sphere(center: *const f32, radius: f32) -> trisap_region {
    // SAFETY: the caller's promise.
    let min = unsafe { point(center, f32::NAN) };
    trisap_region { kind: TRISAP_REGION_SPHERE, radius, min, max: min }
}

/// A ray: `origin + t * direction` for `t` from zero to `distance`; both are three numbers. For null a cast that is
/// refused. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_cast_ray(
    origin: *const f32,
    direction: *const f32,
    distance: f32,
) -> trisap_cast {
    // SAFETY: the caller's promise.
    let (origin, direction) = unsafe { (point(origin, f32::NAN), point(direction, f32::NAN)) };
    trisap_cast { start: trisap_aabb { min: origin, max: origin }, direction, distance }
}

/// A box that moves by `direction`, which is three numbers. For null a cast that is refused. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_cast_swept(start: *const trisap_aabb, direction: *const f32) -> trisap_cast {
    // SAFETY: the caller's promise.
    let (start, direction) = unsafe { (trisap_region_aabb(start), point(direction, f32::NAN)) };
    trisap_cast { start: trisap_aabb { min: start.min, max: start.max }, direction, distance: 1.0 }
}

/// # Safety
/// A pointer that is not null points to a region.
unsafe fn region(region: *const trisap_region) -> Result<Region, Refusal> {
    border::check(region)?;
    // SAFETY: aligned, not null, and initialised by the caller's promise.
    let region = unsafe { region.read() };
    Ok(region.to_core().ok_or(Error::BadQuery { index: 0 })?)
}

/// # Safety
/// A pointer that is not null points to a cast.
unsafe fn cast(cast: *const trisap_cast) -> Result<Cast, trisap_status> {
    border::check(cast)?;
    // SAFETY: aligned, not null, and initialised by the caller's promise.
    Ok(unsafe { cast.read() }.into())
}

/// Writes the objects whose boxes overlap a region to `ids`, which has room for `room` of them, by ascending slot,
/// and their number to `count`. Expected O(log n + *a* log *a* + movers since the last step) for *a* answers; O(n) if
/// the last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_OUTPUT_FULL`. After the second one the number is right, and `ids`
/// holds some of them.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_overlaps(
    world: *const trisap_world,
    region: *const trisap_region,
    condition: trisap_condition,
    user: *mut c_void,
    ids: *mut trisap_id,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let (region, answers) =
            unsafe { (self::region(region)?, Answers::new(ids, room, count, &call.range())?) };
        let world = &call.world;
        collect_ids(answers, accepts(condition, user), |visit| world.visit_overlaps(&region, visit))
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the ids that `ask` visits and that may answer, by ascending slot.
pub(crate) fn collect_ids(
    mut answers: Answers<trisap_id>,
    condition: impl Fn(Id) -> bool,
    ask: impl FnOnce(&mut dyn FnMut(Id) -> ControlFlow<()>) -> Result<(), Error>,
) -> Result<(), Refusal> {
    ask(&mut |id| {
        if condition(id) {
            answers.push(id.to_bits());
        }
        ControlFlow::Continue(())
    })?;
    answers.written().sort_unstable_by_key(|id| *id as u32);
    answers.conclude()
}

/// Called with an object; 0 ends the visit. Calls that change the same world are refused as busy.
pub type trisap_visit_id = Option<unsafe extern "C" fn(user: *mut c_void, id: trisap_id) -> u32>;

/// A visitor in the core's form.
pub(crate) fn visitor(
    visit: trisap_visit_id,
    user: *mut c_void,
) -> Result<impl FnMut(Id) -> ControlFlow<()>, trisap_status> {
    let visit = visit.ok_or(trisap_status::NullPointer)?;
    // SAFETY: called as its contract says.
    Ok(move |id: Id| match unsafe { visit(user, id.to_bits()) } {
        0 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    })
}

/// Visits the objects whose boxes overlap a region, each once, until the visitor ends it. The same calls give the
/// same order. `user` is passed to the visitor. Expected O(log n + answers + movers since the last step); O(n) if the
/// last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_visit_overlaps(
    world: *const trisap_world,
    region: *const trisap_region,
    visit: trisap_visit_id,
    user: *mut c_void,
) -> trisap_status {
    let ask = |call: &Call| {
        let mut visit = visitor(visit, user)?;
        // SAFETY: the caller's promise.
        let region = unsafe { self::region(region)? };
        Ok(call.world.visit_overlaps(&region, &mut visit)?)
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the first object that a cast meets to `hit`; of several at one distance the one with the lowest slot; if it
/// meets none, `TRISAP_NULL_ID`. Expected O(leaves on the way and their objects + movers since the last step); O(n)
/// if the last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_first_hit(
    world: *const trisap_world,
    cast: *const trisap_cast,
    condition: trisap_condition,
    user: *mut c_void,
    hit: *mut trisap_hit,
) -> trisap_status {
    let ask = |call: &Call| {
        border::span(hit, 1, &call.range())?;
        // SAFETY: the caller's promise.
        let cast = unsafe { self::cast(cast)? };
        let first = call.world.among(accepts(condition, user)).first_hit(&cast)?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { hit.write(first.map_or(trisap_hit::NONE, Into::into)) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the objects that a cast meets to `hits`, which has room for `room` of them, the nearest first, equally near
/// ones by ascending slot, and their number to `count`. Expected as `trisap_world_first_hit`, and the sort of the hits.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_OUTPUT_FULL`. After the second one the number is right, and `hits`
/// holds some of them.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_hits(
    world: *const trisap_world,
    cast: *const trisap_cast,
    condition: trisap_condition,
    user: *mut c_void,
    hits: *mut trisap_hit,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let (cast, mut answers) =
            unsafe { (self::cast(cast)?, Answers::new(hits, room, count, &call.range())?) };
        let condition = accepts(condition, user);
        call.world.visit_hits(&cast, &mut |hit| {
            if condition(hit.id) {
                answers.push(trisap_hit::from(hit));
            }
            f64::INFINITY
        })?;
        // Hits are few, and this is shorter than the sort of `core`.
        let place = |hit: trisap_hit| (hit.distance, hit.id as u32);
        heapsort(answers.written(), |a, b| place(a) < place(b));
        answers.conclude()
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Called with a hit. Returns how far to look on: infinity to see all, the hit's distance to see only what is not
/// farther, less than zero to stop. Calls that change the same world are refused as busy.
pub type trisap_visit_hit = Option<unsafe extern "C" fn(user: *mut c_void, hit: trisap_hit) -> f64>;

/// Visits the objects that a cast meets, each once, nearer leaves of the tree before farther ones. `user` is handed to
/// the visitor. Expected as `trisap_world_first_hit`.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_visit_hits(
    world: *const trisap_world,
    cast: *const trisap_cast,
    visit: trisap_visit_hit,
    user: *mut c_void,
) -> trisap_status {
    let ask = |call: &Call| {
        let visit = visit.ok_or(trisap_status::NullPointer)?;
        // SAFETY: the caller's promise.
        let cast = unsafe { self::cast(cast)? };
        // SAFETY: called as its contract says.
        let mut visit = |hit: Hit| unsafe { visit(user, hit.into()) };
        Ok(call.world.visit_hits(&cast, &mut visit)?)
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Visits the objects whose boxes are at most `distance` from a point of three numbers, each once, nearer leaves of the tree
/// before farther ones. `user` is handed to the visitor. A visitor that returns infinity for what it refuses, and for the rest the
/// distance of the shape in the box, has seen the nearest shape. Expected as `trisap_world_nearest`.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, also where the distance is NaN or negative.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_visit_nearest(
    world: *const trisap_world,
    position: *const f32,
    distance: f64,
    visit: trisap_visit_hit,
    user: *mut c_void,
) -> trisap_status {
    let ask = |call: &Call| {
        let visit = visit.ok_or(trisap_status::NullPointer)?;
        border::check(position)?;
        // SAFETY: the caller's promise.
        let position = unsafe { point(position, f32::NAN) };
        // SAFETY: called as its contract says.
        let mut visit = |hit: Hit| unsafe { visit(user, hit.into()) };
        Ok(call.world.visit_nearest(position, distance, &mut visit)?)
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the objects whose boxes are nearest to a point of three numbers to `hits`, as many as it has room for, the
/// nearest first, equally near ones by ascending slot, and their number to `count`: less than `room` only if there are
/// no more objects. Boxes at infinity come last. Squares of distances are compared, and two of them can have the same
/// root. Expected O(log n + room log room + movers since the last step); O(n log room) where the last step had no tree.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_nearest(
    world: *const trisap_world,
    position: *const f32,
    condition: trisap_condition,
    user: *mut c_void,
    hits: *mut trisap_hit,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        let range = call.range();
        border::check(position)?;
        border::span(count, 1, &range)?;
        // SAFETY: the caller's promise.
        let position = unsafe { point(position, f32::NAN) };
        let world = &call.world;
        // SAFETY: the caller's promise.
        let mut hits = unsafe { border::Hits::new(hits, room.min(world.len() as usize), &range)? };
        let found = world.among(accepts(condition, user)).nearest(position, hits.as_options());
        hits.settle();
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { count.write(found?) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

// The header asserts the same on the other side of the border.
const _: () = {
    assert!(size_of::<trisap_region>() == 32);
    assert!(size_of::<trisap_cast>() == 40);
    assert!(size_of::<trisap_hit>() == 16);
};
