//! Worlds in the middle of their lives, which are saved and loaded, and what may happen to them.

use crate::checked::Outcome;
use crate::doing::On as _;
use crate::scenes::{self, Rng, shifted};
use crate::worlds::{Setup, Slab, ample};
use trisap_core::{Aabb, Boxes, Config, Error, Filter, Id, Index, Margin, Mode, World};

/// All that a snapshot can have, or nothing but what it must.
#[must_use]
pub fn configs() -> [Config; 4] {
    let plain = Config::new(ample(0, 0));
    let margin = plain.with_margin(Margin { per_extent: 0.05, min: 0.02, max: 1.0 });
    [
        plain,
        plain.with_events().with_filters(),
        margin.with_events(),
        margin.with_mode(Mode::Fat).with_events(),
    ]
}

/// A snapshot of a world.
///
/// # Panics
/// If it is not as long as was said.
#[must_use]
pub fn saved<I: Index>(world: &World<'_, I>) -> Vec<u8> {
    let mut bytes = vec![0; world.snapshot_size()];
    assert_eq!(world.save(&mut bytes), Ok(bytes.len()));
    bytes
}

/// Something happens to a world, and then a step: for the same random numbers the same.
///
/// # Errors
/// That of the step.
///
/// # Panics
/// If anything else is refused.
pub fn act<I: Index>(world: &mut World<'_, I>, rng: &mut Rng, setup: Setup) -> Result<Outcome, Error> {
    let slots = (0..world.config().capacity.objects).filter_map(|slot| world.id_at(slot));
    let ids: Vec<Id> = slots.collect();
    let aabb = |world: &World<'_, I>, id: Id| world.aabb(id).expect("alive");
    let some = |rng: &mut Rng| -> Vec<Id> {
        let share = [1, 5, ids.len() / 3][rng.below(3)];
        (0..share).filter(|_| !ids.is_empty()).map(|_| ids[rng.below(ids.len())]).collect()
    };
    for _ in 0..rng.below(3) {
        let mut chosen = some(rng);
        chosen.retain(|id| world.contains(*id));
        match rng.below(8) {
            0 => {
                let near: Vec<Aabb> = chosen.iter().map(|id| aabb(world, *id)).collect();
                // There may be no room for all of them.
                let _ = world.insert_many(Boxes::new(&near));
            }
            1 => {
                chosen.sort_unstable();
                chosen.dedup();
                world.remove_many(&chosen).expect("living objects");
            }
            2 => world.set_resting(&chosen).expect("living objects"),
            5 => world.set_enabled_many(&chosen, rng.once_in(2)).expect("living objects"),
            3 if world.config().filters => {
                for id in chosen {
                    let filter =
                        Filter { class: rng.below(3) as u32, ..Filter::groups(1 << rng.below(2), 3) };
                    world.set_filter(id, filter).expect("alive");
                }
            }
            4 if world.config().filters => {
                let mut meets = [u32::MAX; 32];
                meets[rng.below(3)] = 5;
                world.set_classes(&meets).expect("filters");
            }
            _ => {
                for id in chosen {
                    let next = shifted(&aabb(world, id), rng.point(-1.0, 1.0));
                    world.set_aabb(id, next).expect("alive");
                }
            }
        }
    }
    let step = if rng.once_in(4) {
        let last = ids.last().map_or(0, |id| id.slot() as usize + 1);
        let place = |slot: usize| world.id_at(slot as u32).map_or(Aabb::default(), |id| aabb(world, id));
        let mut boxes: Vec<Aabb> = (0..last).map(place).collect();
        scenes::walk(&mut boxes, [5, 1000][rng.below(2)], 0.5, rng);
        world.under(&setup).step_over(Boxes::new(&boxes))
    } else {
        world.under(&setup).step()
    };
    step.map(|step| Outcome::of(&step))
}

/// A world in the middle of its life, with something that has happened since the last step.
///
/// # Panics
/// If there is no room for the objects.
pub fn lived<'m, I: Index>(slab: &'m mut Slab, config: &Config, count: usize, calm: usize) -> World<'m, I> {
    let mut world = slab.world::<I>(config);
    let boxes: Vec<Aabb> =
        scenes::uniform(count, 2).iter().map(|b| scenes::at(b.min.map(|x| x * 0.6), [1.0; 3])).collect();
    let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
    let setup = Setup::REFERENCE;
    // Without room for all pairs it goes on all the same.
    let _ = world.under(&setup).step();
    for at in 0..calm {
        world.set_aabb(ids[at], boxes[at + 1]).expect("alive");
        let _ = world.under(&setup).step();
    }
    world.set_resting(&ids[..count / 3]).expect("alive");
    if calm % 2 == 1 {
        world.remove(ids[2]).expect("alive");
        world.remove(ids[count / 2]).expect("alive");
        world.insert(boxes[0]).expect("room");
        world.set_aabb(ids[0], boxes[3]).expect("alive");
    }
    world
}
