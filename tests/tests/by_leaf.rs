//! Steps that sweep all leaves for the pairs of movers alone, and keep the others: each is compared with brute force, on all
//! kernels, alone and with workers.

use trisap_core::{Aabb, Config, Error, Filter, Id, Margin, Mode, Path, Reason, Stats};
use trisap_tests::checked::Checked;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};

const COUNT: usize = 2600;

/// So many thousandths of the boxes go a little way.
fn walk(
    world: &mut Checked<'_>,
    boxes: &mut [Aabb],
    thousandths: usize,
    rng: &mut Rng,
    setup: Setup,
) -> Stats {
    scenes::walk(boxes, thousandths, 0.4, rng);
    world.step_over(boxes, setup).stats
}

/// Lives a life in worlds of all modes, whose steps keep pairs wherever they can.
fn everywhere(room: usize, life: impl Fn(&mut Checked<'_>, &mut [Aabb], &[Id], &mut Rng, Setup)) {
    let exact = Config::new(ample(COUNT + 10, room)).with_movers_by_leaf(Choice::Always);
    let events = exact.with_events();
    let margin = events.with_margin(Margin::length(0.2));
    for config in [exact, events, margin, margin.with_mode(Mode::Fat), events.with_filters()] {
        for setup in Setup::each(&[Jobs::Serial, Jobs::Threads(3)]) {
            let config = setup.configure(config);
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::new(slab.world::<u32>(&config));
            let mut boxes = scenes::Brownian::new(COUNT, 5).boxes().to_vec();
            let ids = world.insert_many(&boxes);
            world.step(setup);
            life(&mut world, &mut boxes, &ids, &mut Rng::new(7), setup);
        }
    }
}

#[test]
fn any_number_of_movers() {
    everywhere(60 * COUNT, |world, boxes, ids, rng, setup| {
        for thousandths in [1, 20, 1000, 0, 300, 300, 50, 700, 1000] {
            let stats = walk(world, boxes, thousandths, rng, setup);
            let paths = [Path::MoversByLeaf, Path::Rebuilt];
            assert!(stats.moved == 0 || paths.contains(&stats.path), "{thousandths}: {stats:?}");
        }
        // Objects that come and go, slots of others.
        let gone: Vec<Id> = ids.iter().copied().step_by(9).collect();
        let there: Vec<Aabb> = gone.iter().map(|id| boxes[id.slot() as usize]).collect();
        world.remove_many(&gone);
        walk(world, boxes, 100, rng, setup);
        world.insert_many(&there);
        assert_eq!(world.step(setup).stats.path, Path::MoversByLeaf);
        // Between steps of other kinds.
        let id = world.insert(boxes[0]);
        world.step(setup);
        world.remove(id);
        walk(world, boxes, 200, rng, setup);
    });
}

#[test]
fn filters_that_change() {
    everywhere(60 * COUNT, |world, boxes, ids, rng, setup| {
        if world.world().config().filters {
            for group in [1, 2, u32::MAX] {
                for id in ids.iter().step_by(7) {
                    world.set_filter(*id, Filter { group, mask: 1, ..Filter::ALL });
                }
                assert_eq!(walk(world, boxes, 100, rng, setup).path, Path::MoversByLeaf);
            }
        }
    });
}

#[test]
fn a_full_buffer_and_the_step_after() {
    everywhere(20 * COUNT, |world, boxes, _, rng, setup| {
        walk(world, boxes, 300, rng, setup);
        // A tenth of the objects in one place have more pairs than there is room for.
        let before = boxes.to_vec();
        boxes[..COUNT / 7].fill(before[0]);
        let error = world.try_step_over(boxes, setup).err();
        assert!(matches!(error, Some(Error::PairsFull { .. })), "{error:?}");
        boxes.copy_from_slice(&before);
        for thousandths in [300, 300] {
            walk(world, boxes, thousandths, rng, setup);
        }
    });
}

#[test]
fn leaves_that_are_swept_in_tiles() {
    // More than a bucket has room for.
    const MANY: usize = 2100;
    let config = Config::new(ample(MANY, MANY * MANY / 2)).with_movers_by_leaf(Choice::Always).with_events();
    for setup in Setup::each(&[Jobs::Serial, Jobs::Threads(2)]) {
        let config = setup.configure(config);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::new(slab.world::<u32>(&config));
        // No plane parts boxes that all have in one place their minimum corners.
        let mut boxes = scenes::identical(MANY);
        world.insert_many(&boxes);
        assert!(world.step(setup).stats.fullest_leaf as usize == MANY);
        for (at, aabb) in boxes.iter_mut().enumerate().filter(|(at, _)| at % 10 < 2) {
            // Some of them come apart from the others.
            aabb.max = if at % 20 == 0 { aabb.max.map(|max| max + 1.0) } else { aabb.min };
        }
        let stats = world.step_over(&boxes, setup).stats;
        assert_eq!(stats.path, Path::MoversByLeaf);
        assert!(stats.fullest_leaf as usize == MANY, "{stats:?}");
    }
}

/// Counts choose it: where enough pairs stay, and not where few do, or where few objects have moved.
#[test]
fn it_is_chosen_where_most_pairs_stay() {
    let config = Config::new(ample(COUNT, 60 * COUNT));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::new(slab.world::<u32>(&config));
    // Six pairs an object and more.
    let (mut boxes, mut rng) = (scenes::Brownian::new(COUNT, 5).boxes().to_vec(), Rng::new(3));
    for aabb in &mut boxes {
        aabb.max = aabb.max.map(|max| max + 2.0);
    }
    world.insert_many(&boxes);
    let first = world.step(Setup::REFERENCE).stats;
    assert!(first.pairs > 6 * COUNT as u64, "{first:?}");
    for (thousandths, path, reason) in [
        (10, Path::Movers, Reason::FewMovers),
        (150, Path::MoversByLeaf, Reason::ManyMovers),
        (900, Path::Full, Reason::ManyMovers),
        (150, Path::MoversByLeaf, Reason::ManyMovers),
    ] {
        let stats = walk(&mut world, &mut boxes, thousandths, &mut rng, Setup::REFERENCE);
        assert_eq!((stats.path, stats.reason), (path, reason), "{thousandths}: {stats:?}");
        // It looks at the candidates of movers alone.
        assert!(path != Path::MoversByLeaf || 2 * stats.candidates < first.candidates, "{stats:?}");
    }
}
