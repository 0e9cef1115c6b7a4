//! Plain data. Structs that may grow begin with their size; `trisap_default_...` functions fill it in.

use crate::aabb::trisap_aabb;
use crate::status::trisap_status;
use core::ffi::{c_char, c_void};
use trisap_core::{Capacity, Config, Hit, Margin, Mode};

/// Names an object while it lives. Opaque except for its slot; never zero. The id of a removed object stays stale
/// when its slot is used again.
pub type trisap_id = u64;

/// The id of no object.
pub const TRISAP_NULL_ID: trisap_id = 0;

/// Two overlapping objects by slot.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct trisap_pair {
    /// The lower slot.
    pub a: u32,
    /// The higher slot.
    pub b: u32,
}

/// Exactly the overlaps of the boxes as given: for `trisap_config::mode`.
pub const TRISAP_MODE_EXACT: u32 = 0;
/// The overlaps of the boxes with their margins, a superset that changes less often: for `trisap_config::mode`.
pub const TRISAP_MODE_FAT: u32 = 1;

/// What a world is made for. Filled by `trisap_default_config`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_config {
    /// The size of this struct in bytes.
    pub struct_size: u32,
    /// The most living objects. By default the number that the default function was given.
    pub objects: u32,
    /// The most boxes that reach beyond their leaf of the tree. If a scene has more, steps are slower. By default
    /// half of `objects`.
    pub leaf_refs: u32,
    /// The most pairs that a step can return. By default eight an object.
    pub pairs: u32,
    /// `TRISAP_MODE_EXACT` (the default) or `TRISAP_MODE_FAT`.
    pub mode: u32,
    /// 1 if steps tell found and lost pairs; costs memory for a second set of pairs and boxes. By default 0.
    pub events: u32,
    /// 1 if objects have a `trisap_filter`, which says whom they meet; costs 12 bytes an object. By default 0.
    pub filters: u32,
    /// The most workers of a step, 1 to 32, the calling thread included; each costs scratch memory. By default 1.
    pub workers: u32,
    /// 1 if a world for up to 256 objects does without a tree, vectors and scratch memory: for microcontrollers.
    /// Worlds for up to 64 objects always do. By default 0.
    pub lean: u32,
    /// 1 if boxes get a margin, inside which they move at hardly any cost for a step; pays where many objects rest or
    /// move little. By default 0.
    pub has_margin: u32,
    /// The margin as a share of the object's largest side. By default 0.
    pub margin_per_extent: f32,
    /// Lower bound of the margin, a length. By default 0.
    pub margin_min: f32,
    /// Upper bound of the margin, a length. By default the largest float.
    pub margin_max: f32,
    /// 1 if fat boxes stay in use however objects move. By default 0: all are made anew when that costs less than to search for
    /// the objects that leave theirs, and are left unused for some steps where they cost more than they spare. In a fat world it
    /// changes which pairs are told.
    pub fixed_margins: u32,
    /// 1 if objects have a value of 64 bits for the caller's use; costs 8 bytes an object, 16 with events. By default
    /// 0.
    pub values: u32,
    /// 1, the default, if swept boxes are predicted from the motion of each object and hold it for some steps: steps in which
    /// things lie, hang, roll or fly on cost little. Changes no pair; needs no margin; costs 24 bytes an object.
    pub predicted_boxes: u32,
}

impl trisap_config {
    pub(crate) fn to_core(self) -> Result<Config, trisap_status> {
        let flag = |value: u32| match value {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(trisap_status::InvalidArgument),
        };
        let mode = match self.mode {
            TRISAP_MODE_EXACT => Mode::Exact,
            TRISAP_MODE_FAT => Mode::Fat,
            _ => return Err(trisap_status::InvalidArgument),
        };
        let margin =
            Margin { per_extent: self.margin_per_extent, min: self.margin_min, max: self.margin_max };
        let capacity = Capacity::for_objects(self.objects).with_leaf_refs(self.leaf_refs);
        let mut config =
            Config::new(capacity.with_pairs(self.pairs)).with_mode(mode).with_workers(self.workers);
        config.margin = flag(self.has_margin)?.then_some(margin);
        config.events = flag(self.events)?;
        config.filters = flag(self.filters)?;
        config.values = flag(self.values)?;
        config.lean = flag(self.lean)?;
        config.fixed_margins = flag(self.fixed_margins)?;
        config.predicted = flag(self.predicted_boxes)?;
        Ok(config)
    }

