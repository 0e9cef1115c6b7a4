//! Makes the calls around the exact path, each as a function of its own, and prints the stack that it was seen to use:
//! queries, snapshots, rest, shifts of the origin, views of the tree, and, with the feature `large`, filters.
//!
//! What is proved of this binary (no panic, no allocator, a bound for the stack) holds for these calls. The exact path has
//! its own program, `calls`, so that its size is known.

#![cfg_attr(target_os = "none", no_std, no_main)]

use trisap_core::{
    Boxes, Capacity, Cast, Config, Error, Filter, Hit, Id, InlineWorld, Region, World, layout,
};
use trisap_firmware::{board, entry, print, recording};

const OBJECTS: usize = 32;
const CONFIG: Config = {
    let capacity = Capacity::for_objects(OBJECTS as u32).with_pairs(4 * OBJECTS as u32).with_leaf_refs(16);
    let config = Config::new(capacity).with_events();
    // There are no filters without the feature.
    if cfg!(feature = "large") { config.with_filters() } else { config }
};
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;

/// The world, and what the calls write to.
struct Memory {
    world: InlineWorld<BYTES>,
    snapshot: [u8; BYTES],
    ids: [Option<Id>; OBJECTS],
    hits: [Option<Hit>; OBJECTS],
}

static mut MEMORY: Memory =
    Memory { world: InlineWorld::EMPTY, snapshot: [0; BYTES], ids: [None; OBJECTS], hits: [None; OBJECTS] };

/// The calls. None is inlined, so that each is a root of the call graph.
mod api {
    use super::*;
    use trisap_core::Serial;

    #[inline(never)]
    pub(super) fn shift_origin(world: &mut World<'_, u16>, by: &[f64; 3]) -> Result<u32, Error> {
        world.shift_origin(*by)
    }
    #[inline(never)]
    pub(super) fn set_resting(world: &mut World<'_, u16>, ids: &[Id]) -> Result<(), Error> {
        world.set_resting(ids)
    }
    #[inline(never)]
    pub(super) fn wake(world: &mut World<'_, u16>, ids: &[Id]) -> Result<(), Error> {
        world.wake(ids)
    }
    #[inline(never)]
    pub(super) fn is_resting(world: &World<'_, u16>, id: Id) -> bool {
        world.is_resting(id)
    }
    #[inline(never)]
    pub(super) fn overlaps(
        world: &World<'_, u16>,
        region: &Region,
        out: &mut [Option<Id>],
    ) -> Result<usize, Error> {
        world.overlaps(region, out)
    }
    #[inline(never)]
    pub(super) fn overlaps_many(
        world: &World<'_, u16>,
        regions: &[Region; 2],
        out: &mut [Option<Id>; OBJECTS],
        ends: &mut [usize; 2],
    ) -> Result<usize, Error> {
        // Arrays, since more than four words of arguments would be on the caller's stack.
        world.among(|_| true).overlaps_many(regions, &Serial, out, ends)
    }
    #[inline(never)]
    pub(super) fn first_hit(world: &World<'_, u16>, cast: &Cast) -> Result<Option<Hit>, Error> {
        world.first_hit(cast)
    }
    #[inline(never)]
    pub(super) fn first_hits(
        world: &World<'_, u16>,
        casts: &[Cast],
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        world.among(|_| true).first_hits(casts, &Serial, out)
    }
    #[inline(never)]
    pub(super) fn hits(world: &World<'_, u16>, cast: &Cast, out: &mut [Option<Hit>]) -> Result<usize, Error> {
        world.hits(cast, out)
    }
    #[inline(never)]
    pub(super) fn nearest(
        world: &World<'_, u16>,
        point: &[f32; 3],
        out: &mut [Option<Hit>],
    ) -> Result<usize, Error> {
        // All but the first object, so that there is a condition to call.
        world.among(|id| id.slot() != 0).nearest(*point, out)
    }
    #[inline(never)]
    pub(super) fn save(world: &World<'_, u16>, out: &mut [u8]) -> Result<usize, Error> {
        world.save(out)
    }
    #[inline(never)]
    pub(super) fn load(world: &mut World<'_, u16>, snapshot: &[u8]) -> Result<(), Error> {
        world.load(snapshot)
    }
    #[inline(never)]
    pub(super) fn views(world: &World<'_, u16>) -> usize {
        world.leaves().count()
            + world.planes().map(|plane| plane.depth as usize).sum::<usize>()
            + world.large().count()
    }
    #[inline(never)]
    pub(super) fn set_filter(world: &mut World<'_, u16>, id: Id, filter: &Filter) -> Result<(), Error> {
        world.set_filter(id, *filter)
    }
    #[inline(never)]
    pub(super) fn filter(world: &World<'_, u16>, id: Id) -> Option<Filter> {
        world.filter(id)
    }
    #[inline(never)]
    pub(super) fn set_classes(world: &mut World<'_, u16>, meets: &[u32; 32]) -> Result<(), Error> {
        world.set_classes(meets)
    }
    #[inline(never)]
    pub(super) fn refilter(world: &mut World<'_, u16>, id: Id) -> Result<(), Error> {
        world.refilter(id)
    }
    #[inline(never)]
    pub(super) fn step_with_rule(world: &mut World<'_, u16>, boxes: &Boxes<'_>) -> Result<usize, Error> {
        let rule = |a: u32, b: u32| a + b != 1;
        world.with_rule(&rule).step_over(*boxes).map(|step| step.pairs().len())
    }
    #[inline(never)]
    pub(super) fn step_filtered(world: &mut World<'_, u16>, boxes: &Boxes<'_>) -> Result<usize, Error> {
        world.step_over(*boxes).map(|step| step.pairs().len())
    }
}

