//! Whom objects meet: pairs are the overlaps that pass, and events follow every change of mind.

use trisap_core::{Aabb, Config, Error, Filter, Index, Margin, Mode, Path, layout};
use trisap_tests::checked::Checked;
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Rng, cube, on_x};
use trisap_tests::worlds::{Setup, Slab, ample};

/// With events and without, exact and fat, with margins and without.
fn configs() -> [Config; 5] {
    let plain = Config::new(ample(0, 0)).with_filters();
    let margin = plain.with_margin(Margin::length(0.15));
    [plain, plain.with_events(), margin.with_events(), margin, margin.with_mode(Mode::Fat).with_events()]
}

/// A class matrix in which classes meet unless told otherwise.
fn all_but(apart: &[[usize; 2]]) -> [u32; 32] {
    let mut meets = [u32::MAX; 32];
    for &[a, b] in apart {
        // Told on one side alone, which is enough.
        meets[a] &= !(1 << b);
    }
    meets
}

fn any_filter(rng: &mut Rng) -> Filter {
    let bits = |rng: &mut Rng| if rng.once_in(3) { u32::MAX } else { 1 << rng.below(3) | 1 << rng.below(32) };
    Filter { group: bits(rng), mask: bits(rng), class: [0, 1, 2, 31][rng.below(4)] }
}

/// A world in which filters, classes, minds and boxes change, objects come and go, many at once and one by one.
fn live<I: Index>(config: Config, count: usize, ruled: bool, setup: Setup) {
    let capacity = ample(count + 10, 30 * count);
    let config = setup.configure(config.with_capacity(capacity));
    let mut slab = Slab::new::<I>(&config);
    let mut world = Checked::<I>::new(slab.world(&config)).like_the_reference(setup);
    let rng = &mut Rng::new(count as u64 + u64::from(ruled));
    if ruled {
        world.rule();
    }
    let crowded: Vec<Aabb> =
        scenes::uniform(count, 9).iter().map(|b| scenes::at(b.min.map(|x| x * 0.7), [1.0; 3])).collect();
    let ids = world.insert_many(&crowded);
    // None of them meets any other one.
    world.set_classes(&[0; 32]);
    assert!(world.step(setup).pairs.is_empty());
    world.set_classes(&[u32::MAX; 32]);
    assert!(!world.step(setup).pairs.is_empty());
    for id in ids.iter().step_by(2) {
        world.set_filter(*id, any_filter(rng));
    }
    world.step(setup);
    let mut paths = Vec::new();
    for round in 0..24 {
        let ids = world.model().ids();
        let changes = if round % 8 == 7 { count / 3 } else { rng.below(4) };
        for _ in 0..changes {
            let id = ids[rng.below(ids.len())];
            match rng.below(4) {
                0 => world.set_filter(id, any_filter(rng)),
                1 => world.set_filter(id, Filter::ALL),
                // No change of mind at all.
                2 => world.set_filter(id, world.model().filter(id.slot())),
                _ => world.refilter(id, rng.below(3) as u32),
            }
        }
        if round % 6 == 5 {
            let classes = [[0, 1], [1, 1], [31, 2]];
            world.set_classes(&all_but(&classes[..rng.below(4)]));
        }
        if rng.once_in(3) {
            // The slot's next object starts afresh, whatever the last one was told in the same step.
            let id = ids[rng.below(ids.len())];
            let near = world.model().aabb(id.slot()).expect("alive");
            world.set_filter(id, any_filter(rng));
            world.remove(id);
            let new = world.insert(near);
            assert_eq!(new.slot(), id.slot());
            assert_eq!(world.world().filter(new), Some(Filter::ALL));
            assert_eq!(world.world().filter(id), None);
            if rng.once_in(2) {
                world.set_filter(new, any_filter(rng));
            }
        }
        if rng.once_in(4) {
            let mut boxes: Vec<Aabb> = world.model().boxes().iter().map(|b| b.unwrap_or_default()).collect();
            let share = [3, 1000][rng.below(2)];
            scenes::walk(&mut boxes, share, 0.5, rng);
            world.step_over(&boxes, setup);
        }
        paths.push(world.step(setup).stats.path);
    }
    assert!(count < 600 || paths.contains(&Path::Movers), "{paths:?}");
    assert!(paths.contains(&Path::Unchanged) || paths.contains(&Path::Lists), "{paths:?}");
}

#[test]
fn small_worlds_filter() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            for ruled in [false, true] {
                live::<u16>(config, 20, ruled, setup);
                live::<u32>(config.with_lean(), 200, ruled, setup);
                live::<u16>(config, 400, ruled, setup);
            }
        }
    }
}

#[test]
fn worlds_with_a_tree_filter() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            for ruled in [false, true] {
                live::<u32>(config, 800, ruled, setup);
            }
        }
        live::<u16>(configs()[2], 4300, true, setup);
    }
}