    pub(crate) fn from_core(config: &Config) -> Self {
        let margin = config.margin.unwrap_or(Margin::share(0.0));
        Self {
            struct_size: size_of::<Self>() as u32,
            objects: config.capacity.objects,
            leaf_refs: config.capacity.leaf_refs,
            pairs: config.capacity.pairs,
            mode: match config.mode {
                Mode::Exact => TRISAP_MODE_EXACT,
                Mode::Fat => TRISAP_MODE_FAT,
            },
            events: u32::from(config.events),
            filters: u32::from(config.filters),
            workers: config.workers,
            lean: u32::from(config.lean),
            has_margin: u32::from(config.margin.is_some()),
            margin_per_extent: margin.per_extent,
            margin_min: margin.min,
            margin_max: margin.max,
            fixed_margins: u32::from(config.fixed_margins),
            values: u32::from(config.values),
            predicted_boxes: u32::from(config.predicted),
        }
    }
}

/// A configuration for `objects` objects with the proportions that suit most scenes: exact pairs, no events, no
/// filters, no values, no margin, one worker. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_default_config(objects: u32) -> trisap_config {
    trisap_config::from_core(&Config::new(Capacity::for_objects(objects)))
}

/// Boxes in the caller's memory. Each item has three floats of the minimum and three of the maximum at fixed places.
/// Filled by `trisap_default_boxes`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_boxes {
    /// The size of this struct in bytes.
    pub struct_size: u32,
    /// Bytes from an item's minimum to its maximum, at least 12. By default 12; 16 if corners are padded to four
    /// floats.
    pub max_offset: u32,
    /// The minimum of the first item. Any alignment is right. May be null if `count` is zero.
    pub first: *const c_void,
    /// Bytes from the minimum of an item to the minimum of the next one, at least `max_offset` + 12. By default 24.
    pub stride: usize,
    /// How many items there are.
    pub count: usize,
}

/// The caller's job system. Filled by `trisap_default_jobs`; used within the call that it is given to.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_jobs {
    /// The size of this struct in bytes.
    pub struct_size: u32,
    /// How many calls of `run` can run at once, the calling thread's own included. With 1, the default, `fork_join` is
    /// never called. Neither is it by the steps of a world whose `workers` are 1: those are for as many at most.
    pub worker_count: u32,
    /// Passed to `fork_join`.
    pub user: *mut c_void,
    /// Calls `run(task)` `count` times, at the same time if possible, and returns when all these calls have returned.
    ///
    /// `count` is at least 2, and at most `worker_count`; in a step also at most the world's `workers`. The
    /// calling thread is idle until `fork_join` returns: let it make one of the calls. `name` is a text for profilers. Worlds of less than a few
    /// thousand objects never call, since a step takes less time than sharing it.
    ///
    /// Each call of `run` takes blocks of work until none are left, and the step makes a last call itself. So fewer
    /// calls, more calls, late calls, calls one after another, or none at all give the same result, byte for byte.
    /// `run` never blocks, locks, allocates or calls back, and needs less than 16 KiB of stack.
    ///
    /// Must return only when every call of `run` that has begun or may still begin has returned: `task` is on the
    /// stack of the step. Must order memory as mutexes, joined threads and release-acquire atomics do: what the
    /// calling thread did before comes before every call, and every call before the return. Must not call into the
    /// same world, which is refused as busy, and must not throw. May be null only if `worker_count` is 1.
    pub fork_join: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            run: Option<unsafe extern "C" fn(task: *mut c_void)>,
            task: *mut c_void,
            count: u32,
            name: *const c_char,
        ),
    >,
}

