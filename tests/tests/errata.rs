//! One test for each erratum of the paper: its counterexample, played alone, in the middle of a large world and
//! as thousands of copies, on every kernel and under every job system.

use trisap_core::{Aabb, Config, Error, Kernels, Margin, Mode, Path};
use trisap_tests::checked::{Checked, Outcome};
use trisap_tests::jobs::Jobs;
use trisap_tests::play::{on_every_setup, play, play_alone};
use trisap_tests::scenes::{self, Rng, at, cube, on_x, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{SlotPair, oracle, recordings, sorted};

const NO_PAIRS: [SlotPair; 0] = [];

/// `play` sets the capacity.
const EXACT: Config = Config::new(ample(0, 0)).without_predicted_boxes();

const fn with_margin(length: f32) -> Config {
    EXACT.with_margin(Margin::length(length))
}

fn pairs(outcomes: &[Outcome]) -> Vec<Vec<SlotPair>> {
    outcomes.iter().map(|outcome| sorted(&outcome.pairs)).collect()
}

fn moved(outcomes: &[Outcome]) -> Vec<u32> {
    outcomes.iter().map(|outcome| outcome.stats.moved).collect()
}

/// The margin grows a box on all sides, so what creeps inside it is resting and what leaves it is not.
#[test]
fn e01_a_margin_grows_the_box() {
    let far = cube(9.0, 0.0, 0.0);
    let frames = [0.0, 0.0, 0.005, -0.009, 0.02, 0.02].map(|x| vec![on_x(x, 1.0 + x), far]);
    let outcomes = play(EXACT.with_margin(Margin::share(0.01)), &frames);
    assert_eq!(moved(&outcomes), [2, 0, 0, 0, 1, 0]);

    // The gap is less than two margins and more than one: the fat boxes meet, the boxes do not.
    let near = vec![on_x(0.0, 1.0), on_x(1.015, 2.0)];
    let fat = play(with_margin(0.01).with_mode(Mode::Fat), &[near.clone(), near.clone()]);
    assert_eq!(pairs(&fat), [[[0, 1]], [[0, 1]]]);
    assert_eq!(fat[0].surplus, 1);
    assert_eq!(pairs(&play(with_margin(0.01), &[near])), [NO_PAIRS]);
}

/// The same scene in any unit gives the same answers, and a large object does not swell the small ones.
#[test]
fn e02_a_margin_belongs_to_its_object() {
    let config = EXACT.with_margin(Margin::share(0.01));
    // Powers of two, so that the scenes are the same to the last bit.
    for unit in [1.0, 128.0, 1024.0, 1.0 / 128.0] {
        let scale = |aabb: Aabb| Aabb::new(aabb.min.map(|x| x * unit), aabb.max.map(|x| x * unit));
        let frame =
            |x: f32| vec![scale(cube(x, 0.0, 0.0)), scale(cube(1.02, 0.0, 0.0)), scale(cube(7.0, 7.0, 7.0))];
        let outcomes = play_alone(config, &[frame(0.0), frame(0.0078125), frame(0.015625), frame(0.03125)]);
        assert_eq!(moved(&outcomes), [3, 0, 1, 1], "in units of {unit}");
        assert_eq!(pairs(&outcomes), [vec![], vec![], vec![], vec![[0, 1]]], "in units of {unit}");
    }

    let plane = Aabb::new([-5e5, -1.0, -5e5], [5e5, 0.0, 5e5]);
    let cubes: Vec<Aabb> =
        (0..999).map(|i| cube((i % 32) as f32 * 2.0, 0.5, (i / 32) as f32 * 2.0)).collect();
    let lifted = |by: f32| cubes.iter().map(move |aabb| shifted(aabb, [0.0, by, 0.0]));
    let frames = [0.0, 0.005, 0.02].map(|by| lifted(by).chain([plane]).collect::<Vec<_>>());
    let outcomes = on_every_setup(config, &frames, &Jobs::USUAL);
    assert_eq!(moved(&outcomes), [1000, 0, 999], "a mean over all sizes would make a margin of 10");

    // Within bounds, where the caller wants them.
    let config = EXACT.with_margin(Margin { per_extent: 0.01, min: 0.05, max: 0.5 }).with_fixed_margins();
    let sizes = [0.1, 10.0, 1000.0];
    let frame = |by: f32| {
        let place = |(i, edge): (usize, f32)| at([by, 3000.0 * i as f32, 0.0], [edge; 3]);
        sizes.into_iter().enumerate().map(place).collect::<Vec<_>>()
    };
    // The margins are 0.05, 0.1 and 0.5.
    assert_eq!(moved(&play_alone(config, &[0.0, 0.04, 0.09, 0.4, 0.6].map(frame))), [3, 0, 1, 2, 3]);
}

/// Resting means contained in the fat box, on both ends.
#[test]
fn e03_containment_is_tested_on_both_ends() {
    let anchor = on_x(0.0, 1.0);
    let leaps = [on_x(-100.0, -99.0), on_x(99.0, 100.0), on_x(-0.5, 1.0), on_x(0.0, 1.5), on_x(-3.0, 4.0)];
    for leap in leaps {
        let outcomes = play_alone(with_margin(0.01), &[vec![anchor], vec![anchor], vec![leap], vec![leap]]);
        assert_eq!(moved(&outcomes), [1, 0, 1, 0], "{leap:?}");
    }
    let waiting = on_x(-99.5, -98.5);
    let frames = [vec![anchor, waiting], vec![anchor, waiting], vec![leaps[0], waiting]];
    assert_eq!(pairs(&play(with_margin(0.01), &frames)), [vec![], vec![], vec![[0, 1]]]);

    // Written positively, so that a box that compares with nothing is not resting but refused.
    for setup in Setup::each(&Jobs::ALL) {
        let config =
            setup.configure(Config::new(ample(2, 4)).with_margin(Margin::length(0.01)).with_events());
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        let ids = checked.insert_many(&[anchor, anchor]);
        checked.step(setup);
        let not_a_box = Aabb::new([f32::NAN; 3], [f32::NAN; 3]);
        let outcome = checked.step_over(&[not_a_box, on_x(5.0, 6.0)], setup);
        assert_eq!(outcome.rejected.map(|rejected| rejected.first), Some(ids[0]));
        assert_eq!((outcome.stats.moved, sorted(&outcome.lost)), (1, vec![[0, 1]]));
    }
}

/// Motion on any axis is motion.
#[test]
fn e04_all_three_axes_count() {
    for axis in 0..3 {
        let frame = |height: f32| {
            let mut falling = [0.0; 3];
            falling[axis] = height;
            vec![at(falling, [1.0; 3]), at([0.0; 3], [1.0; 3])]
        };
        let outcomes = play(with_margin(0.01), &[5.0, 4.0, 2.5, 1.0, 1.0].map(frame));
        assert_eq!(moved(&outcomes), [2, 1, 1, 1, 0]);
        assert_eq!(pairs(&outcomes), [vec![], vec![], vec![], vec![[0, 1]], vec![[0, 1]]], "axis {axis}");
        assert_eq!(outcomes[3].found, [[0, 1]]);
    }
}

/// A creeping cube passes through another: the fat box is the anchor, and the exact test uses the boxes given.
#[test]
fn e05_a_creeping_cube_is_seen() {
    let creep = |margin: f32, speed: f32, frames: usize| {
        let frame = |i: usize| vec![cube(i as f32 * speed, 0.0, 0.0), cube(2.0, 0.0, 0.0)];
        let outcomes =
            on_every_setup(with_margin(margin), &(0..frames).map(frame).collect::<Vec<_>>(), &[Jobs::Serial]);
        let touching = |i: usize| i as f32 * speed + 1.0 >= 2.0 && i as f32 * speed <= 3.0;
        for (i, outcome) in outcomes.iter().enumerate() {
            assert_eq!(outcome.pairs.len(), usize::from(touching(i)), "frame {i}");
        }
        assert_eq!(outcomes.iter().map(|outcome| outcome.found.len()).sum::<usize>(), 1);
        assert_eq!(outcomes.iter().map(|outcome| outcome.lost.len()).sum::<usize>(), 1);
        moved(&outcomes)[1..].iter().sum::<u32>()
    };
    // Re-anchored each frame it would never move; anchored, it leaves its margin every other frame.
    assert!(creep(0.01, 0.009, 445) > 200);
    // Most of the passage happens inside one fat box: no motion, and yet the pair comes and goes.
    assert_eq!(creep(8.0, 0.009, 445), 0);

    // The box that was stored when the object moved last is not the box of this frame.
    let frames = [
        vec![on_x(0.0, 1.0), on_x(1.05, 2.05)],
        vec![on_x(0.009, 1.009), on_x(1.05, 2.05)],
        vec![on_x(0.009, 1.009), on_x(1.005, 2.005)],
        vec![on_x(0.001, 1.001), on_x(1.005, 2.005)],
    ];
    assert_eq!(pairs(&play(with_margin(0.01), &frames)), [vec![], vec![], vec![[0, 1]], vec![]]);
}

/// Two boxes that have come to rest stay a pair.
#[test]
fn e06_resting_pairs_stay() {
    let apart = vec![cube(0.0, 0.0, 0.0), cube(1.5, 0.0, 0.0)];
    let contact = vec![cube(0.0, 0.0, 0.0), cube(1.0, 0.0, 0.0)];
    for config in [EXACT, with_margin(0.01), with_margin(0.01).with_mode(Mode::Fat)] {
        let mut frames = vec![apart.clone()];
        frames.resize(8, contact.clone());
        let outcomes = play(config, &frames);
        assert_eq!(outcomes[1].found, [[0, 1]]);
        for (frame, outcome) in outcomes.iter().enumerate().skip(2) {
            assert_eq!(outcome.pairs, [[0, 1]], "frame {frame}");
            assert!(outcome.found.is_empty() && outcome.lost.is_empty(), "frame {frame}");
            assert_eq!((outcome.stats.moved, outcome.stats.path), (0, Path::Unchanged), "frame {frame}");
        }
    }

    // A box that moves among resting pairs takes nothing from them; a new object moves once.
    for setup in Setup::each(&Jobs::USUAL) {
        let config = setup.configure(Config::new(ample(2000, 8000)).with_events());
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        let ids = checked.insert_many(&scenes::uniform(1500, 6));
        let before = checked.step(setup).pairs.len();
        let outcome = checked.step(setup);
        assert_eq!((outcome.pairs.len(), outcome.stats.moved), (before, 0));
        checked.set(ids[700], cube(3.0, 3.0, 3.0));
        assert_eq!(checked.step(setup).stats.moved, 1);
        let id = checked.insert(cube(4.0, 4.0, 4.0));
        assert_eq!(checked.step(setup).stats.moved, 1);
        assert_eq!(checked.step(setup).stats.moved, 0);
        checked.remove(id);
        checked.step(setup);
        assert_eq!(checked.step(setup).stats.moved, 0);
    }
}

/// Two boxes that overlap and live on different sides of a plane are found, whoever moves.
#[test]
fn e07_static_straddlers_are_not_lost() {
    let straddler = on_x(-1.0, 0.5);
    let visitor = |x: f32| on_x(x, x + 0.2);
    let frames = [9.0, 0.2, 0.2, 0.3, 9.0].map(|x| vec![straddler, visitor(x)]);
    for config in [EXACT, with_margin(0.05)] {
        let pair = vec![[0, 1]];
        let expected = [vec![], pair.clone(), pair.clone(), pair, vec![]];
        assert_eq!(pairs(&play(config, &frames)), expected);
    }

    // Half of 4,000 cubes rest and half of them move: the printed method loses some per cent of the pairs.
    let mut rng = Rng::new(77);
    let mut frames = vec![scenes::uniform(4000, 7)];
    for _ in 0..6 {
        let mut boxes = frames[frames.len() - 1].clone();
        scenes::walk(&mut boxes[..2000], 1000, 0.5, &mut rng);
        frames.push(boxes);
    }
    for config in [EXACT, with_margin(0.05)] {
        let outcomes = on_every_setup(config, &frames, &Jobs::USUAL);
        assert!(outcomes.iter().all(|outcome| outcome.stats.leaves > 1 && outcome.stats.copies > 0));
    }
    // And few of them, which is another path.
    let mut frames = vec![scenes::uniform(4000, 8)];
    for _ in 0..12 {
        let mut boxes = frames[frames.len() - 1].clone();
        scenes::walk(&mut boxes, 5, 2.0, &mut rng);
        frames.push(boxes);
    }
    let outcomes = on_every_setup(EXACT, &frames, &Jobs::USUAL);
    assert!(
        outcomes[1..].iter().all(|outcome| outcome.stats.path == Path::Movers),
        "the movers' path was tested"
    );
}

/// A plane moves over a box that does not: the box has become a straddler.
#[test]
fn e08_planes_may_move_over_resting_boxes() {
    let (resting, entering) = (on_x(1.0, 2.0), |x: f32| on_x(x, x + 0.3));
    let frames = [9.0, 1.6, 1.6].map(|x| vec![resting, entering(x)]);
    assert_eq!(pairs(&play(EXACT, &frames)), [vec![], vec![[0, 1]], vec![[0, 1]]]);

    // Most boxes stream past the resting ones, so that medians and planes must follow them.
    let resting: Vec<Aabb> =
        (0..400).map(|i| cube((i % 20) as f32 * 4.0 - 40.0, (i / 20) as f32, 0.0)).collect();
    let mut streaming = scenes::uniform(3000, 9);
    let mut frames = Vec::new();
    for _ in 0..24 {
        frames.push(resting.iter().chain(&streaming).copied().collect::<Vec<_>>());
        streaming.iter_mut().for_each(|aabb| *aabb = shifted(aabb, [-2.5, 0.25, 0.0]));
    }
    let outcomes = on_every_setup(EXACT, &frames, &Jobs::USUAL);
    let planes_moved = |o: &Outcome| o.stats.path == Path::Rebuilt || o.stats.rebalanced > 0;
    assert!(outcomes[1..].iter().any(planes_moved), "the planes never moved, so this tests nothing");
    assert!(outcomes.iter().all(|outcome| outcome.stats.leaves > 1));
}

/// Boxes that meet in many leaves are one pair.
#[test]
fn e09_each_pair_is_told_once() {
    // Rods in three directions through a cloud of cubes: nearly all straddle several planes.
    let rod = |axis: usize, i: usize| {
        let mut edges = [0.25; 3];
        edges[axis] = 40.0;
        let mut corner = [i as f32, (i * 7 % 30) as f32, (i * 11 % 30) as f32];
        corner[axis] = -5.0;
        at(corner, edges)
    };
    let rods: Vec<Aabb> = (0..90).map(|i| rod(i % 3, i / 3)).collect();
    let cloud = scenes::uniform(2500, 10);
    let first: Vec<Aabb> = rods.iter().chain(&cloud).copied().collect();
    let mut rng = Rng::new(3);
    let mut frames = vec![first];
    for thousandths in [1000, 10, 10, 1000] {
        let mut boxes = frames[frames.len() - 1].clone();
        scenes::walk(&mut boxes, thousandths, 1.0, &mut rng);
        frames.push(boxes);
    }
    for config in [EXACT, with_margin(0.3), with_margin(0.3).with_mode(Mode::Fat)] {
        for outcome in on_every_setup(config, &frames, &Jobs::ALL) {
            let mut once = outcome.pairs.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), outcome.pairs.len());
            assert!(outcome.stats.leaves > 1);
        }
    }
}

