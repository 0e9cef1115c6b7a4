//! Values of objects: they follow the objects through steps, moves, snapshots and copies, and events tell those of the objects that
//! were the pair.

use std::collections::HashMap;
use trisap_core::{Capacity, Config, Error, Id, Index, Margin, World, layout};
use trisap_tests::effort;
use trisap_tests::lives::saved;
use trisap_tests::scenes::{self, Rng, shifted};
use trisap_tests::worlds::{Slab, ample};

/// What lives have come to, so that a test can see that they were no idle ones.
#[derive(Debug, Default)]
struct Tally {
    found: usize,
    lost: usize,
    /// Lost pairs of which a slot has gone to another object.
    lost_by_reuse: usize,
    grown: usize,
    loaded: usize,
    copied: usize,
}

/// A world and the values of all objects that there have ever been.
struct Life<I: Index> {
    config: Config,
    slab: Slab,
    values: HashMap<Id, u64>,
    living: Vec<Id>,
    index: std::marker::PhantomData<I>,
}

impl<I: Index> Life<I> {
    fn new(config: Config) -> Self {
        let mut slab = Slab::new::<I>(&config);
        slab.world::<I>(&config);
        let (values, living) = (HashMap::new(), Vec::new());
        Self { config, slab, values, living, index: std::marker::PhantomData }
    }

    fn world(&mut self) -> World<'_, I> {
        World::open(self.slab.bytes_mut()).expect("the world")
    }

    fn act(&mut self, rng: &mut Rng, tally: &mut Tally) {
        match rng.below(12) {
            0..5 => {
                let aabb = scenes::at(rng.point(-2.5, 2.5), [1.0; 3]);
                if self.living.len() as u32 == self.config.capacity.objects {
                    let objects = self.config.capacity.objects * 2;
                    self.go_to(ample(objects as usize, 40 * objects as usize), rng, tally);
                }
                let id = self.world().insert(aabb).expect("room");
                assert_eq!(self.world().value(id), Some(0), "of a new object");
                self.values.insert(id, 0);
                self.living.push(id);
                // Some keep the value of new ones.
                if !rng.once_in(5) {
                    self.set(id, u64::from(rng.below(1 << 30) as u32) << 34 | self.values.len() as u64);
                }
            }
            5..8 if !self.living.is_empty() => {
                let id = self.living.swap_remove(rng.below(self.living.len()));
                self.world().remove(id).expect("alive");
                assert_eq!(self.world().value(id), None);
                assert_eq!(self.world().set_value(id, 1), Err(Error::StaleId { id }));
            }
            8 if !self.living.is_empty() => {
                let id = self.living[rng.below(self.living.len())];
                self.set(id, u64::MAX - self.values.len() as u64);
            }
            9 | 10 if !self.living.is_empty() => {
                let id = self.living[rng.below(self.living.len())];
                let aabb = self.world().aabb(id).expect("alive");
                self.world().set_aabb(id, shifted(&aabb, rng.point(-1.0, 1.0))).expect("alive");
            }
            _ => self.go_to(self.config.capacity, rng, tally),
        }
    }

    fn set(&mut self, id: Id, value: u64) {
        self.world().set_value(id, value).expect("alive");
        self.values.insert(id, value);
    }

    /// Into other memory, in one of four ways.
    fn go_to(&mut self, capacity: Capacity, rng: &mut Rng, tally: &mut Tally) {
        let config = self.config.with_capacity(capacity);
        let mut slab = Slab::new::<I>(&config);
        slab.bytes_mut().fill(0x77);
        let same = config == self.config;
        match rng.below(3) {
            0 if same => {
                slab = self.slab.clone();
                tally.copied += 1;
            }
            1 => {
                let snapshot = saved(&self.world());
                slab.world::<I>(&config).load(&snapshot).expect("room");
                tally.loaded += 1;
            }
            _ => drop(self.world().move_into(slab.bytes_mut(), &config).expect("room")),
        }
        tally.grown += usize::from(!same);
        (self.config, self.slab) = (config, slab);
    }

    fn step(&mut self, tally: &mut Tally) {
        let values = std::mem::take(&mut self.values);
        let of = |[a, b]: [Id; 2]| [values[&a], values[&b]];
        let world = &mut self.world();
        let step = world.step().expect("room");
        let lost: Vec<_> = step.lost_ids().collect();
        assert_eq!(lost.len(), step.lost().len());
        assert!(step.pair_values().eq(step.pair_ids().map(of)), "pairs");
        assert!(step.found_values().eq(step.found_ids().map(of)), "found");
        assert!(step.lost_values().eq(lost.iter().copied().map(of)), "lost");
        assert_eq!(step.pair_values().count(), step.pairs().len());
        let reused = |id: &Id| step.world().id_at(id.slot()).is_some_and(|now| now != *id);
        tally.found += step.found().len();
        tally.lost += lost.len();
        tally.lost_by_reuse += lost.iter().filter(|[a, b]| reused(a) || reused(b)).count();
        for (id, value) in &values {
            assert_eq!(world.value(*id), world.contains(*id).then_some(*value));
        }
        world.validate().expect("a valid world");
        self.values = values;
    }
}