/// The result of a step. Made by `trisap_default_result`, filled by the step.
///
/// The arrays are in the memory of the world and stay as they are until its next step or `trisap_world_load`:
/// inserting, updating and removing do not touch them. Never null, also if they are empty.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_result {
    /// The size of this struct in bytes.
    pub struct_size: u32,
    /// `trisap_world_step_over`: how many objects have kept their boxes because the new ones had NaN in them or a
    /// minimum above its maximum. Unknown, and zero, after `TRISAP_STATUS_PAIRS_FULL`.
    pub rejected_count: u32,
    /// The one of them with the lowest slot, or `TRISAP_NULL_ID`.
    pub first_rejected: trisap_id,
    /// The overlapping pairs, each once, the lower slot first. Their order means nothing, but the same calls give the
    /// same order.
    pub pairs: *const trisap_pair,
    /// How many.
    pub pair_count: usize,
    /// With events: pairs of this step that the last complete step did not have. Other objects in the same slots are
    /// another pair.
    pub found: *const trisap_pair,
    /// How many.
    pub found_count: usize,
    /// With events: pairs of the last complete step that this one does not have. The slot of a removed object may
    /// have a new object by now.
    pub lost: *const trisap_pair,
    /// How many.
    pub lost_count: usize,
    /// How many pairs there are: `pair_count`, or more after `TRISAP_STATUS_PAIRS_FULL`.
    pub pairs_needed: u64,
}

/// Nothing had moved: the pairs stayed.
pub const TRISAP_PATH_UNCHANGED: u32 = 0;
/// A world without a tree: every two boxes were tested, or from 33 objects on those along a sorted list.
pub const TRISAP_PATH_LISTS: u32 = 1;
/// Few had moved: each mover was tested against the leaves that it reaches, the other pairs stayed.
pub const TRISAP_PATH_MOVERS: u32 = 2;
/// Many had moved: all leaves were filled and swept.
pub const TRISAP_PATH_FULL: u32 = 3;
/// As full, after new planes for the whole tree.
pub const TRISAP_PATH_REBUILT: u32 = 4;
/// Many have moved, but most pairs stay: all leaves were filled and swept for the pairs of moved objects alone, and
/// the other pairs stay.
pub const TRISAP_PATH_MOVERS_BY_LEAF: u32 = 5;

/// Unchanged: nothing had moved.
pub const TRISAP_REASON_NO_MOVERS: u32 = 0;
/// Lists: the world is for up to 64 objects, or lean, and has no tree.
pub const TRISAP_REASON_FEW_OBJECTS: u32 = 1;
/// Movers: few had moved: one object in 13, or fewer if objects have many pairs.
pub const TRISAP_REASON_FEW_MOVERS: u32 = 2;
/// Full: more had moved.
pub const TRISAP_REASON_MANY_MOVERS: u32 = 3;
/// Movers or full: a test has fixed it.
pub const TRISAP_REASON_FIXED: u32 = 4;
/// Full or rebuilt: there were no leaves of a complete step to use again. So it is in the first step, after one with
/// too many pairs or few objects, and after a shift of the origin.
pub const TRISAP_REASON_NOTHING_KEPT: u32 = 5;
/// Full or rebuilt: few had moved, but a leaf had no room for one of them.
pub const TRISAP_REASON_NO_ROOM: u32 = 6;
/// Rebuilt: the tree had too many leaves or levels.
pub const TRISAP_REASON_OUTGROWN: u32 = 7;
/// Rebuilt: three steps in a row had far more work than with new planes.
pub const TRISAP_REASON_OUT_OF_BALANCE: u32 = 8;
/// Lists, full or rebuilt: a world had no room in its pair buffer for the overlaps of fat boxes,
/// and also found those of the boxes that it reports. With more room steps are cheaper.
pub const TRISAP_REASON_NO_ROOM_FOR_SURPLUS: u32 = 9;
/// A reason that this version of the ABI has no name for.
pub const TRISAP_REASON_OTHER: u32 = u32::MAX;

