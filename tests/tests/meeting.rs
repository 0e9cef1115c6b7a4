//! Only what can meet is compared: counters of worlds with filters beside those of worlds in which only those are that can meet; and
//! random filters, of more kinds than a leaf tells apart, beside brute force.

use trisap_core::{Aabb, Boxes, Config, Filter, Index, Margin, Path, Stats};
use trisap_tests::checked::Checked;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Rng, at, cube};
use trisap_tests::worlds::{Setup, Slab, ample};

/// A class matrix in which only these classes meet.
fn only(meeting: &[[usize; 2]]) -> [u32; 32] {
    let mut meets = [0; 32];
    for &[a, b] in meeting {
        meets[a] |= 1 << b;
        meets[b] |= 1 << a;
    }
    meets
}

/// What the third full step of a world with these objects counts.
fn counted(objects: &[(Aabb, Filter)], meets: &[u32; 32]) -> Stats {
    let (boxes, filters): (Vec<Aabb>, Vec<Filter>) = objects.iter().copied().unzip();
    let config = Config::new(ample(boxes.len(), 40 * boxes.len())).with_filters();
    let mut slab = Slab::new::<u32>(&config.with_movers_only(Choice::Never));
    let mut world = slab.world::<u32>(&config.with_movers_only(Choice::Never));
    let ids: Vec<_> = world.insert_many(Boxes::new(&boxes)).expect("room and good boxes").collect();
    for (id, filter) in ids.iter().zip(filters) {
        world.set_filter(*id, filter).expect("a world with filters");
    }
    world.set_classes(meets).expect("a world with filters");
    for _ in 0..3 {
        world.step().expect("room for the pairs");
    }
    world.stats()
}

#[track_caller]
fn assert_within(percent: u64, stats: &Stats, candidates: u64) {
    assert!(100 * stats.candidates <= percent * candidates, "{candidates} candidates suffice: {stats:?}");
}

/// Unused objects that wait at one point, far away or in the middle of the others, or side by side.
#[test]
fn a_pool_of_parked_objects_costs_no_candidates() {
    let mut rng = Rng::new(3);
    let mut active: Vec<(Aabb, Filter)> = Vec::new();
    active.extend((0..2000).map(|_| (at(rng.point(0.0, 25.0), [1.0; 3]), Filter::ALL)));
    let alone = counted(&active, &[u32::MAX; 32]);
    assert_eq!(alone.spared, 0);
    let parked = Filter { class: 5, ..Filter::ALL };
    for (filter, apart) in [(Filter::groups(0, 0), 32), (Filter::groups(1, 0), 32), (parked, 5)] {
        let mut meets = [u32::MAX; 32];
        meets.iter_mut().skip(apart).take(1).for_each(|row| *row = 0);
        for point in [1e6, 12.0] {
            for step in [0.0, 1.5] {
                let place = |k: usize| point + step * k as f32;
                let park = |k: usize| (cube(place(k % 27), place(k / 27 % 27), place(k / 729)), filter);
                let objects: Vec<_> = active.iter().copied().chain((0..20_000).map(park)).collect();
                let stats = counted(&objects, &meets);
                assert_eq!(stats.pairs, alone.pairs);
                assert!(stats.spared > 1_000_000, "{stats:?}");
                assert_within(105, &stats, alone.candidates + 64);
            }
        }
    }
}

/// A level that does not meet itself, and who walks in it.
#[test]
fn a_level_is_not_compared_with_itself() {
    let mut rng = Rng::new(5);
    let mut place = |edge: f32| {
        let [x, y, z] = rng.point(0.0, 200.0);
        at([x, y / 20.0, z], [rng.between(1.0, edge), rng.between(1.0, edge), rng.between(1.0, edge)])
    };
    let mut objects: Vec<_> = (0..8000).map(|_| (place(6.0), Filter::class(0))).collect();
    objects.extend((0..2000).map(|_| (place(1.0), Filter::class(1))));
    let stats = counted(&objects, &only(&[[0, 1], [1, 1]]));
    assert_within(120, &stats, stats.pairs);
    assert!(stats.spared > 0 && 4 * stats.candidates < counted(&objects, &[u32::MAX; 32]).candidates);
}

