//! The tree to look at, and what becomes of it when many objects come or go at once.

use trisap_core::{Aabb, Config, Index, Kernels, Margin, Path, PlaneView, World};
use trisap_tests::checked::Checked;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Brownian, Rng, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};

/// Whether a half-open cell has a corner in it; a side at infinity has what is there.
fn holds(cell: &Aabb, corner: [f32; 3]) -> bool {
    (0..3).all(|k| {
        cell.min[k] <= corner[k]
            && (corner[k] < cell.max[k] || cell.max[k] == f32::INFINITY)
            && (cell.min[k] < f32::INFINITY)
    })
}

/// The leaves divide space, every object is in one of them or large, and the planes are where the leaves meet.
fn look<I: Index>(world: &World<'_, I>, boxes: &[Option<Aabb>]) {
    let leaves: Vec<_> = world.leaves().collect();
    let planes: Vec<_> = world.planes().collect();
    let mut large: Vec<u32> = world.large().map(|id| id.slot()).collect();
    large.sort_unstable();
    assert!(large.windows(2).all(|two| two[0] != two[1]), "no object is large twice");
    // Also those of leaves that nobody is in.
    for cell in leaves.iter().map(|leaf| leaf.cell).chain(planes.iter().map(|plane| plane.cell)) {
        assert!((0..3).all(|k| cell.min[k] <= cell.max[k]), "a cell is turned inside out: {cell:?}");
    }
    if world.stats().leaves <= 1 {
        return;
    }
    assert!(leaves.len() as u32 <= world.stats().leaves);
    assert_eq!(leaves.len(), planes.len() + 1, "each plane divides a leaf");
    assert_eq!(world.stats().large as usize, large.len());
    let mut counts = vec![0; leaves.len()];
    for (slot, aabb) in boxes.iter().enumerate() {
        let Some(aabb) = aabb else { continue };
        let homes: Vec<usize> =
            (0..leaves.len()).filter(|&leaf| holds(&leaves[leaf].cell, aabb.min)).collect();
        assert_eq!(homes.len(), 1, "the minimum of {slot} is in one leaf: {aabb:?} {homes:?}");
        if large.binary_search(&(slot as u32)).is_err() {
            counts[homes[0]] += 1;
        }
    }
    let told: Vec<u32> = leaves.iter().map(|leaf| leaf.objects).collect();
    assert_eq!(told, counts, "the objects of each leaf");

    for plane in &planes {
        assert!(plane.axis < 3 && (plane.depth as usize) < leaves.len());
        let (low, high) = (plane.cell.min[plane.axis], plane.cell.max[plane.axis]);
        assert!(low <= plane.position && plane.position <= high, "a plane stands in its cell: {plane:?}");
        for leaf in &leaves {
            let inside = (0..3)
                .all(|k| plane.cell.min[k] <= leaf.cell.min[k] && leaf.cell.max[k] <= plane.cell.max[k]);
            let cut =
                leaf.cell.min[plane.axis] < plane.position && plane.position < leaf.cell.max[plane.axis];
            assert!(!inside || !cut, "a plane cuts a leaf: {plane:?} {leaf:?}");
        }
    }
    // The leaves in a plane's cell fill it: on each side of it is one of theirs.
    for PlaneView { cell, .. } in &planes {
        let inside = leaves
            .iter()
            .map(|leaf| leaf.cell)
            .filter(|leaf| (0..3).all(|k| cell.min[k] <= leaf.min[k] && leaf.max[k] <= cell.max[k]));
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for leaf in inside {
            for k in 0..3 {
                low[k] = low[k].min(leaf.min[k]);
                high[k] = high[k].max(leaf.max[k]);
            }
        }
        assert_eq!((low, high), (cell.min, cell.max), "leaves fill a plane's cell");
    }
    // Every inner side of a leaf is a plane.
    for leaf in leaves.iter().filter(|leaf| leaf.objects > 0) {
        for k in 0..3 {
            for side in [leaf.cell.min[k], leaf.cell.max[k]].into_iter().filter(|side| side.is_finite()) {
                let plane = planes.iter().find(|plane| plane.axis == k && plane.position == side);
                assert!(plane.is_some(), "no plane at a side of {leaf:?}");
            }
        }
    }
}

#[test]
fn leaves_and_planes_agree() {
    for setup in Setup::each(&Jobs::USUAL) {
        for scene in scenes::all(1600, 3) {
            let config = setup.configure(Config::new(ample(1600, 400_000)).without_predicted_boxes());
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config));
            assert_eq!(world.world().leaves().count() + world.world().planes().count(), 0);
            let ids = world.insert_many(&scene.boxes);
            assert_eq!(world.world().leaves().count() + world.world().large().count(), 0);
            let rng = &mut Rng::new(1);
            for calm in 0..5 {
                if calm > 0 {
                    let id = ids[rng.below(ids.len())];
                    let aabb = world.model().aabb(id.slot()).expect("alive");
                    world.set(id, shifted(&aabb, rng.point(-3.0, 3.0)));
                }
                let outcome = world.step(setup);
                look(world.world(), world.model().boxes());
                assert!(calm == 0 || outcome.stats.path != Path::Rebuilt, "{}", scene.name);
            }
            let mut boxes: Vec<Aabb> = world.model().boxes().iter().flatten().copied().collect();
            scenes::walk(&mut boxes, 1000, 1.0, rng);
            world.step_over(&boxes, setup);
            look(world.world(), world.model().boxes());
        }
    }
}

#[test]
fn a_world_that_is_swept_from_a_list_shows_nothing() {
    for count in [0, 30, 200] {
        let config = Config::new(ample(count, 100 * count)).with_lean();
        let mut slab = Slab::new::<u16>(&config);
        let mut world = Checked::<u16>::new(slab.world(&config));
        world.insert_many(&scenes::uniform(count, 1));
        world.step(Setup::REFERENCE);
        let world = world.world();
        assert_eq!(world.leaves().count() + world.planes().count() + world.large().count(), 0);
    }
}