/// The interval minimum is the one key: a long box is not hidden behind a short one.
#[test]
fn e10_minima_order_the_sweep() {
    for axis in 0..3 {
        let interval = |min: f32, max: f32| {
            let mut aabb = cube(0.0, 0.0, 0.0);
            (aabb.min[axis], aabb.max[axis]) = (min, max);
            aabb
        };
        let frame = vec![interval(1.0, 2.0), interval(3.0, 4.0), interval(0.0, 10.0)];
        let reversed: Vec<Aabb> = frame.iter().rev().copied().collect();
        let outcomes = play(EXACT, &[frame, reversed]);
        assert_eq!(pairs(&outcomes), [[[0, 2], [1, 2]], [[0, 1], [0, 2]]], "axis {axis}");
    }
}

/// Boxes that no plane separates end in one leaf, and the step ends.
#[test]
fn e11_equal_boxes_do_not_split_for_ever() {
    for count in [2, 511, 512, 513, 514, 1025] {
        let boxes = scenes::identical(count);
        let outcomes = on_every_setup(EXACT, &[boxes.clone(), boxes.clone()], &Jobs::USUAL);
        assert_eq!(outcomes[1].pairs.len(), count * (count - 1) / 2);
    }
    // Equal minima with different maxima, and two heaps of equal boxes.
    let nested: Vec<Aabb> = (0..700).map(|i| Aabb::new([0.0; 3], [i as f32; 3])).collect();
    assert_eq!(on_every_setup(EXACT, &[nested], &Jobs::USUAL)[0].pairs.len(), 700 * 699 / 2);
    let heaps: Vec<Aabb> = (0..1400).map(|i| cube((i % 2) as f32 * 3.0, 0.0, 0.0)).collect();
    assert_eq!(on_every_setup(EXACT, &[heaps], &Jobs::USUAL)[0].pairs.len(), 700 * 699);
}