fn live<I: Index>(config: Config, seed: u64, tally: &mut Tally) {
    let rng = &mut Rng::new(seed);
    let objects = [3, 60, 600][seed as usize % 3];
    let mut life = Life::<I>::new(config.with_capacity(ample(objects, 40 * objects)));
    // In a tree, or on the way to one.
    for _ in 0..if objects > 60 { 590 } else { 0 } {
        let id = life.world().insert(scenes::at(rng.point(-6.0, 6.0), [1.0; 3])).expect("room");
        life.values.insert(id, 0);
        life.living.push(id);
        life.set(id, id.to_bits());
    }
    for _ in 0..30 {
        for _ in 0..rng.below(9) {
            life.act(rng, tally);
        }
        life.step(tally);
    }
}

#[test]
fn values_are_those_of_the_objects_that_were_the_pair() {
    let base = Config::new(ample(0, 0)).with_events().with_values();
    let mut tally = Tally::default();
    for seed in 0..120 * u64::from(effort()) {
        let config = match seed % 4 {
            0 => base.with_margin(Margin::length(0.2)),
            1 => base.with_filters(),
            _ => base,
        };
        if seed % 2 == 0 {
            live::<u16>(config, seed, &mut tally)
        } else {
            live::<u32>(config, seed, &mut tally)
        }
    }
    println!("{tally:?}");
    let Tally { found, lost, lost_by_reuse, grown, loaded, copied } = tally;
    assert!(found > 10_000 && lost > 4000 && lost_by_reuse > 1000);
    assert!(grown > 100 && loaded > 100 && copied > 50);
}

#[test]
fn values_take_room_only_where_there_are_some() {
    for objects in [1, 64, 500, 5000] {
        let plain = Config::new(ample(objects, objects));
        for (config, each) in [(plain, 8), (plain.with_events(), 16)] {
            let [without, with] =
                [config, config.with_values()].map(|config| layout::<u32>(&config).expect("small").bytes);
            // Up to a cache line more for each of at most two sections.
            assert!((with - without).abs_diff(each * objects) < 2 * 64, "{objects}");
        }
    }
}

#[test]
fn a_world_without_values_says_so() {
    let config = Config::new(ample(3, 3)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    let ids = [(); 2].map(|()| world.insert(scenes::cube(0.0, 0.0, 0.0)).expect("room"));
    assert_eq!(world.set_value(ids[0], 5), Err(Error::NoValues));
    assert_eq!(world.value(ids[0]), None);
    let step = world.step().expect("room");
    assert_eq!((step.pairs().len(), step.pair_values().count(), step.found_values().count()), (1, 0, 0));
    world.remove(ids[1]).expect("alive");
    let step = world.step().expect("room");
    assert_eq!((step.lost().len(), step.lost_values().count()), (1, 0));
    assert_eq!(Error::NoValues.to_string(), "the world was made without values");
}

/// A slot that went to another object after the step has no pair of that object, with and without events.
#[test]
fn newcomers_have_no_pairs_of_the_last_step() {
    for config in [Config::new(ample(3, 3)), Config::new(ample(3, 3)).with_events()] {
        let mut slab = Slab::new::<u32>(&config.with_values());
        let mut world = slab.world::<u32>(&config.with_values());
        let [a, b] = [1, 2].map(|value| {
            let id = world.insert(scenes::cube(0.0, 0.0, 0.0)).expect("room");
            world.set_value(id, value).expect("values");
            id
        });
        world.step().expect("room");
        assert!(world.pair_ids().eq([[a, b]]) && world.pair_values().eq([[1, 2]]));
        world.remove(b).expect("alive");
        let newcomer = world.insert(scenes::cube(9.0, 0.0, 0.0)).expect("room");
        assert_eq!(newcomer.slot(), b.slot());
        let saved = saved(&world);
        for _ in 0..2 {
            assert_eq!((world.pair_ids().count(), world.pair_values().count()), (0, 0));
            world.load(&saved).expect("a snapshot");
        }
        world.set_aabb(newcomer, scenes::cube(0.0, 0.0, 0.0)).expect("alive");
        world.step().expect("room");
        assert!(world.pair_ids().eq([[a, newcomer]]));
    }
}