/// Two sets of which neither meets itself.
#[test]
fn two_sets_cost_the_candidates_of_both_together() {
    let mut rng = Rng::new(6);
    // Boxes on a sphere that overlap their neighbours, and a few others.
    let mut on_sphere = |edge: f32| {
        let place = rng.in_ball();
        let length = place.iter().map(|x| x * x).sum::<f32>().sqrt().max(0.1);
        at(place.map(|x| 50.0 * x / length), [edge; 3])
    };
    let mut objects: Vec<_> = (0..20_000).map(|_| (on_sphere(2.5), Filter::class(0))).collect();
    objects.extend((0..1000).map(|_| (on_sphere(1.0), Filter::class(1))));
    let stats = counted(&objects, &only(&[[0, 1]]));
    assert_within(150, &stats, stats.pairs);
    // The same by groups.
    for (_, filter) in &mut objects {
        *filter = Filter::groups(1 << filter.class, 2 >> filter.class);
    }
    assert_eq!(counted(&objects, &[u32::MAX; 32]).candidates, stats.candidates);
}

/// A cloth in one world: vertices meet faces, edges meet edges.
#[test]
fn a_cloth_costs_what_two_worlds_cost() {
    const SIDE: usize = 200;
    let mut rng = Rng::new(7);
    let height = |k: usize| 3.0 * (0.13 * (k % SIDE) as f32).sin();
    let vertices: Vec<[f32; 3]> = (0..SIDE * SIDE)
        .map(|k| [(k % SIDE) as f32, height(k) + rng.between(-0.2, 0.2), (k / SIDE) as f32])
        .collect();
    let around = |of: &[usize]| {
        let point = |k: &usize| Aabb::new(vertices[*k], vertices[*k]);
        let bounds = of.iter().map(point).reduce(|a, b| a.union(&b)).expect("at least one");
        Aabb::new(bounds.min.map(|x| x - 0.25), bounds.max.map(|x| x + 0.25))
    };
    let mut objects = Vec::new();
    for k in 0..SIDE * SIDE {
        let (right, below) = (k % SIDE + 1 < SIDE, k / SIDE + 1 < SIDE);
        let (a, b, c) = (k + 1, k + SIDE, k + SIDE + 1);
        let both = right && below;
        let elements: [(bool, &[usize]); 6] = [
            (true, &[k]),
            (right, &[k, a]),
            (below, &[k, b]),
            (both, &[k, c]),
            (both, &[k, a, c]),
            (both, &[k, b, c]),
        ];
        for (there, of) in elements {
            if there {
                objects.push((around(of), Filter::class(of.len() as u32 - 1)));
            }
        }
    }
    let meets = only(&[[0, 2], [1, 1]]);
    let stats = counted(&objects, &meets);
    let part = |edges: bool| {
        let some = objects.iter().copied().filter(|(_, filter)| (filter.class == 1) == edges);
        counted(&some.collect::<Vec<_>>(), &meets)
    };
    let (edges, others) = (part(true), part(false));
    assert_eq!(stats.pairs, edges.pairs + others.pairs);
    assert_within(130, &stats, edges.candidates + others.candidates);
    assert_within(130, &others, others.pairs);
}

/// A lean world: who can meet nobody is left out; filters are asked of the other boxes that overlap.
#[test]
fn lists_leave_out_who_meets_nobody() {
    let mut rng = Rng::new(7);
    let mut place = |edge: f32| at([rng.between(0.0, 90.0), rng.between(0.0, 9.0), 0.0], [edge; 3]);
    let level = (0..150).map(|_| (place(4.0), Filter::class(0))).collect::<Vec<_>>();
    let walkers = (0..60).map(|_| (place(1.0), Filter::class(1))).collect::<Vec<_>>();
    let alone = [
        Filter::groups(1, 0),
        Filter::groups(0, 1),
        Filter { group: 1, ..Filter::class(5) },
        Filter::groups(1, 1 << 9),
    ];
    let parked = (0..40).map(|k| (place(3.0), alone[k % 4])).collect::<Vec<_>>();
    let mut objects = [level, walkers, parked].concat();
    for (_, filter) in &mut objects[..210] {
        filter.group = 1;
    }
    let (boxes, filters): (Vec<Aabb>, Vec<Filter>) = objects.iter().copied().unzip();
    let config = Config::new(ample(250, 10_000)).with_filters().with_lean();
    let mut slab = Slab::new::<u16>(&config);
    let mut world = Checked::<u16>::new(slab.world(&config));
    for (id, filter) in world.insert_many(&boxes).into_iter().zip(&filters) {
        world.set_filter(id, *filter);
    }
    world.set_classes(&only(&[[0, 1], [1, 1]]));
    let stats = world.step(Setup::REFERENCE).stats;
    let along = |a: &Aabb, b: &Aabb| a.min[0] <= b.max[0] && b.min[0] <= a.max[0];
    let all = (0..210).flat_map(|b| (0..b).map(move |a| [a, b]));
    assert_eq!(stats.candidates as usize, all.filter(|&[a, b]| along(&boxes[a], &boxes[b])).count());
    assert_eq!(stats.spared, (250 * 249 - 210 * 209) / 2);
}