/// The lists of the three axes are independent of each other.
#[test]
fn e12_each_axis_has_its_own_links() {
    let p = |x: f32, y: f32| at([x, y, 0.0], [0.5, 0.5, 1.0]);
    let frames =
        [vec![p(1.0, 1.0), p(2.0, 2.0)], vec![p(3.0, 1.0), p(2.0, 2.0)], vec![p(2.5, 2.5), p(2.0, 2.0)]];
    // `validate` inside, after every step, looks at the order on each axis.
    assert_eq!(pairs(&play(EXACT, &frames)), [vec![], vec![], vec![[0, 1]]]);

    // Ascending on x, descending on y, shuffled on z; then the roles change.
    let mut rng = Rng::new(12);
    let keys: Vec<[f32; 3]> =
        (0..900).map(|i| [i as f32, 900.0 - i as f32, rng.between(0.0, 900.0)]).collect();
    let frame = |turn: usize| {
        keys.iter().map(|k| at([k[turn], k[(turn + 1) % 3], k[(turn + 2) % 3]], [9.0; 3])).collect()
    };
    on_every_setup(EXACT, &[0, 1, 2, 0].map(frame), &Jobs::USUAL);
}

/// The work grows like the scene, not like its square, whatever the boxes did before. (Work is what is counted
/// here: tests and boxes swept, not seconds.)
#[test]
fn e13_work_is_not_quadratic() {
    const COUNTS: [usize; 3] = [2000, 8000, 32_000];
    let worst_per_box = COUNTS.map(|count| {
        let boxes = scenes::uniform(count, 13);
        let mirrored = boxes.iter().map(|aabb| shifted(aabb, [-2.0 * aabb.min[0], 0.0, 0.0])).collect();
        let elsewhere = scenes::uniform(count, 14);
        let frames = [boxes, mirrored, elsewhere];
        let setup = Setup { kernels: Kernels::detect(), jobs: Jobs::Serial };
        let config = Config::new(ample(count, 4 * count));
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        checked.insert_many(&frames[0]);
        let steps = frames.map(|frame| {
            let stats = checked.step_over(&frame, setup).stats;
            assert!(stats.copies <= 4 * count as u64, "{stats:?}");
            stats.candidates / count as u64
        });
        steps.into_iter().max().expect("a step")
    });
    // All against all would be 16,000 tests a box in the largest, sixteen times as many as in the smallest.
    let [smallest, _, largest] = worst_per_box;
    assert!(largest < 300 && largest < 2 * smallest + 30, "{worst_per_box:?}");
}

