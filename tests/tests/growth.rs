//! Worlds that move into other configurations at random moments: the pairs, events and ids are those of a world that was large from
//! the beginning, and of the model.

use trisap_core::{
    Aabb, Boxes, Capacity, Config, Error, Field, Filter, Id, Index, Kernels, Margin, Mode, World,
};
use trisap_tests::checked::{Checked, Outcome};
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::lives::{configs, lived, saved};
use trisap_tests::model::Model;
use trisap_tests::scenes::{self, Rng, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{effort, sorted};

/// What a life has come to, so that a test can see that it was no idle one.
#[derive(Debug, Default)]
struct Tally {
    steps: usize,
    grown_for_objects: usize,
    grown_for_pairs: usize,
    moved: usize,
    moved_into_less: usize,
    loaded: usize,
    trees: usize,
    events: usize,
}

/// A world that begins small, its model, and a world of ample size.
struct Life<'r> {
    config: Config,
    slab: Slab,
    model: Model,
    large: Slab,
    rng: &'r mut Rng,
    tally: &'r mut Tally,
}

impl Life<'_> {
    /// The world moves, half of the time by a snapshot.
    fn go_to<I: Index>(&mut self, capacity: Capacity) -> Result<(), Error> {
        let choice = |rng: &mut Rng| [Choice::Automatic, Choice::Never, Choice::Always][rng.below(3)];
        let mut config = self.config.with_capacity(capacity);
        config.lean = capacity.objects <= 256 && self.rng.once_in(4);
        let config = config.with_movers_only(choice(self.rng)).with_workers(1 + self.rng.below(3) as u32);
        let mut slab = Slab::new::<I>(&config);
        let from = World::<I>::open(self.slab.bytes_mut()).expect("the world");
        let (was, objects) = (from.config().capacity, from.len());
        let result = (from.pairs().to_vec(), from.found().to_vec(), from.lost().to_vec());
        let before = saved(&from);
        let loads = self.rng.once_in(2);
        let to = if loads {
            let mut to = slab.world::<I>(&config);
            let unmoved = saved(&to);
            let moved = to.load(&before);
            assert!(moved.is_ok() || saved(&to) == unmoved, "refused, and changed");
            moved.map(|()| to)
        } else {
            slab.bytes_mut().fill(77);
            from.move_into(slab.bytes_mut(), &config)
        };
        assert!(saved(&from) == before, "the old world is as it was");
        let to = to?;
        self.tally.loaded += usize::from(loads);
        to.validate().expect("a valid world");
        assert_eq!((to.config(), to.len()), (config, objects));
        assert_eq!((to.pairs().to_vec(), to.found().to_vec(), to.lost().to_vec()), result);
        assert!(to.lost_ids().eq(from.lost_ids()), "also of objects that are no more");
        let is_less = config.capacity.objects < was.objects || config.capacity.pairs < was.pairs;
        self.tally.moved_into_less += usize::from(is_less);
        self.tally.moved += 1;
        (self.config, self.slab) = (config, slab);
        Ok(())
    }

    fn grow<I: Index>(&mut self, objects: u32, pairs: u64) {
        let Capacity { objects: old, leaf_refs, pairs: few, .. } = self.config.capacity;
        let capacity = Capacity::for_objects(objects.max(old))
            .with_leaf_refs(leaf_refs)
            .with_pairs((pairs as u32).max(few));
        self.go_to::<I>(capacity).expect("everything fits into more");
    }

    fn checked<I: Index>(&mut self) -> Checked<'_, I> {
        let world = World::open(self.slab.bytes_mut()).expect("the world");
        Checked::resume(world, std::mem::take(&mut self.model))
    }

    /// The same call of both worlds, which must agree.
    fn both<I: Index, T: PartialEq + std::fmt::Debug>(
        &mut self,
        call: impl Fn(&mut World<'_, I>) -> T,
        follow: impl FnOnce(&mut Model, &World<'_, I>, &T),
    ) {
        let mut large = World::<I>::open(self.large.bytes_mut()).expect("the large world");
        let said = call(&mut large);
        let mut world = World::<I>::open(self.slab.bytes_mut()).expect("the world");
        assert_eq!(call(&mut world), said, "the world that was large from the beginning");
        follow(&mut self.model, &world, &said);
    }

    fn insert<I: Index>(&mut self, aabb: Aabb) {
        let mut world = World::<I>::open(self.slab.bytes_mut()).expect("the world");
        if u64::from(world.len()) == u64::from(self.config.capacity.objects) {
            let needed = world.len() + 1;
            let full = Error::ObjectsFull { needed: u64::from(needed), room: needed - 1 };
            assert_eq!(world.insert(aabb), Err(full));
            self.tally.grown_for_objects += 1;
            let more = needed + self.rng.below(needed as usize) as u32;
            self.grow::<I>(more, 0);
        }
        self.both::<I, _>(|world| world.insert(aabb).expect("room"), |model, _, id| model.insert(*id, aabb));
    }

    fn any(&mut self) -> Option<Id> {
        let ids = self.model.ids();
        (!ids.is_empty()).then(|| ids[self.rng.below(ids.len())])
    }

    fn act<I: Index>(&mut self) {
        let filters = self.config.filters;
        let Some(id) = self.any() else { return self.insert::<I>(scenes::cube(0.0, 0.0, 0.0)) };
        let aabb = self.model.boxes()[id.slot() as usize].expect("alive");
        match self.rng.below(20) {
            0..5 => self.insert::<I>(shifted(&aabb, self.rng.clone().point(-2.0, 2.0))),
            5..7 => self.both::<I, _>(|world| world.remove(id), |model, _, _| model.remove(id)),
            7..12 => {
                let length = [0.1, 3.0][self.rng.below(2)];
                let next = shifted(&aabb, self.rng.point(-length, length));
                self.both::<I, _>(|world| world.set_aabb(id, next), |model, _, _| model.set(id, next));
            }
            12 if filters => {
                let filter =
                    Filter { class: self.rng.below(3) as u32, ..Filter::groups(1 << self.rng.below(2), 3) };
                self.both::<I, _>(
                    |world| world.set_filter(id, filter),
                    |model, _, _| model.set_filter(id, filter),
                );
            }
            13 if filters => {
                let mut meets = [u32::MAX; 32];
                meets[self.rng.below(3)] = 5;
                self.both::<I, _>(|world| world.set_classes(&meets), |model, _, _| model.set_classes(&meets));
            }
            14 => {
                let length = self.rng.between(0.0, 0.5);
                self.both::<I, _>(|world| world.set_margin(id, length), |_, _, _| ());
            }
            15 | 16 => {
                let rests = self.rng.once_in(2);
                let call = |world: &mut World<'_, I>| {
                    if rests { world.set_resting(&[id]) } else { world.wake(&[id]) }
                };
                self.both::<I, _>(call, |model, _, _| model.set_resting(id, rests));
            }
            17 => {
                let by = [f64::from(self.rng.below(9) as u32) - 4.0, 0.25, 0.0];
                let ids = self.model.ids();
                self.both::<I, _>(
                    |world| world.shift_origin(by),
                    |model, world, _| {
                        ids.iter().for_each(|id| model.shift(*id, world.aabb(*id).expect("alive")))
                    },
                );
            }
            _ => self.move_anywhere::<I>(),
        }
    }

    /// To a random capacity, which may be too small.
    fn move_anywhere<I: Index>(&mut self) {
        let world = World::<I>::open(self.slab.bytes_mut()).expect("the world");
        let slots = (0..self.config.capacity.objects).rev().find(|slot| self.model.id_at(*slot).is_some());
        let slots = slots.map_or(0, |slot| slot + 1);
        let pairs = world.pairs().len();
        let capacity = Capacity::for_objects(slots / 2 + self.rng.below(slots as usize + 9) as u32)
            .with_leaf_refs([0, slots / 2, 8 * slots][self.rng.below(3)])
            .with_pairs((pairs / 2 + self.rng.below(2 * pairs + 9)) as u32);
        match self.go_to::<I>(capacity) {
            Ok(()) => assert!(capacity.objects >= slots && capacity.pairs as usize >= pairs),
            Err(Error::NoRoom { field: Field::Objects, needed, room }) => {
                assert_eq!(room, capacity.objects);
                assert!(needed > room && needed >= slots);
            }
            Err(Error::NoRoom { field: Field::Pairs, needed, room }) => {
                assert_eq!(room, capacity.pairs);
                assert!(needed > room && needed as usize >= pairs);
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// A step, again with more room where there was too little, and what the other world says.
    fn step<I: Index>(&mut self) {
        let mut boxes = self.rng.once_in(3).then(|| {
            let place = |aabb: &Option<Aabb>| aabb.unwrap_or(Aabb::new([f32::NAN; 3], [f32::NAN; 3]));
            self.model.boxes().iter().map(place).collect::<Vec<_>>()
        });
        if let Some(boxes) = &mut boxes {
            let movers = [2, boxes.len()][self.rng.below(2)];
            for _ in 0..movers.min(boxes.len()) {
                let slot = self.rng.below(boxes.len());
                boxes[slot] = shifted(&boxes[slot], self.rng.point(-1.0, 1.0));
            }
        }
        let mut large = World::<I>::open(self.large.bytes_mut()).expect("the large world");
        let expected = match &boxes {
            Some(boxes) => large.step_over(Boxes::new(boxes)),
            None => large.step(),
        };
        let expected = Outcome::of(&expected.expect("ample room"));
        let said = loop {
            let mut checked = self.checked::<I>();
            let said = match boxes.take() {
                Some(boxes) => checked.try_step_over(&boxes, Setup::REFERENCE),
                None => checked.try_step(Setup::REFERENCE),
            };
            self.model = checked.into_model();
            match said {
                Ok(said) => break said,
                Err(Error::PairsFull { needed, .. }) => {
                    self.tally.grown_for_pairs += 1;
                    // Sometimes still not enough.
                    let room = u64::from(self.config.capacity.pairs);
                    let less = room + 1 + (needed - room) / 2;
                    let more = if self.rng.once_in(3) { less } else { needed + self.rng.below(9) as u64 };
                    self.grow::<I>(0, more);
                }
                Err(error) => panic!("{error}"),
            }
        };
        assert_eq!(sorted(&said.pairs), sorted(&expected.pairs));
        assert_eq!(sorted(&said.found), sorted(&expected.found), "found");
        assert_eq!(sorted(&said.lost), sorted(&expected.lost), "lost");
        self.tally.steps += 1;
        self.tally.trees += usize::from(said.stats.leaves > 1);
        self.tally.events += said.found.len() + said.lost.len();
    }
}

fn live<I: Index>(seed: u64, start: usize, operations: usize, tally: &mut Tally) {
    let rng = &mut Rng::new(seed);
    let [plain, filters, margin, fat] = configs();
    let base = [
        plain,
        filters,
        margin,
        fat,
        margin.with_filters().with_events(),
        plain.with_margin(Margin::length(0.25)),
    ][rng.below(6)];
    let most = 2 * start + 4 * operations + 64;
    let large = base.with_capacity(ample(most, 40 * most));
    let config = base
        .with_capacity(Capacity::for_objects(start as u32).with_leaf_refs(start as u32 / 2).with_pairs(1));
    let (mut slab, mut room) = (Slab::new::<I>(&config), Slab::new::<I>(&large));
    let _ = (slab.world::<I>(&config), room.world::<I>(&large));
    let mut life = Life { config, slab, model: Model::default(), large: room, rng, tally };
    let side = (start as f32).cbrt() + 2.0;
    for _ in 0..start {
        let corner = life.rng.point(-side, side);
        life.insert::<I>(scenes::at(corner, [1.0; 3]));
    }
    for _ in 0..operations {
        if life.rng.once_in(3) { life.step::<I>() } else { life.act::<I>() }
    }
    life.step::<I>();
    life.checked::<I>().check();
}

/// As many sequences as the issue of growth asks for: small worlds, of which all kinds of steps but those of trees come.
#[test]
fn a_world_that_grows_says_what_a_large_one_says() {
    let mut tally = Tally::default();
    for seed in 0..9_900 * u64::from(effort()) {
        let start = 1 + (seed % 19) as usize;
        if seed % 2 == 0 {
            live::<u32>(seed, start, 24, &mut tally);
        } else {
            live::<u16>(seed, start, 24, &mut tally);
        }
    }
    println!("{tally:?}");
    assert!(
        tally.grown_for_objects > 1000 && tally.grown_for_pairs > 1000 && tally.moved_into_less > 100,
        "{tally:?}"
    );
    assert!(tally.events > 10_000 && tally.loaded > 1000, "{tally:?}");
}

/// The same with worlds that become large enough for a tree, or lose theirs.
#[test]
fn a_world_that_grows_a_tree_says_what_a_large_one_says() {
    let mut tally = Tally::default();
    for seed in 0..100 * u64::from(effort()) {
        live::<u32>(seed, [490, 510, 540, 700][seed as usize % 4], 36, &mut tally);
    }
    println!("{tally:?}");
    assert!(tally.trees > 100 && tally.grown_for_pairs > 50 && tally.grown_for_objects > 50, "{tally:?}");
}

/// With nothing done in between, the step after a move keeps the result and tells no events.
#[test]
fn nothing_happens_by_a_move_alone() {
    for base in configs() {
        let config = base.with_capacity(ample(700, 9000));
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        world.insert_many(Boxes::new(&scenes::uniform(650, 2))).expect("room");
        world.set_kernels(Kernels::BASELINE).step().expect("room");
        let count = world.pairs().len();
        assert!(count > 20);
        let more = base.with_capacity(ample(2000, 20_000));
        let mut room = Slab::new::<u32>(&more);
        let mut world = world.move_into(room.bytes_mut(), &more).expect("room");
        let step = world.set_kernels(Kernels::BASELINE).step().expect("room");
        assert_eq!((step.pairs().len(), step.found().len(), step.lost().len()), (count, 0, 0));
        assert_eq!(step.stats().moved, 0);
    }
}

#[test]
fn what_cannot_change_is_named() {
    let base = configs()[2].with_capacity(ample(12, 60));
    let mut slab = Slab::new::<u32>(&base);
    let world = lived::<u32>(&mut slab, &base, 10, 3);
    let (mut no_margin, mut no_events, mut few) = (base, base, base);
    no_margin.margin = None;
    no_events.events = false;
    few.capacity.objects = 9;
    let others = [
        (no_margin, Field::Margin),
        (no_events, Field::Events),
        (base.with_filters(), Field::Filters),
        (base.with_values(), Field::Values),
        (base.with_mode(Mode::Fat), Field::Mode),
    ];
    for (config, field) in others {
        let mut room = Slab::new::<u32>(&config);
        room.bytes_mut().fill(3);
        let said = world.move_into(room.bytes_mut(), &config).map(|_| ());
        assert_eq!(said, Err(Error::OtherConfig { field }));
        assert!(room.bytes().iter().all(|byte| *byte == 3), "nothing is written");
    }
    let mut room = Slab::new::<u32>(&base);
    room.bytes_mut().fill(3);
    let said = world.move_into(room.bytes_mut(), &few).map(|_| ()).expect_err("too few");
    assert_eq!(said, Error::NoRoom { field: Field::Objects, needed: 10, room: 9 });
    assert_eq!(said.to_string(), "10 objects (slots that have been in use), but room for 9");
    let short = room.bytes().len() - 64;
    let said = world.move_into(&mut room.bytes_mut()[..short], &base).map(|_| ());
    assert!(matches!(said, Err(Error::SlabTooSmall { .. })));
    assert!(room.bytes().iter().all(|byte| *byte == 3), "nothing is written");
}

/// The pairs that a step has lost come along, and need their room.
#[test]
fn lost_pairs_need_room_too() {
    for base in configs() {
        let Some(few) = base.events.then(|| base.with_capacity(ample(12, 66))) else { continue };
        let mut slab = Slab::new::<u32>(&few);
        let mut world = slab.world::<u32>(&few);
        let ids: Vec<Id> =
            world.insert_many(Boxes::new(&[scenes::cube(0.0, 0.0, 0.0); 12])).expect("room").collect();
        world.step().expect("room");
        for (id, x) in ids.iter().zip(0..) {
            world.set_aabb(*id, scenes::cube(9.0 * x as f32, 0.0, 0.0)).expect("alive");
        }
        assert_eq!(world.step().expect("room").lost().len(), 66);
        let (saved, lost) = (saved(&world), world.lost().to_vec());
        for pairs in [65, 66] {
            let config = few.with_capacity(few.capacity.with_pairs(pairs));
            let expected = if pairs == 66 {
                Ok(lost.clone())
            } else {
                Err(Error::NoRoom { field: Field::Pairs, needed: 66, room: 65 })
            };
            let mut room = Slab::new::<u32>(&config);
            let moved = world.move_into(room.bytes_mut(), &config).map(|there| there.lost().to_vec());
            assert_eq!(moved, expected);
            let mut room = Slab::new::<u32>(&config);
            let mut there = room.world::<u32>(&config);
            assert_eq!(there.load(&saved).map(|()| there.lost().to_vec()), expected);
        }
    }
}

/// An object that had a slot before others keeps its id in the pairs that it has lost, wherever the world goes.
#[test]
fn lost_pairs_keep_the_ids_of_objects_that_are_no_more() {
    let config = Config::new(ample(4, 6)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    let floor = world.insert(scenes::cube(0.0, 0.0, 0.0)).expect("room");
    let mut gone = floor;
    for _ in 0..3 {
        let ball = world.insert(scenes::cube(0.5, 0.0, 0.0)).expect("room");
        world.step().expect("room");
        world.remove(ball).expect("alive");
        gone = ball;
    }
    assert_eq!(gone.generation(), 3);
    world.insert(scenes::cube(7.0, 0.0, 0.0)).expect("room");
    world.step().expect("room");
    let lost = vec![[floor, gone]];
    assert_eq!(world.lost_ids().collect::<Vec<_>>(), lost);
    for config in [config, config.with_capacity(ample(9, 20))] {
        let mut room = Slab::new::<u32>(&config);
        let there = world.move_into(room.bytes_mut(), &config).expect("room");
        assert_eq!(there.lost_ids().collect::<Vec<_>>(), lost);
        let mut room = Slab::new::<u32>(&config);
        let mut loaded = room.world::<u32>(&config);
        loaded.load(&saved(&world)).expect("a good snapshot");
        assert_eq!(loaded.lost_ids().collect::<Vec<_>>(), lost);
    }
}
