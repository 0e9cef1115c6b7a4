//! Faults that users met, each with the least that showed it. What a test here does failed before it was mended.

use std::cell::{Cell, RefCell};
use trisap_core::{
    Aabb, Boxes, Capacity, Cast, Config, Error, Executor, Id, Index, Kernels, Margin, Mode, Reason, Region,
    Stage, World, layout,
};
use trisap_tests::denormals::flushed;
use trisap_tests::scenes::{Brownian, cube, on_x};
use trisap_tests::worlds::{Slab, ample};

fn saved<I: Index>(world: &World<'_, I>) -> Vec<u8> {
    let mut bytes = vec![0; world.snapshot_size()];
    world.save(&mut bytes).expect("room for the snapshot");
    bytes
}

fn fill(world: &mut World<'_, u32>, boxes: &[Aabb]) -> Vec<Id> {
    world.insert_many(Boxes::new(boxes)).expect("room and good boxes").collect()
}

/// A tree has planes and no leaves between a shift of the origin and the next step.
#[test]
fn a_snapshot_after_a_shift_is_loaded() {
    let config = Config::new(ample(600, 4000)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    fill(&mut world, Brownian::new(600, 3).boxes());
    world.set_kernels(Kernels::BASELINE).step().expect("room for the pairs");
    world.shift_origin([1.0, 2.0, 3.0]).expect("finite");
    let bytes = saved(&world);
    assert_eq!(world.load(&bytes), Ok(()));
    assert_eq!(world.len(), 600);
    assert_eq!(saved(&world), bytes);
    let step = world.set_kernels(Kernels::BASELINE).step().expect("room for the pairs");
    assert!(step.found().is_empty() && step.lost().is_empty());
}

/// The mark of an id that comes twice was a bit that an id can have itself.
#[test]
fn an_id_with_a_forged_generation_is_stale_in_a_batch() {
    let config = Config::new(ample(4, 4));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    let ids = fill(&mut world, &[cube(0.0, 0.0, 0.0), cube(5.0, 0.0, 0.0)]);
    let forged = Id::from_bits(ids[0].to_bits() ^ 1 << 63).expect("not zero");
    let before = saved(&world);
    for batch in [[ids[0], forged], [forged, ids[0]]] {
        assert_eq!(world.remove_many(&batch), Err(Error::StaleId { id: forged }));
        assert_eq!(saved(&world), before, "nothing has changed");
    }
    assert_eq!(world.remove_many(&[ids[0], ids[0]]), Err(Error::StaleId { id: ids[0] }));
    assert_eq!(saved(&world), before, "nothing has changed");
}

/// Overlaps of fat boxes that are no pairs do not take the room of pairs, with as many boxes as make a tree or fewer.
#[test]
fn margins_need_no_room_for_pairs() {
    for others in [0, 100, 700] {
        let far = (0..others).map(|k| on_x(100.0 + 50.0 * k as f32, 101.0 + 50.0 * k as f32));
        let mut boxes: Vec<Aabb> =
            [on_x(0.0, 1.0), on_x(1.5, 2.5), on_x(3.0, 4.0)].into_iter().chain(far).collect();
        let config = Config::new(ample(boxes.len(), 1)).with_margin(Margin::length(1.0)).with_events();
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        fill(&mut world, &boxes);
        let reason = Cell::new(None);
        let mut step = |boxes: &[Aabb]| {
            let step = world.set_kernels(Kernels::BASELINE).step_over(Boxes::new(boxes));
            let step = step.map(|step| (step.pairs().to_vec(), step.found().to_vec(), step.lost().to_vec()));
            world.validate().expect("valid");
            reason.set(Some(world.stats().reason));
            step
        };
        assert_eq!(step(&boxes), Ok((vec![], vec![], vec![])), "{others}");
        // A world without a tree sweeps no fat boxes.
        let expected = if others > 0 { Reason::NoRoomForSurplus } else { Reason::FewObjects };
        assert_eq!(reason.get(), Some(expected));
        assert_eq!(step(&boxes), Ok((vec![], vec![], vec![])), "nothing has moved, {others}");
        // Inside its fat box.
        boxes[0] = on_x(0.75, 1.75);
        assert_eq!(step(&boxes), Ok((vec![[0, 1]], vec![[0, 1]], vec![])), "{others}");
        // From one pair to another, both inside their fat boxes.
        boxes[0] = on_x(0.25, 1.25);
        boxes[1] = on_x(2.25, 3.25);
        assert_eq!(step(&boxes), Ok((vec![[1, 2]], vec![[1, 2]], vec![[0, 1]])), "{others}");
        // Two pairs are too many, margins or not, and a step that fails is none to the events.
        boxes[0] = on_x(0.75, 2.75);
        assert_eq!(
            step(&boxes),
            Err(Error::PairsFull { needed: 2, room: config.capacity.pairs }),
            "{others}"
        );
        boxes[2] = on_x(40.0, 41.0);
        assert_eq!(step(&boxes), Ok((vec![[0, 1]], vec![[0, 1]], vec![[1, 2]])), "{others}");
        // Where the surplus fits again.
        boxes[1] = on_x(-40.0, -39.0);
        assert_eq!(step(&boxes), Ok((vec![], vec![], vec![[0, 1]])), "{others}");
        boxes[1] = on_x(2.0, 2.5);
        assert_eq!(step(&boxes), Ok((vec![[0, 1]], vec![[0, 1]], vec![])), "{others}");
    }
}

/// Boxes of the least numbers that there are hold what they were made of, though the host takes these for zero.
#[test]
fn rounding_is_outwards_where_denormals_are_flushed() {
    let numbers =
        [-1e-40, 1e-40, -1e-300, 1e-300, -5e-324, 5e-324, -1.5e-45, 1.5e-45, 0.1, -0.1, 1e-38, -1e-38];
    let origins = [0.0, 1e-40, -1e-39, 5e-324, -5e-324, 1.0, 2.3e-308];
    for x in numbers {
        for origin in origins {
            let made = || Aabb::from_f64([x; 3], [x; 3], [origin; 3]);
            let (plain, flushed) = (made(), flushed(made));
            assert_eq!(bits(&plain), bits(&flushed), "{x:e} from {origin:e}");
            let difference = x - origin;
            assert!(f64::from(plain.min[0]) <= difference && f64::from(plain.max[0]) >= difference);
        }
        let plain = Aabb::from_f64([x; 3], [x; 3], [0.0; 3]);
        assert!(
            f64::from(plain.min[0].next_up()) > x && f64::from(plain.max[0].next_down()) < x,
            "{x:e} is tight"
        );
    }
}

fn bits(aabb: &Aabb) -> [[u32; 3]; 2] {
    [aabb.min.map(f32::to_bits), aabb.max.map(f32::to_bits)]
}

/// Shifts and queries among boxes of denormals answer as they do on other hosts, on all kernels.
#[test]
fn shifts_and_queries_are_the_same_where_denormals_are_flushed() {
    let least = f32::from_bits(1);
    let place = |k: u32| k as f32 * 1e-39;
    for count in [40, 700] {
        let config = Config::new(ample(count, 4 * count)).with_events();
        let boxes: Vec<Aabb> = (0..count as u32)
            .map(|k| Aabb::new([place(k), 0.0, -least], [place(k) + 4e-40, least, 0.0]))
            .collect();
        // Computed where denormals are not flushed.
        let (center, point) = ([place(9), 0.0, 0.0], [place(7), 0.0, 0.0]);
        for kernels in Kernels::all() {
            let transcript = || {
                let mut slab = Slab::new::<u32>(&config);
                let mut world = slab.world::<u32>(&config);
                let ids = fill(&mut world, &boxes);
                world.set_kernels(kernels).step().expect("room for the pairs");
                let mut told = Vec::new();
                for shift in [[0.0; 3], [1e-39, 0.0, 1e-45]] {
                    let rounded = world.shift_origin(shift).expect("finite");
                    world.set_kernels(kernels).step().expect("room for the pairs");
                    let shifted: Vec<_> =
                        ids.iter().map(|id| bits(&world.aabb(*id).expect("alive"))).collect();
                    let mut out = vec![None; count];
                    let ball = Region::Sphere { center, radius: 3e-39 };
                    let near = world.set_kernels(kernels).overlaps(&ball, &mut out).expect("room");
                    let ray = Cast::ray([-1e-38, least, -least], [1e-38, 0.0, 0.0], 1e3);
                    let mut hits = vec![None; count];
                    let met = world.set_kernels(kernels).hits(&ray, &mut hits).expect("room");
                    let mut nearest = vec![None; 5];
                    world.set_kernels(kernels).nearest(point, &mut nearest).expect("finite");
                    let slots = |hits: &[Option<trisap_core::Hit>]| -> Vec<_> {
                        hits.iter().flatten().map(|hit| (hit.id.slot(), hit.distance.to_bits())).collect()
                    };
                    told.push((rounded, shifted, out[..near].to_vec(), slots(&hits[..met]), slots(&nearest)));
                }
                told
            };
            let plain = transcript();
            assert!(plain[0].2.len() >= 5 && plain[0].3.len() == count, "{}", plain[0].2.len());
            assert_eq!(flushed(transcript), plain, "{count} boxes, {kernels:?}");
        }
    }
}

/// Notes the stages of steps.
#[derive(Default)]
struct Noting(RefCell<Vec<Stage>>);

impl Executor for Noting {
    fn workers(&self) -> u32 {
        1
    }
    fn fork_join(&self, _: u32, _: &(dyn Fn() + Sync)) {}
    fn enter(&self, stage: Stage) {
        self.0.borrow_mut().push(stage);
    }
}

/// Each stage once, in order, and the last one always.
#[test]
fn stages_come_in_order_and_end() {
    for (count, pairs) in [(10, 0), (40, 400), (300, 3000), (2000, 20_000), (2000, 3)] {
        let config = Config::new(ample(count, pairs));
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        let mut scene = Brownian::new(count, 5);
        // So near to each other that some overlap.
        let mut boxes = scene.boxes().to_vec();
        for (k, aabb) in boxes.iter_mut().enumerate().take(6) {
            *aabb = cube(0.1 * k as f32, 0.0, 0.0);
        }
        let ids = fill(&mut world, &boxes);
        for round in 0..12 {
            // Many, few, none; and everything in one place, which asks for new planes.
            match round {
                4 => (0..count / 20)
                    .for_each(|k| world.set_aabb(ids[k], cube(k as f32, 9.0, 0.0)).expect("alive")),
                5 | 6 => {}
                7 => ids.iter().for_each(|id| world.set_aabb(*id, cube(3.0, 0.0, 0.0)).expect("alive")),
                _ => {
                    scene.advance();
                    ids.iter().zip(scene.boxes()).for_each(|(id, b)| world.set_aabb(*id, *b).expect("alive"));
                }
            }
            let noting = Noting::default();
            let done = world.set_kernels(Kernels::BASELINE).on(&noting).step().is_ok();
            let stages = noting.0.into_inner();
            assert!(stages.windows(2).all(|two| two[0] < two[1]), "{stages:?}, {count}, round {round}");
            assert_eq!(stages.last(), Some(&Stage::Done), "done: {done}, {count}, round {round}");
        }
    }
}

#[test]
fn what_init_refuses_has_no_size_and_the_error_says_why() {
    for margin in
        [Margin::length(-1.0), Margin::length(f32::NAN), Margin { per_extent: 0.0, min: 2.0, max: 1.0 }]
    {
        let config = Config::new(Capacity::for_objects(10)).with_margin(margin);
        assert_eq!(layout::<u32>(&config), None);
        assert_eq!(World::<u32>::new_in(&mut [], &config).err(), Some(Error::BadMargin));
    }
    let lean = Config::new(Capacity::for_objects(257)).with_lean();
    assert_eq!(layout::<u32>(&lean), None);
    let error = World::<u32>::new_in(&mut [], &lean).expect_err("too many");
    assert!(error.to_string().contains("lean"), "{error}");
    assert!(!Error::LengthMismatch { needed: 1, given: 2 }.to_string().contains("output"));
}

/// Only boxes as given are counted, not what stands around them.
#[test]
fn a_shift_counts_rounded_boxes_as_given() {
    let config = Config::new(ample(2, 2)).with_mode(Mode::Fat).with_margin(Margin::length(0.1));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    fill(&mut world, &[cube(0.0, 0.0, 0.0), cube(8.0, 0.0, 0.0)]);
    // The sides of the boxes stay whole numbers; their margins do not.
    assert_eq!(world.shift_origin([1024.0, 0.0, 0.0]), Ok(0));
}

/// After an object was removed and another had its slot, the pair was told by the id and the value of the
/// other.
#[test]
fn a_pair_is_not_told_of_an_object_that_came_after_it() {
    for config in [Config::new(ample(4, 4)).with_events(), Config::new(ample(700, 9)).with_events()] {
        let mut slab = Slab::new::<u32>(&config.with_values());
        let mut world = slab.world::<u32>(&config.with_values());
        let ids = fill(&mut world, &[cube(0.0, 0.0, 0.0), cube(0.5, 0.0, 0.0), cube(1.0, 0.0, 0.0)]);
        ids.iter().zip(1..).for_each(|(id, value)| world.set_value(*id, value * 100).expect("it lives"));
        world.step().expect("room for the pairs");
        world.remove(ids[1]).expect("it lives");
        let other = world.insert(cube(9.0, 0.0, 0.0)).expect("room");
        world.set_value(other, 700).expect("it lives");
        assert_eq!((other.slot(), world.pairs().len()), (1, 3));
        let bytes = saved(&world);
        for _ in 0..2 {
            assert!(world.pair_ids().eq([[ids[0], ids[2]]]) && world.pair_values().eq([[100, 300]]));
            assert_eq!(world.pairs_of(other).next(), None);
            world.load(&bytes).expect("a good snapshot");
        }
        assert!(world.step().expect("room for the pairs").pair_values().eq([[100, 300]]));
    }
}

/// The same after a step without room for all pairs: the pairs that fitted were told by the id of the other.
#[test]
fn a_pair_that_fitted_is_not_told_of_an_object_that_came_after_it() {
    for config in [Config::new(ample(4, 1)).with_events(), Config::new(ample(700, 1))] {
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        let ids = fill(&mut world, &[cube(0.0, 0.0, 0.0); 2]);
        world.step().expect("room for the pair");
        world.remove(ids[1]).expect("it lives");
        let more = fill(&mut world, &[cube(0.0, 0.0, 0.0); 2]);
        assert!(matches!(world.step(), Err(Error::PairsFull { needed: 3, .. })));
        assert_eq!((more[0].slot(), world.pair_ids().count()), (1, 1));
        let [a, b] = world.pair_ids().next().expect("the one that fitted");
        for id in [a, b] {
            world.remove(id).expect("it lives");
            world.insert(cube(9.0, 0.0, 0.0)).expect("room");
            let bytes = saved(&world);
            assert_eq!((world.pairs().len(), world.pair_ids().next()), (1, None));
            assert_eq!(world.load(&bytes), Ok(()));
            assert_eq!(world.pair_ids().next(), None);
        }
    }
}

/// Two cubes, of which one moves until boxes are predicted.
fn predicted(world: &mut World<'_, u32>, by: f32) -> Vec<Id> {
    let ids = fill(world, &[cube(0.0, 0.0, 0.0), cube(0.5, 0.0, 0.0)]);
    for k in 0..20u16 {
        world.set_aabb(ids[1], cube(0.5 + f32::from(k) * by, 0.0, 0.0)).expect("a good box");
        world.step().expect("room for the pair");
    }
    ids
}

/// What is predicted decided whether a box that became smaller is reported with a new margin.
#[test]
fn predicted_boxes_do_not_show_in_a_fat_world() {
    let config = Config::new(ample(700, 9000)).with_mode(Mode::Fat).with_margin(Margin::length(0.1));
    let pairs = |config: Config| {
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        let ids = predicted(&mut world, 0.35);
        world.set_aabb(ids[0], cube(8.2, 0.0, 0.0)).expect("a good box");
        assert_eq!(world.step().expect("room for the pair").pairs(), [[0, 1]]);
        // Inside what is reported.
        world.set_aabb(ids[1], Aabb::from_center([7.2, 0.5, 0.5], [0.05; 3])).expect("a good box");
        world.step().expect("room for the pair").pairs().len()
    };
    assert_eq!((pairs(config), pairs(config.without_predicted_boxes())), (1, 1));
}

/// Without events nothing says which object has moved inside its margin since the step before, so the pairs
/// that a world takes along to another one are not held against their boxes.
#[test]
fn a_world_that_moved_inside_margins_is_valid_where_it_moves_to_a_tree() {
    let config = |objects| Config::new(ample(objects, 9)).with_margin(Margin::length(0.5));
    let (mut small, mut large) = (Slab::new::<u32>(&config(70)), Slab::new::<u32>(&config(700)));
    let mut world = small.world::<u32>(&config(70));
    let ids = fill(&mut world, &[cube(0.0, 0.0, 0.0), cube(0.9, 0.0, 0.0)]);
    assert_eq!(world.step().expect("room").pairs(), [[0, 1]]);
    world.set_aabb(ids[1], cube(1.2, 0.0, 0.0)).expect("a good box");
    let mut moved = world.move_into(large.bytes_mut(), &config(700)).expect("room");
    assert_eq!(moved.validate(), Ok(()));
    assert!(moved.step().expect("room").pairs().is_empty());
}

/// A world that moved to where no boxes are predicted took along that boxes had moved inside theirs: its snapshots were refused.
#[test]
fn a_snapshot_is_loaded_after_a_move_to_a_world_without_predicted_boxes() {
    for config in [Config::new(ample(700, 9)), Config::new(ample(700, 9)).with_events()] {
        let plain = config.without_predicted_boxes();
        let mut slabs = [&config, &plain].map(Slab::new::<u32>);
        let [from, to] = &mut slabs;
        let mut world = from.world::<u32>(&config);
        let ids = predicted(&mut world, 0.01);
        world.set_aabb(ids[1], cube(0.7, 0.0, 0.0)).expect("a good box");
        let mut world = world.move_into(to.bytes_mut(), &plain).expect("room");
        assert_eq!(world.validate(), Ok(()));
        let bytes = saved(&world);
        assert_eq!(world.load(&bytes), Ok(()));
        assert_eq!(world.step().expect("room").pairs(), [[0, 1]]);
    }
}

/// Which large objects a world had before it loaded a snapshot decided when their list was brought into order, and so the order of
/// pairs: a sequence that `soak` found.
#[test]
fn what_a_world_had_before_it_loaded_does_not_show() {
    let sequence = b"\x06\xb8\xcb\xfe\x5a\x92\x82\xff\x7a\x03\x90\x7c\x16\x98\xb6\xcd\x91\x47\x71\xa1\x0e\xe0\xf7\x92\x61\x3d\x7c\x0e\
        \x5d\xb5\xb2\xaa\x26\xf8\x97\x14\x7d\xf4\xd6\x25\x15\x14\xf4\x59\x2a\x85\xb9\xc2\x84\x6f\x77\x7d\x5b\x9c\xea\x99";
    let _ = trisap_tests::sequence::play(sequence);
}

/// Slots that got other objects before the last step counted as new when pairs were told, in a world that had moved to where there
/// is a tree: a sequence that `soak` found.
#[test]
fn slots_are_reused_for_one_step() {
    let sequence = b"\x03\x9d\x2a\x1d\xc1\xad\xb2\x62\x3e\x8a\x59\xa2\xb0\x05\x26\xec\x86\xc3\x52\xd7\x7a\xe3\x81\x5d\x83\x0f\x84\x65";
    let _ = trisap_tests::sequence::play(sequence);
}

/// The place of the flag that a step sets first and clears last: with it set, a world opens without pairs. It is the last
/// number in front of the arrays.
fn place_of_flag(slab: &Slab) -> usize {
    let opens_empty = |at: &usize| {
        let mut copy = slab.clone();
        copy.bytes_mut()[*at] = 1;
        World::<u32>::open(copy.bytes_mut()).is_ok_and(|world| world.pairs().is_empty())
    };
    (0..1024).step_by(8).rev().find(opens_empty).expect("a flag")
}

/// A box stood there whole or in part, and not yet what is around it: given again, it changed nothing, and its pairs were
/// missed for good.
#[test]
fn a_process_that_ends_within_a_step_leaves_no_wrong_box() {
    let fat = |config: Config| config.with_mode(Mode::Fat).with_margin(Margin::length(0.25));
    let plain = Config::new(ample(600, 4000));
    for config in [plain, plain.with_margin(Margin::length(0.25)), fat(plain), plain.with_events()] {
        let mut boxes = Brownian::new(600, 3).boxes().to_vec();
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        let ids = fill(&mut world, &boxes);
        world.set_enabled(ids[5], false).expect("alive");
        for _ in 0..8 {
            world.step_over(&boxes).expect("room for the pairs");
        }
        let flag = place_of_flag(&slab);
        let bits = |aabb: &Aabb| [aabb.min, aabb.max].map(|corner| corner.map(f32::to_bits));
        // Onto another object, in a corner or whole.
        let (old, new) = (bits(&boxes[7]), bits(&boxes[9]));
        boxes[7] = boxes[9];
        for written in [[new[0], old[1]], [old[0], new[1]], new] {
            let mut left = slab.clone();
            let places: Vec<usize> = left
                .bytes()
                .windows(24)
                .enumerate()
                .step_by(4)
                .filter(|(_, bytes)| *bytes == bytemuck::bytes_of(&old))
                .map(|(at, _)| at)
                .collect();
            assert!(!places.is_empty(), "the box is there");
            let bytes = left.bytes_mut();
            bytes[places[0]..places[0] + 24].copy_from_slice(bytemuck::bytes_of(&written));
            bytes[flag] = 1;
            let mut world = World::<u32>::open(bytes).expect("the world");
            assert_eq!(world.step_over(&boxes).map(|step| step.pairs().len()), {
                let mut fresh = Slab::new::<u32>(&config);
                let mut fresh = fresh.world::<u32>(&config);
                let ids = fill(&mut fresh, &boxes);
                fresh.set_enabled(ids[5], false).expect("alive");
                fresh.step().map(|step| step.pairs().len())
            });
            world.validate().expect("a valid world");
            world.remove_many(&ids).expect("all are there, once");
            assert!(world.is_empty());
        }
    }
}
