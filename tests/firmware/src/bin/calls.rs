//! Makes every call of the exact path, each as a function of its own, and prints the stack that it was seen to use.
//!
//! What is proved of this binary (no panic, no allocator, a bound for the stack) holds for these calls. Filters, queries,
//! snapshots, rest, views and shifts of the origin are not among them.

#![cfg_attr(target_os = "none", no_std, no_main)]

use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Id, InlineWorld, Margin, World, layout};
use trisap_firmware::{board, entry, print, recording};

const OBJECTS: usize = 64;
const CONFIG: Config =
    Config::new(Capacity::for_objects(OBJECTS as u32).with_pairs(4 * OBJECTS as u32).with_leaf_refs(32))
        .with_events()
        .with_margin(Margin::length(0.01));
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;

static mut MEMORY: InlineWorld<BYTES> = InlineWorld::EMPTY;

/// The calls. None is inlined, so that each is a root of the call graph.
mod api {
    use super::*;

    #[inline(never)]
    pub(super) fn init(memory: &mut InlineWorld<BYTES>) -> Result<(), Error> {
        memory.init::<u16>(&CONFIG).map(drop)
    }
    #[inline(never)]
    pub(super) fn open(memory: &mut InlineWorld<BYTES>) -> Result<World<'_, u16>, Error> {
        memory.world::<u16>()
    }
    #[inline(never)]
    pub(super) fn config(world: &World<'_, u16>) -> u32 {
        world.config().capacity.objects
    }
    #[inline(never)]
    pub(super) fn from_fixed(corners: &[[i32; 3]; 2], fraction_bits: u32) -> Aabb {
        Aabb::from_fixed(corners[0], corners[1], fraction_bits)
    }
    #[inline(never)]
    pub(super) fn insert(world: &mut World<'_, u16>, aabb: &Aabb) -> Result<Id, Error> {
        world.insert(*aabb)
    }
    #[inline(never)]
    pub(super) fn insert_many(
        world: &mut World<'_, u16>,
        boxes: &Boxes<'_>,
        ids: &mut [Option<Id>],
    ) -> Result<(), Error> {
        for (id, new) in ids.iter_mut().zip(world.insert_many(*boxes)?) {
            *id = Some(new);
        }
        Ok(())
    }
    #[inline(never)]
    pub(super) fn set_aabb(world: &mut World<'_, u16>, id: Id, aabb: &Aabb) -> Result<(), Error> {
        world.set_aabb(id, *aabb)
    }
    #[inline(never)]
    pub(super) fn set_margin(world: &mut World<'_, u16>, id: Id, length: f32) -> Result<(), Error> {
        world.set_margin(id, length)
    }
    #[inline(never)]
    pub(super) fn update_many(
        world: &mut World<'_, u16>,
        ids: &[Id],
        boxes: &Boxes<'_>,
    ) -> Result<(), Error> {
        world.update_many(ids, *boxes)
    }
    #[inline(never)]
    pub(super) fn remove(world: &mut World<'_, u16>, id: Id) -> Result<(), Error> {
        world.remove(id)
    }
    #[inline(never)]
    pub(super) fn remove_many(world: &mut World<'_, u16>, ids: &[Id]) -> Result<(), Error> {
        world.remove_many(ids)
    }
    #[inline(never)]
    pub(super) fn aabb(world: &World<'_, u16>, id: Id) -> Option<Aabb> {
        world.aabb(id)
    }
    #[inline(never)]
    pub(super) fn step(world: &mut World<'_, u16>) -> Result<u64, Error> {
        world.step().map(|step| step.surplus())
    }
    #[inline(never)]
    pub(super) fn step_over(world: &mut World<'_, u16>, boxes: &Boxes<'_>) -> Result<bool, Error> {
        world.step_over(*boxes).map(|step| step.rejected().is_none())
    }
    #[inline(never)]
    pub(super) fn results(world: &World<'_, u16>) -> usize {
        world.pairs().len() + world.found().len() + world.lost().len() + world.stats().candidates as usize
    }
    #[inline(never)]
    pub(super) fn validate(world: &World<'_, u16>) -> bool {
        world.validate().is_ok()
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

fn calls(memory: &mut InlineWorld<BYTES>) -> Option<()> {
    let first = recording::frame(0, OBJECTS)?;
    let (lone, half) = (first.get(0)?, recording::frame(0, OBJECTS / 2)?);
    let mut ids = [None; OBJECTS];

    seen("init", || api::init(memory).ok())?;
    seen("open", || api::open(memory).is_ok());
    let mut world = api::open(memory).ok()?;
    let id = seen("insert", || api::insert(&mut world, &lone).ok())?;
    seen("remove", || api::remove(&mut world, id).ok())?;
    seen("insert_many", || api::insert_many(&mut world, &first, &mut ids).ok())?;
    let id = ids[0]?;
    let known = [id; OBJECTS / 2];
    let mut step = 0;
    for index in 0..recording::FRAMES {
        let frame = recording::frame(index, OBJECTS)?;
        // The deepest of all frames is the one that counts.
        let mut good = false;
        let stack = board::stack(|| good = api::step_over(&mut world, &frame).is_ok()).unwrap_or_default();
        step = step.max(if good { stack } else { usize::MAX });
    }
    print::text("step_over", 16);
    print::number(step as u32, 6);
    board::print("\n");
    // Uses less stack than it takes to see how much.
    let fixed = api::from_fixed(&[[-1; 3], [1 << 16; 3]], 16);
    seen("set_aabb", || api::set_aabb(&mut world, id, &fixed).ok())?;
    seen("set_margin", || api::set_margin(&mut world, id, 0.5).ok())?;
    seen("update_many", || api::update_many(&mut world, &known, &half).ok())?;
    seen("step", || api::step(&mut world).ok())?;
    seen("results", || api::results(&world));
    seen("validate", || api::validate(&world).then_some(()))?;
    seen("config", || api::config(&world));
    seen("aabb", || api::aabb(&world, id).map(drop))?;
    seen("remove_many", || api::remove_many(&mut world, &known[..1]).ok())
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