/// A tree has no more leaves than its boxes can fill, and with little room it has fewer, never fewer boxes.
#[test]
fn e14_leaves_are_bounded_and_nobody_is_dropped() {
    let boxes = scenes::uniform(1408, 14);
    let expected = trisap_tests::checked::expected(&boxes);
    let mut leaves = Vec::new();
    for leaf_refs in [0, 1, 2, 5, 10, 30, 100, 300, 1000, 20_000] {
        for setup in Setup::each(&Jobs::USUAL) {
            let mut config = setup.configure(Config::new(ample(1408, expected.len())).with_events());
            config.capacity.leaf_refs = leaf_refs;
            let mut slab = Slab::new::<u32>(&config);
            let mut checked = Checked::<u32>::new(slab.world(&config));
            checked.insert_many(&boxes);
            let outcome = checked.step(setup);
            assert_eq!(sorted(&outcome.pairs), expected, "{leaf_refs} leaf references");
            leaves.push(outcome.stats.leaves);
            assert!(outcome.stats.leaves.is_power_of_two(), "{:?}", outcome.stats);
            checked.step_over(&scenes::uniform(1408, 15), setup);
        }
    }
    assert!(leaves.is_sorted(), "more room makes no fewer leaves: {leaves:?}");
    assert_eq!(leaves[0], 1, "no leaf references, no tree");
    assert!(leaves[leaves.len() - 1] > 1);
    for count in [513, 1024, 1408, 3000, 4097] {
        let leaves = on_every_setup(EXACT, &[scenes::uniform(count, 15)], &[Jobs::Serial])[0].stats.leaves;
        // A leaf is meant for 256 boxes at least.
        let bound = count.div_ceil(256).next_power_of_two() as u32;
        assert!(leaves <= bound, "{count} boxes in {leaves} leaves");
    }
}

