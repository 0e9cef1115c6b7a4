//! Shows the tree, for debug views. Nothing if the last step had no tree.

use crate::aabb::trisap_aabb;
use crate::border::Answers;
use crate::call::{Call, look, trisap_world};
use crate::status::trisap_status;
use crate::structs::trisap_id;
use trisap_core::{LeafView, PlaneView};

/// A leaf of the tree.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_leaf {
    /// The part of space whose minimum corners are at home in the leaf; infinite at the rim.
    pub cell: trisap_aabb,
    /// The objects that were in it at the last step.
    pub objects: u32,
}

impl From<LeafView> for trisap_leaf {
    fn from(leaf: LeafView) -> Self {
        Self { cell: leaf.cell.into(), objects: leaf.objects }
    }
}

/// A plane of the tree.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_plane {
    /// The part of space that it divides; infinite at the rim.
    pub cell: trisap_aabb,
    /// The axis that it divides: 0 for x, 1 for y, 2 for z.
    pub axis: u32,
    /// Its place on that axis.
    pub position: f32,
    /// How many planes are above it.
    pub depth: u32,
}

impl From<PlaneView> for trisap_plane {
    fn from(plane: PlaneView) -> Self {
        Self {
            cell: plane.cell.into(),
            axis: plane.axis as u32,
            position: plane.position,
            depth: plane.depth,
        }
    }
}

/// Writes the leaves, from left to right, to `leaves`, which has room for `room` of them, and their number to `count`.
/// `trisap_stats` also counts empty ones that are nowhere. O(leaves).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. After it the number is right, and the room holds as many as fit.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_leaves(
    world: *const trisap_world,
    leaves: *mut trisap_leaf,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let mut answers = unsafe { Answers::new(leaves, room, count, &call.range())? };
        call.world.leaves().for_each(|leaf| answers.push(leaf.into()));
        answers.conclude()
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the planes, from the root down, to `planes`, which has room for `room` of them, and their number to `count`.
/// O(leaves log leaves).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. After it the number is right, and the room holds as many as fit.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_planes(
    world: *const trisap_world,
    planes: *mut trisap_plane,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let mut answers = unsafe { Answers::new(planes, room, count, &call.range())? };
        call.world.planes().for_each(|plane| answers.push(plane.into()));
        answers.conclude()
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the large objects, which are in no leaf, to `ids`, which has room for `room` of them, and their number to
/// `count`. O(large objects).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. After it the number is right, and the room holds as many as fit.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_large(
    world: *const trisap_world,
    ids: *mut trisap_id,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let mut answers = unsafe { Answers::new(ids, room, count, &call.range())? };
        call.world.large().for_each(|id| answers.push(id.to_bits()));
        answers.conclude()
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

// The header asserts the same on the other side of the border.
const _: () = assert!(size_of::<trisap_leaf>() == 28 && size_of::<trisap_plane>() == 36);