/// Few move in a world with a tree: who can meet nobody is not compared.
#[test]
fn movers_that_meet_nobody_are_left_out() {
    let boxes = scenes::uniform(3000, 8);
    let config = Config::new(ample(3000, 30_000)).without_predicted_boxes().with_filters().with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let ids = world.insert_many(&boxes);
    for (k, id) in ids.iter().enumerate().take(60) {
        world.set_filter(*id, [Filter::groups(0, 1), Filter::groups(1, 0), Filter::class(9)][k % 3]);
    }
    let mut meets = [u32::MAX; 32];
    meets[9] = 0;
    world.set_classes(&meets);
    world.step(Setup::REFERENCE);
    for share in [60, 61] {
        for id in &ids[..share] {
            let aabb = world.model().aabb(id.slot()).expect("alive");
            world.set(*id, scenes::shifted(&aabb, [0.25, 0.0, 0.0]));
        }
        let stats = world.step(Setup::REFERENCE).stats;
        assert_eq!((stats.path, stats.candidates > 0), (Path::Movers, share > 60), "{stats:?}");
        assert!(stats.spared > 60, "{stats:?}");
    }
}

/// Few move in a world with a tree: each is compared only in leaves that hold somebody whom it may meet.
#[test]
fn movers_pass_over_leaves_of_those_they_do_not_meet() {
    // A level on one side that does not meet itself, walkers on the other; one whose planes part these.
    let boxes = scenes::uniform(2000, 6);
    let middle = boxes.iter().map(|aabb| aabb.min[0]).sum::<f32>() / 2000.0;
    let kind = |k: usize, by: [Filter; 2]| by[usize::from(boxes[k].min[0] > middle)];
    let mut candidates = [0; 3];
    let kinds = [
        [Filter::ALL; 2],
        [Filter::class(14), Filter::class(3)],
        [Filter::groups(1 << 31, 1), Filter::groups(1, u32::MAX)],
    ];
    for (filters, candidates) in kinds.into_iter().zip(&mut candidates) {
        let config = Config::new(ample(2000, 20_000)).without_predicted_boxes().with_filters().with_events();
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let ids = world.insert_many(&boxes);
        for (k, id) in ids.iter().enumerate() {
            world.set_filter(*id, kind(k, filters));
        }
        world.set_classes(&only(&[[0, 0], [3, 14], [3, 3]]));
        let level: Vec<_> = (0..2000).filter(|&k| boxes[k].min[0] <= middle).step_by(40).collect();
        let round = |world: &mut Checked<'_, u32>, by: f32| {
            for id in level.iter().map(|&k| ids[k]) {
                let aabb = world.model().aabb(id.slot()).expect("alive");
                world.set(id, scenes::shifted(&aabb, [by, 0.0, 0.0]));
            }
            world.step(Setup::REFERENCE).stats
        };
        let rounds: Vec<_> = (0..30).map(|k| round(&mut world, [0.25, -0.25][k % 2])).collect();
        let stats = round(&mut world, 0.25);
        assert_eq!((stats.path, stats.fine_leaves), (Path::Movers, true), "{stats:?}");
        assert_eq!(stats.spared > 0, filters != [Filter::ALL; 2], "{stats:?}");
        *candidates = stats.candidates;
        // Some of the level become walkers, and are met.
        for k in (0..2000).filter(|&k| boxes[k].min[0] <= middle).skip(1).step_by(80) {
            world.set_filter(ids[k], filters[1]);
        }
        assert!(round(&mut world, -0.25).candidates >= rounds[29].candidates);
        for _ in 0..9 {
            round(&mut world, 0.25);
        }
    }
    let [all, by_class, by_group] = candidates;
    assert_eq!(by_class, by_group);
    assert!(3 * by_class < all, "{by_class} of {all}");
}