/// Each half of each condition, alone.
#[test]
fn both_have_to_agree() {
    let config = Config::new(ample(2, 2)).with_filters().with_events();
    let (a, b) = (Filter::groups(1, 2), Filter::groups(2, 1));
    let cases = [
        (a, b, true),
        (Filter { mask: 4, ..a }, b, false),
        (a, Filter { mask: 4, ..b }, false),
        (Filter { group: 0, ..a }, b, false),
        (a, Filter { group: 0, ..b }, false),
        (Filter { class: 3, ..a }, b, true),
        (Filter { class: 3, ..a }, Filter { class: 4, ..b }, false),
        (Filter { class: 4, ..a }, Filter { class: 3, ..b }, false),
        (Filter { class: 31, ..a }, Filter { class: 31, ..b }, false),
        (Filter::class(3), Filter::class(3), true),
        (Filter::default(), Filter::ALL, true),
    ];
    let mut slab = Slab::new::<u16>(&config);
    let mut world = Checked::<u16>::new(slab.world(&config));
    let ids = world.insert_many(&[on_x(0.0, 1.0), on_x(1.0, 2.0)]);
    world.set_classes(&all_but(&[[3, 4], [31, 31]]));
    for (one, other, meet) in cases {
        world.set_filter(ids[0], one);
        world.set_filter(ids[1], other);
        let outcome = world.step(Setup::REFERENCE);
        assert_eq!(outcome.pairs.len(), usize::from(meet), "{one:?} {other:?}");
    }
}

#[test]
fn a_full_buffer_counts_only_pairs_that_pass() {
    for (count, setup) in
        [20, 300, 900].into_iter().flat_map(|n| Setup::each(&Jobs::USUAL).into_iter().map(move |s| (n, s)))
    {
        let config = setup.configure(Config::new(ample(count, 10)).with_filters().with_events());
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        // All overlap, but only those of one group meet.
        let ids = world.insert_many(&scenes::identical(count));
        for (id, at) in ids.iter().zip(0..) {
            world.set_filter(*id, Filter::groups(1 << (at % 2), u32::from(at < 5)));
        }
        assert_eq!(world.step(setup).pairs.len(), 3, "0, 2 and 4");
        for id in &ids[5..7] {
            world.set_filter(*id, Filter::groups(1, 1));
        }
        assert_eq!(world.step(setup).pairs.len(), 10);
        world.set_filter(ids[7], Filter::groups(1, 1));
        for _ in 0..2 {
            assert_eq!(
                world.try_step(setup),
                Err(Error::PairsFull { needed: 15, room: config.capacity.pairs })
            );
        }
        // Another change of mind before the first complete step.
        world.set_filter(ids[0], Filter::groups(2, 1));
        let outcome = world.step(setup);
        assert_eq!((outcome.pairs.len(), outcome.found.len(), outcome.lost.len()), (10, 4, 4));
    }
}

#[test]
fn a_world_without_filters_refuses_and_pays_nothing() {
    let config = Config::new(ample(100, 100));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let id = world.insert(cube(0.0, 0.0, 0.0));
    assert_eq!(world.refuse(|world| world.set_filter(id, Filter::ALL)), Error::NoFilters);
    assert_eq!(world.refuse(|world| world.set_classes(&[0; 32])), Error::NoFilters);
    assert_eq!(world.refuse(|world| world.refilter(id)), Error::NoFilters);
    let error = world.refuse(|world| world.with_rule(&|_, _| panic!("nobody is asked")).step().map(|_| ()));
    assert_eq!(error, Error::NoFilters);
    assert_eq!(world.world().filter(id), None);

    // Twelve bytes an object, a bit an object and one for each 32, and the class matrix, each up to a cache line longer;
    // without, none of them.
    for objects in [40, 300, 5000] {
        let plain = Config::new(ample(objects, 100));
        let bytes = |config: &Config| layout::<u16>(config).expect("a world").bytes;
        let words = objects.div_ceil(32) + objects.div_ceil(1024);
        let more = bytes(&plain.with_filters()) - bytes(&plain);
        assert!(more.abs_diff(12 * objects + 4 * words + 128) < 3 * 64, "{objects}: {more}");
    }
}

/// Even where there is room for nobody, a world with filters is one.
#[test]
fn a_world_for_nobody_has_filters_too() {
    let config = Config::new(ample(0, 0)).with_filters();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    world.set_classes(&[0; 32]);
    world.rule();
    assert!(world.step(Setup::REFERENCE).pairs.is_empty());
}

#[test]
fn bad_filters_are_refused() {
    let config = Config::new(ample(4, 4)).with_filters();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let id = world.insert(cube(0.0, 0.0, 0.0));
    let gone = world.insert(cube(0.0, 0.0, 0.0));
    world.remove(gone);
    for class in [32, 33, u32::MAX] {
        assert_eq!(world.refuse(|w| w.set_filter(id, Filter::class(class))), Error::BadClass { class });
    }
    let stale = Error::StaleId { id: gone };
    assert_eq!(world.refuse(|w| w.set_filter(gone, Filter::ALL)), stale);
    assert_eq!(world.refuse(|w| w.refilter(gone)), stale);
    assert_eq!(world.world().filter(gone), None);
    world.set_filter(id, Filter::class(31));
}
