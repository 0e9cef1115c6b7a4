//! Tells what steps did, and checks the whole world.

use crate::border;
use crate::call::{Call, look, trisap_world};
use crate::status::trisap_status;
use crate::structs::*;
use trisap_core::{Path, Reason};

/// Statistics of no step. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_default_stats() -> trisap_stats {
    trisap_stats {
        struct_size: size_of::<trisap_stats>() as u32,
        path: TRISAP_PATH_UNCHANGED,
        objects: 0,
        moved: 0,
        leaves: 0,
        leaves_in_use: 0,
        fullest_leaf: 0,
        large: 0,
        rebalanced: 0,
        reason: TRISAP_REASON_NO_MOVERS,
        fine_leaves: 0,
        shared: 0,
        outran: 0,
        copies: 0,
        candidates: 0,
        tied: 0,
        pairs: 0,
        found: 0,
        lost: 0,
        surplus: 0,
        spared: 0,
    }
}

/// Writes what the last step did to `stats`, which has to have its `struct_size`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_stats(
    world: *const trisap_world,
    stats: *mut trisap_stats,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        unsafe { border::check_versioned(stats)? };
        let known = call.world.stats();
        let told = trisap_stats {
            struct_size: size_of::<trisap_stats>() as u32,
            path: match known.path {
                Path::Unchanged => TRISAP_PATH_UNCHANGED,
                Path::Lists => TRISAP_PATH_LISTS,
                Path::Movers => TRISAP_PATH_MOVERS,
                Path::Full => TRISAP_PATH_FULL,
                Path::Rebuilt => TRISAP_PATH_REBUILT,
                // Movers by leaf; a new kind of step needs a line here.
                _ => TRISAP_PATH_MOVERS_BY_LEAF,
            },
            objects: known.objects,
            moved: known.moved,
            leaves: known.leaves,
            leaves_in_use: known.leaves_in_use,
            fullest_leaf: known.fullest_leaf,
            large: known.large,
            rebalanced: known.rebalanced,
            reason: match known.reason {
                Reason::NoMovers => TRISAP_REASON_NO_MOVERS,
                Reason::FewObjects => TRISAP_REASON_FEW_OBJECTS,
                Reason::FewMovers => TRISAP_REASON_FEW_MOVERS,
                Reason::ManyMovers => TRISAP_REASON_MANY_MOVERS,
                Reason::Fixed => TRISAP_REASON_FIXED,
                Reason::NothingKept => TRISAP_REASON_NOTHING_KEPT,
                Reason::NoRoom => TRISAP_REASON_NO_ROOM,
                Reason::Outgrown => TRISAP_REASON_OUTGROWN,
                Reason::OutOfBalance => TRISAP_REASON_OUT_OF_BALANCE,
                Reason::NoRoomForSurplus => TRISAP_REASON_NO_ROOM_FOR_SURPLUS,
                _ => TRISAP_REASON_OTHER,
            },
            fine_leaves: u32::from(known.fine_leaves),
            shared: u32::from(known.shared),
            outran: known.outran,
            copies: known.copies,
            candidates: known.candidates,
            tied: known.tied,
            pairs: known.pairs,
            found: known.found,
            lost: known.lost,
            surplus: known.surplus,
            spared: known.spared,
        };
        // SAFETY: checked above.
        unsafe { stats.write(told) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Checks all invariants of the world, to find out if something else writes to its memory. O(n log n + pairs). A library
/// that was built without the feature `validate`, as the modules for the web are, does not have this function.
///
/// Errors: `TRISAP_STATUS_CORRUPT`. An invariant is broken.
#[cfg(feature = "validate")]
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_validate(world: *const trisap_world) -> trisap_status {
    let ask = |call: &Call| call.world.validate().map_err(|_| trisap_status::Corrupt.into());
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}