/// Prints a row and gives back what the call came to.
fn seen<T: Default>(name: &str, call: impl FnOnce() -> T) -> T {
    let mut result = T::default();
    let stack = board::stack(|| result = call());
    print::text(name, 16);
    print::number(stack.unwrap_or_default() as u32, 6);
    board::print("\n");
    result
}

fn calls(memory: &mut Memory) -> Option<()> {
    let Memory { world, snapshot, ids, hits } = memory;
    let first = recording::frame(0, OBJECTS)?;
    let lone = first.get(0)?;
    let (region, cast) = (Region::Aabb(lone), Cast::ray(lone.min, [1.0, 0.5, 0.25], f32::INFINITY));
    let regions = [region, Region::Sphere { center: lone.max, radius: 1.0 }];
    let mut ends = [0; 2];

    let mut world = world.init::<u16>(&CONFIG).ok()?;
    let id = world.insert_many(first).ok()?.next()?;
    seen("step_filtered", || api::step_filtered(&mut world, &first).ok())?;
    seen("set_resting", || api::set_resting(&mut world, &[id]).ok())?;
    seen("is_resting", || api::is_resting(&world, id).then_some(()))?;
    seen("wake", || api::wake(&mut world, &[id]).ok())?;
    seen("overlaps", || api::overlaps(&world, &region, ids).ok())?;
    seen("overlaps_many", || api::overlaps_many(&world, &regions, ids, &mut ends).ok())?;
    seen("first_hit", || api::first_hit(&world, &cast).ok().flatten().map(drop))?;
    seen("first_hits", || api::first_hits(&world, &[cast, cast], hits).ok())?;
    seen("hits", || api::hits(&world, &cast, hits).ok())?;
    seen("nearest", || api::nearest(&world, &lone.min, hits).ok())?;
    let length = seen("save", || api::save(&world, snapshot).ok())?;
    seen("shift_origin", || api::shift_origin(&mut world, &[1.0, 0.1, -3.0]).ok())?;
    seen("load", || api::load(&mut world, snapshot.get(..length)?).ok())?;
    seen("views", || api::views(&world));
    if !CONFIG.filters {
        return Some(());
    }
    seen("set_filter", || api::set_filter(&mut world, id, &Filter::class(1)).ok())?;
    seen("filter", || api::filter(&world, id).map(drop))?;
    seen("set_classes", || api::set_classes(&mut world, &[u32::MAX; 32]).ok())?;
    seen("refilter", || api::refilter(&mut world, id).ok())?;
    seen("step_with_rule", || api::step_with_rule(&mut world, &first).ok()).map(drop)
}

fn run() -> u8 {
    let memory = &raw mut MEMORY;
    // SAFETY: `run` is called once, and nothing else names the static.
    let memory = unsafe { &mut *memory };
    if calls(memory).is_some() {
        return 0;
    }
    board::print("a call was refused\n");
    2
}

entry!(run);