/// Pairs are filtered, axis by axis, not objects: both ends of a chain are in some pair, but not in one together.
#[test]
fn e15_pairs_are_filtered_not_objects() {
    let chain = vec![cube(0.0, 0.0, 0.0), Aabb::new([0.5; 3], [9.5; 3]), cube(9.0, 9.0, 9.0)];
    assert_eq!(pairs(&play(EXACT, &[chain])), [[[0, 1], [1, 2]]]);
    // Every two share an axis or two, but only one pair shares all three.
    let frame = vec![
        at([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
        at([0.5, 0.5, 9.0], [1.0, 1.0, 1.0]),
        at([9.0, 0.5, 0.5], [1.0, 1.0, 1.0]),
        at([0.5, 9.0, 9.5], [1.0, 1.0, 1.0]),
        at([0.7, 1.2, 8.5], [1.0, 1.0, 1.0]),
    ];
    assert_eq!(pairs(&play(EXACT, &[frame])), [[[1, 4]]]);
}

/// Trees of depth zero, one and two have no grandparents, and every size around them works.
#[test]
fn e16_the_leaf_axis_exists_at_any_depth() {
    let mut depths = Vec::new();
    for count in [1, 2, 3, 63, 300, 511, 512, 513, 514, 700, 1023, 1024, 1025, 1100, 2047, 2048, 2049] {
        let outcomes = on_every_setup(
            EXACT,
            &[scenes::uniform(count, 16), scenes::uniform(count, 17)],
            &[Jobs::Serial, Jobs::Threads(2)],
        );
        depths.extend(outcomes.iter().map(|outcome| outcome.stats.leaves.max(1).ilog2()));
    }
    for depth in 0..=2 {
        assert!(depths.contains(&depth), "no tree of depth {depth} was tested: {depths:?}");
    }
}

/// An axis on which nothing can be separated is not split: flat worlds and lines have good trees too.
#[test]
fn e17_axes_are_chosen_by_gain() {
    for axis in 0..3 {
        for boxes in [scenes::flat(3000, axis, 17), scenes::line(3000, axis, 17)] {
            let outcomes = on_every_setup(EXACT, std::slice::from_ref(&boxes), &Jobs::USUAL);
            let stats = outcomes[0].stats;
            assert!(stats.leaves > 1, "axis {axis}: {stats:?}");
            assert!(stats.copies < boxes.len() as u64, "axis {axis}: {stats:?}");
            assert!(stats.candidates < 300 * boxes.len() as u64, "axis {axis}: {stats:?}");
        }
    }
}

/// No claim without a count: on every recording the number of pairs is that of all against all.
#[test]
fn e18_pair_counts_are_those_of_brute_force() {
    for recording in recordings::all() {
        for frame in [0, recording.frames.len() / 2, recording.frames.len() - 1] {
            let boxes = recording.boxes(frame);
            let expected = oracle::brute_force(&oracle::all_live(&boxes));
            for setup in Setup::each(&Jobs::USUAL) {
                let config = setup.configure(Config::new(ample(boxes.len(), expected.len())));
                let mut slab = Slab::new::<u32>(&config);
                let mut checked = Checked::<u32>::new(slab.world(&config));
                checked.insert_many(&boxes);
                let stats = checked.step(setup).stats;
                assert_eq!(stats.pairs, expected.len() as u64, "{} frame {frame} {setup:?}", recording.name);
            }
            // The count is right also where the pairs have no room.
            let config = Config::new(ample(boxes.len(), 0));
            let mut slab = Slab::new::<u32>(&config);
            let mut checked = Checked::<u32>::new(slab.world(&config));
            checked.insert_many(&boxes);
            let error = checked.try_step(Setup::REFERENCE).expect_err("no room for pairs");
            assert_eq!(error, Error::PairsFull { needed: expected.len() as u64, room: 0 });
        }
    }
}
