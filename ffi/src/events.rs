//! Names pairs by ids, which stay right when slots go to other objects.

use crate::border;
use crate::call::{Call, look, trisap_world};
use crate::status::{Refusal, trisap_status};
use crate::structs::trisap_id;
use trisap_core::{Error, Id};

/// All pairs of the last step: for `trisap_world_pair_ids`.
pub const TRISAP_PAIRS_ALL: u32 = 0;
/// With events, pairs of the last step that the complete step before it did not have: for the same.
pub const TRISAP_PAIRS_FOUND: u32 = 1;
/// With events, pairs of the complete step before the last one that the last one does not have: for the same.
pub const TRISAP_PAIRS_LOST: u32 = 2;

/// Two objects by id.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct trisap_id_pair {
    /// The object in the lower slot.
    pub a: trisap_id,
    /// The object in the higher slot.
    pub b: trisap_id,
}

/// Writes pairs of the last step by id to `pairs`, which has room for `room`, and how many there are to `count`; `what`
/// is one of `TRISAP_PAIRS_...`. O(pairs).
///
/// Ask after a step, before objects come or go. Then the pairs are in the order of `trisap_result`. Lost pairs have
/// the ids of the objects that were the pair, also if they are gone and others have their slots. Other pairs of
/// objects that were removed since the step are left out.
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. After the first one the number is right, and
/// the room holds as many as fit.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_pair_ids(
    world: *const trisap_world,
    what: u32,
    pairs: *mut trisap_id_pair,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        let range = call.range();
        border::span(count, 1, &range)?;
        if room > 0 {
            border::span(pairs, room, &range)?;
        }
        let world = &call.world;
        let mut written = 0;
        let mut put = |[a, b]: [Id; 2]| {
            if written < room {
                let pair = trisap_id_pair { a: a.to_bits(), b: b.to_bits() };
                // SAFETY: within the caller's room, aligned, and outside of the world.
                unsafe { pairs.add(written).write(pair) };
            }
            written += 1;
        };
        match what {
            TRISAP_PAIRS_ALL => world.pair_ids().for_each(&mut put),
            TRISAP_PAIRS_FOUND => world.found_ids().for_each(&mut put),
            TRISAP_PAIRS_LOST => world.lost_ids().for_each(&mut put),
            _ => return Err(Refusal::from(trisap_status::InvalidArgument)),
        }
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { count.write(written) };
        if written > room { Err(Error::OutputFull { needed: written as u64, room }.into()) } else { Ok(()) }
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}
