//! Answers many queries in one call, on the caller's workers.

use crate::among::{accepts, trisap_condition};
use crate::border::{self, Items};
use crate::call::{Call, look, trisap_world};
use crate::jobs::executor;
use crate::query::{trisap_cast, trisap_region};
use crate::status::{Refusal, trisap_status};
use crate::structs::{trisap_hit, trisap_id, trisap_jobs};
use core::ffi::{CStr, c_void};
use trisap_core::{Cast, Error, Hit, Region};

const NAME: &CStr = c"trisap queries";

/// Queries that are handed out at a time: a job for 16 workers. They are copied to the stack in the core's form, 20 KB
/// at most.
const BLOCK: usize = if cfg!(target_os = "none") { 32 } else { 512 };

/// `trisap_world_first_hit` of each of `count` casts, the next one `stride` bytes behind the one before; as many hits.
/// `jobs` may be null. The time is that of the single queries, divided by the workers.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_INVALID_ARGUMENT`. The second one is about a stride or a
/// `worker_count`. The hits, if anything was written to them, are null then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_first_hits(
    world: *const trisap_world,
    casts: *const trisap_cast,
    stride: usize,
    count: usize,
    condition: trisap_condition,
    user: *mut c_void,
    jobs: *const trisap_jobs,
    hits: *mut trisap_hit,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let casts = unsafe { Items::new(casts, stride, count, &call.range())? };
        let mut block = [Cast::ray([0.0; 3], [0.0; 3], 0.0); BLOCK];
        let world = &call.world;
        let among = world.among(accepts(condition, user));
        // SAFETY: the caller's promise.
        let (executor, hits) =
            unsafe { (executor(jobs, NAME)?, border::Hits::new(hits, count, &call.range())?) };
        into_hits(hits, 1, &casts, &mut block, Cast::from, |casts, out| {
            among.first_hits(casts, &executor, out)
        })
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// `trisap_world_nearest` of each of `count` points of three numbers, the next one `stride` bytes behind the one before. `hits` has
/// room for `room` hits for each: those of point `i` begin at `hits[i * room]`, and end with a null id where there are fewer. `jobs`
/// may be null. The time is that of the single queries, divided by the workers.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_INVALID_ARGUMENT`. The hits, if anything was written to them, are null then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_nearest_many(
    world: *const trisap_world,
    points: *const f32,
    stride: usize,
    count: usize,
    condition: trisap_condition,
    user: *mut c_void,
    jobs: *const trisap_jobs,
    hits: *mut trisap_hit,
    room: usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let points = unsafe { Items::new(points.cast::<[f32; 3]>(), stride, count, &call.range())? };
        let all = count.checked_mul(room).ok_or(trisap_status::InvalidArgument)?;
        let world = &call.world;
        let among = world.among(accepts(condition, user));
        // SAFETY: the caller's promise.
        let (executor, hits) =
            unsafe { (executor(jobs, NAME)?, border::Hits::new(hits, all, &call.range())?) };
        into_hits(
            hits,
            room,
            &points,
            &mut [[0.0; 3]; BLOCK],
            |point| point,
            |points, out| among.nearest_many(points, &executor, out),
        )
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// `trisap_world_overlaps` of each of `count` regions, the next one `stride` bytes behind the one before. `ids` has
/// room for `room` ids in all: first come those of the first region, then those of the second one, and so on.
/// `ends[i]` tells where the ids of region `i` end and those of the next region begin. `jobs` may be null. The time is
/// that of the single queries, divided by the workers; twice that if the objects of 32 regions take more than their
/// share of the room.
///
/// Errors: `TRISAP_STATUS_BAD_QUERY`, `TRISAP_STATUS_OUTPUT_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. After the second
/// one the ends are right, some of the ids are there, and the detail says how much room all of them need. After the
/// other two the ids are null and the ends zero, if anything was written to them.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_overlaps_many(
    world: *const trisap_world,
    regions: *const trisap_region,
    stride: usize,
    count: usize,
    condition: trisap_condition,
    user: *mut c_void,
    jobs: *const trisap_jobs,
    ids: *mut trisap_id,
    room: usize,
    ends: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        let range = call.range();
        // SAFETY: the caller's promise.
        let regions = unsafe { Items::new(regions, stride, count, &range)? };
        // SAFETY: the caller's promise.
        let executor = unsafe { executor(jobs, NAME)? };
        // Where nothing is asked, nothing is written.
        let room = if count == 0 { 0 } else { room };
        if count > 0 {
            border::span(ends, count, &range)?;
        }
        // SAFETY: the caller's promise.
        let (ids, ends) =
            unsafe { (border::new_ids(ids, room, &range)?, border::zeros(ends, count, &range)?) };
        let world = &call.world;
        let among = world.among(accepts(condition, user));
        let mut block = [Region::Point([0.0; 3]); BLOCK];
        let mut total = 0usize;
        let outcome = in_blocks(&regions, &mut block, trisap_region::to_core, |start, regions| {
            let ids = ids.get_mut(total..).unwrap_or_default();
            let ends = ends.get_mut(start..start + regions.len()).unwrap_or_default();
            match among.overlaps_many(regions, &executor, ids, ends) {
                // How many the other blocks have is told, too.
                Ok(_) | Err(Error::OutputFull { .. }) => {}
                Err(error) => return Err(error),
            }
            ends.iter_mut().for_each(|end| *end = end.saturating_add(total));
            total = ends.last().copied().unwrap_or(total);
            Ok(())
        });
        if outcome.is_err() {
            total = 0;
            ends.fill(0);
        }
        // Once for all blocks.
        ids.get_mut(total..).unwrap_or_default().fill(None);
        outcome?;
        if total > room {
            return Err(Error::OutputFull { needed: total as u64, room }.into());
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Answers queries with so many hits each; without any where one of them is refused.
fn into_hits<C: Copy, Q>(
    mut hits: border::Hits,
    room: usize,
    queries: &Items<C>,
    block: &mut [Q; BLOCK],
    convert: impl Fn(C) -> Q,
    ask: impl Fn(&[Q], &mut [Option<Hit>]) -> Result<(), Error>,
) -> Result<(), Refusal> {
    let out = hits.as_options();
    let outcome = in_blocks(
        queries,
        block,
        |query| Some(convert(query)),
        |start, queries| {
            ask(queries, out.get_mut(start * room..(start + queries.len()) * room).unwrap_or_default())
        },
    );
    if outcome.is_err() {
        out.fill(None);
    }
    hits.settle();
    outcome
}

/// Passes queries on in blocks, with the position of the first one of each block.
fn in_blocks<C: Copy, Q>(
    queries: &Items<C>,
    block: &mut [Q; BLOCK],
    convert: impl Fn(C) -> Option<Q>,
    mut answer: impl FnMut(usize, &[Q]) -> Result<(), Error>,
) -> Result<(), Refusal> {
    let position = |start: usize, index: usize| Error::BadQuery { index: (start + index) as u32 };
    for start in (0..queries.len()).step_by(BLOCK) {
        let mut filled = 0;
        for (index, query) in block.iter_mut().enumerate() {
            let Some(given) = queries.get(start + index) else { break };
            *query = convert(given).ok_or(position(start, index))?;
            filled += 1;
        }
        answer(start, block.get(..filled).unwrap_or_default()).map_err(|error| match error {
            Error::BadQuery { index } => position(start, index as usize),
            error => error,
        })?;
    }
    Ok(())
}