/// What a step did and chose. All of it follows from counts, so equal calls give equal statistics on every machine.
/// Made by `trisap_default_stats`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trisap_stats {
    /// The size of this struct in bytes.
    pub struct_size: u32,
    /// How the pairs were found: one of `TRISAP_PATH_...`.
    pub path: u32,
    /// Living objects.
    pub objects: u32,
    /// Objects that were new or gone, or had left their margin (without margins: had another box).
    pub moved: u32,
    /// Leaves of the tree; 1 in a world without one.
    pub leaves: u32,
    /// Leaves that had members when all leaves were last filled. If they are far fewer than `leaves`, the planes do
    /// not fit the scene.
    pub leaves_in_use: u32,
    /// Members of the fullest leaf then. About 500 is usual. Far more means boxes that no plane can part, or a bad
    /// tree.
    pub fullest_leaf: u32,
    /// Large objects: far larger than the leaves that they reach, they are in a list of their own.
    pub large: u32,
    /// Objects whose leaves got new planes.
    pub rebalanced: u32,
    /// Why the pairs were found that way: one of `TRISAP_REASON_...`.
    pub reason: u32,
    /// 1 if leaves are divided into sub-leaves, for steps with few movers.
    pub fine_leaves: u32,
    /// 1 if the work was offered to the workers of the job system.
    pub shared: u32,
    /// How many boxes left their fat boxes since the last complete step, or are others where all fat boxes were
    /// made anew; in a fat world how many left their margins.
    pub outran: u32,
    /// Ghosts: boxes swept in leaves where they are not at home.
    pub copies: u64,
    /// Pairs of boxes that were tested on all axes.
    pub candidates: u64,
    /// Of these, pairs whose sides share a step of the grid, so that the boxes had to decide.
    pub tied: u64,
    /// Overlapping pairs.
    pub pairs: u64,
    /// Pairs that the last complete step did not have.
    pub found: u64,
    /// Pairs that only the last complete step had.
    pub lost: u64,
    /// Overlaps of fat boxes that the test of the boxes dropped.
    pub surplus: u64,
    /// Pairs of boxes in the same leaf that were not compared, since their filters do not meet.
    pub spared: u64,
}

// The header asserts the same on the other side of the border.
const _: () = {
    const POINTER: usize = size_of::<*const c_void>();
    assert!(size_of::<trisap_aabb>() == 24);
    assert!(size_of::<trisap_pair>() == 8);
    assert!(size_of::<trisap_config>() == 64);
    assert!(size_of::<trisap_boxes>() == 8 + 3 * POINTER);
    assert!(size_of::<trisap_jobs>() == 8 + 2 * POINTER);
    assert!(size_of::<trisap_result>() == 24 + 6 * POINTER);
    assert!(size_of::<trisap_stats>() == 120);
    // Pairs are handed out as they stand in the world.
    assert!(size_of::<trisap_pair>() == size_of::<trisap_core::Pair>());
    assert!(align_of::<trisap_pair>() == align_of::<trisap_core::Pair>());
};

/// An object that a cast meets, or that is near a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct trisap_hit {
    /// The object.
    pub id: trisap_id,
    /// How far the cast gets before it touches the object's box, in units of its direction; zero if it starts inside.
    /// For the nearest objects: the distance.
    pub distance: f64,
}

impl From<Hit> for trisap_hit {
    fn from(hit: Hit) -> Self {
        Self { id: hit.id.to_bits(), distance: hit.distance }
    }
}

impl trisap_hit {
    /// No object.
    pub(crate) const NONE: Self = Self { id: TRISAP_NULL_ID, distance: 0.0 };
}