/// Where all meet, nothing is spared; where few do not, a leaf is swept in one pass.
#[test]
fn who_meets_all_is_compared_once() {
    let filters = |k: usize| [Filter::class(k as u32 % 2), Filter::groups(1 << (k % 3), 7)][k % 2];
    let objects: Vec<_> = scenes::uniform(3000, 8).into_iter().zip((0..).map(filters)).collect();
    let plain: Vec<_> = objects.iter().map(|(aabb, _)| (*aabb, Filter::ALL)).collect();
    let [with, without] = [&objects, &plain].map(|objects| counted(objects, &[u32::MAX; 32]));
    assert_eq!(with, without);
}

/// Filters of few kinds, or of more than are told apart; with some that meet nobody.
fn any_filter(rng: &mut Rng, kinds: usize) -> Filter {
    let bits = |rng: &mut Rng| if rng.once_in(6) { 0 } else { 1 << rng.below(3) | 1 << rng.below(2) };
    match kinds {
        1 => Filter::class(rng.below(3) as u32),
        2 => Filter::groups([1, 2, 4][rng.below(3)], [0, 1, 6][rng.below(3)]),
        _ => Filter { group: bits(rng), mask: bits(rng) | bits(rng), class: rng.below(6) as u32 },
    }
}

/// Boxes, some of them in one heap that is larger than what is swept at once. Filters, classes and boxes change, some rest, all move
/// or some.
fn live<I: Index>(config: Config, count: usize, heap: usize, setup: Setup, seed: u64) {
    let config = setup.configure(config.with_capacity(ample(count + heap, 60 * (count + heap))));
    let mut slab = Slab::new::<I>(&config);
    let mut world = Checked::<I>::new(slab.world(&config)).like_the_reference(setup);
    let rng = &mut Rng::new(seed);
    let mut boxes: Vec<Aabb> =
        scenes::uniform(count, seed).iter().map(|b| at(b.min.map(|x| x * 0.6), [1.0; 3])).collect();
    boxes.extend((0..heap).map(|_| at(rng.point(3.0, 3.5), [0.5; 3])));
    let ids = world.insert_many(&boxes);
    for (k, id) in ids.iter().enumerate() {
        // The heap is one of two sets that hardly meet.
        let heaped = || Filter::groups(8 << (k % 2), if k % 64 == 0 { u32::MAX } else { 4 });
        let filter = if k < count { any_filter(rng, 1 + seed as usize % 3) } else { heaped() };
        world.set_filter(*id, filter);
    }
    // A heap has millions of pairs for brute force to look at.
    for round in 0..if heap > 0 { 4 } else { 10 } {
        if round % 3 == 0 {
            let pairs: Vec<[usize; 2]> = (0..6).map(|_| [rng.below(6), rng.below(6)]).collect();
            world.set_classes(&only(&[&[[0, 0], [0, 1]], &pairs[..]].concat()));
        }
        for _ in 0..[0, 2, count / 4][round % 3] {
            world.set_filter(ids[rng.below(count)], any_filter(rng, 3));
        }
        if round % 4 == 3 {
            world.set_resting(&[ids[rng.below(count)], ids[rng.below(count)]]);
        }
        scenes::walk(&mut boxes, [20, 350, 1000][rng.below(3)], 0.4, rng);
        world.step_over(&boxes, setup);
    }
}

#[test]
fn random_filters_are_those_of_brute_force() {
    let plain = Config::new(ample(0, 0)).with_filters();
    let by_leaf = plain.with_events().with_movers_by_leaf(Choice::Always);
    for setup in Setup::each(&Jobs::USUAL) {
        for (seed, config) in [plain, by_leaf, plain.with_margin(Margin::length(0.15)).with_events()]
            .into_iter()
            .cycle()
            .take(9)
            .enumerate()
        {
            live::<u32>(config, 900, 0, setup, seed as u64 / 3);
            live::<u16>(config.with_lean(), 200, 0, setup, seed as u64);
        }
        live::<u16>(by_leaf, 5000, 0, setup, 2);
    }
}

#[test]
fn heaps_of_objects_that_hardly_meet_are_those_of_brute_force() {
    for setup in Setup::each(&Jobs::USUAL) {
        let plain = Config::new(ample(0, 0)).with_filters();
        live::<u32>(plain.with_movers_by_leaf(Choice::Always), 400, 2100, setup, 1);
        live::<u16>(plain.with_events(), 400, 2100, setup, 2);
    }
}