/// A tenth of a scene goes and comes in one call, at random or all from one corner, while everything moves or all is calm.
#[test]
fn bulk_changes_spoil_nothing() {
    for setup in Setup::each(&Jobs::USUAL) {
        for (margin, moving) in [(None, true), (Some(Margin::length(0.1)), true), (None, false)] {
            let count = 6000;
            let mut config = setup.configure(Config::new(ample(count, 20 * count)).with_events());
            config.margin = margin;
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config));
            let mut scene = Brownian::new(count, 3);
            world.insert_many(scene.boxes());
            assert_eq!(world.step(setup).stats.path, Path::Rebuilt);
            let rng = &mut Rng::new(5);
            let mut go_on = |world: &mut Checked<'_, u32>, what: &str| {
                let start = scene.boxes().to_vec();
                for frame in 0..4 {
                    let outcome =
                        if moving { world.step_over(scene.advance(), setup) } else { world.step(setup) };
                    let stats = outcome.stats;
                    assert_ne!(stats.path, Path::Rebuilt, "{what}, frame {frame}: {stats:?}");
                    assert!(stats.rebalanced <= stats.objects / 4, "{what}, frame {frame}: {stats:?}");
                    if !moving && frame > 0 {
                        assert_eq!(stats.path, Path::Unchanged, "{what}, frame {frame}");
                    }
                }
                start
            };
            for round in 0..3 {
                let mut ids = world.model().ids();
                let boxes = go_on(&mut world, "before");
                for at in 0..ids.len() {
                    ids.swap(at, rng.below(at + 1));
                }
                let mut gone = ids[..count / 10].to_vec();
                world.remove_many(&gone);
                go_on(&mut world, "after the removal");
                gone.truncate(count / 10);
                let new: Vec<Aabb> =
                    gone.iter().map(|id| boxes[(id.slot() as usize + round) % boxes.len()]).collect();
                world.insert_many(&new);
                go_on(&mut world, "after the insertion");
            }
        }
    }
}

/// Movers that are larger than all else go everywhere: afterwards small ones are tested as seldom as before.
#[test]
fn boxes_around_members_become_tight_again() {
    let count = 3000;
    let side = scenes::side(count);
    for kernels in Kernels::all() {
        for fine in [Choice::Always, Choice::Never] {
            let setup = Setup { kernels, jobs: Jobs::Serial };
            let config = Config::new(ample(count, 40 * count))
                .without_predicted_boxes()
                .with_fine_leaves(fine)
                .with_movers_only(Choice::Always);
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config));
            let scene = scenes::uniform(count, 6);
            let ids = world.insert_many(&scene);
            world.step(setup);
            let movers = &ids[..count / 10];
            // To somewhere near, and back.
            let near: Vec<Aabb> =
                scene.iter().take(movers.len()).map(|aabb| shifted(aabb, [0.1; 3])).collect();
            let tests = |world: &mut Checked<'_, u32>| {
                for boxes in [&near[..], &scene[..movers.len()]] {
                    world.update_many(movers, boxes);
                    assert_eq!(world.step(setup).stats.path, Path::Movers);
                }
                world.world().stats().candidates
            };
            let before = (0..5).map(|_| tests(&mut world)).last().expect("a count");
            let rng = &mut Rng::new(7);
            for _ in 0..10 {
                let anywhere: Vec<Aabb> =
                    movers.iter().map(|_| scenes::at(rng.point(0.0, side), [5.0; 3])).collect();
                world.update_many(movers, &anywhere);
                assert_eq!(world.step(setup).stats.path, Path::Movers);
            }
            let grown = tests(&mut world);
            let after = (0..30).map(|_| tests(&mut world)).last().expect("a count");
            assert!(grown * 4 > before * 5, "{grown} tests, {before} before, {fine:?}");
            assert!(after * 20 < before * 21, "{after} tests, {before} before, {fine:?}");
        }
    }
}

/// Many come into the last leaf, which has nobody behind it: not even a part of a leaf that has been whole again since. Many come into
/// the first one, which borrows of the next.
#[test]
fn a_full_leaf_borrows_of_leaves_that_there_are() {
    let count = 3600;
    let mut config = Config::new(ample(2 * count, 40 * count))
        .with_fine_leaves(Choice::Automatic)
        .without_predicted_boxes();
    config.capacity.leaf_refs = 4 * count as u32;
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let mut boxes: Vec<Aabb> =
        (0..count).map(|x| scenes::on_x(2.0 * x as f32, 2.0 * x as f32 + 1.0)).collect();
    world.insert_many(&boxes);
    let setup = Setup::REFERENCE;
    for round in 0..3 {
        // Calm, so that the leaves are divided; then everything moves, and they are whole again.
        for _ in 0..9 {
            world.step(setup);
        }
        boxes.iter_mut().for_each(|aabb| *aabb = shifted(aabb, [0.25, 0.0, 0.0]));
        assert_eq!(world.step_over(&boxes, setup).stats.path, Path::Full, "round {round}");
        for (first, path) in [(0.0, Path::Movers), (2.0 * count as f32 - 150.0, Path::Full)] {
            let new: Vec<Aabb> =
                (0..150).map(|x| scenes::on_x(first + x as f32, first + x as f32 + 1.5)).collect();
            let ids = world.insert_many(&new);
            let stats = world.step(setup).stats;
            assert_eq!((stats.path, stats.fine_leaves), (path, false), "round {round}: {stats:?}");
            world.remove_many(&ids);
            world.step(setup);
        }
    }
}
