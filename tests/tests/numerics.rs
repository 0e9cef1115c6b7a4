//! One test for each hard case of the numerics table, and one for each promise, on every kernel and under every
//! kind of job system.

use std::panic::{AssertUnwindSafe, catch_unwind};
use trisap_core::{Aabb, Boxes, Config, Error, Id, Margin, Mode, Rejected, World};
use trisap_tests::checked::{Checked, Outcome, expected};
use trisap_tests::denormals::flushed;
use trisap_tests::doing::On as _;
use trisap_tests::jobs::Jobs;
use trisap_tests::play::{on_every_setup, play, play_alone, play_among_fillers};
use trisap_tests::scenes::{self, Brownian, Rng, at, cube, on_x, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{SlotPair, sorted};

const NO_PAIRS: [SlotPair; 0] = [];

/// `play` and `on_every_setup` set the capacity.
const EXACT: Config = Config::new(ample(0, 0));

const fn with_margin(length: f32) -> Config {
    EXACT.with_margin(Margin::length(length))
}

/// The ways in which a world can be set up to answer.
fn modes(length: f32) -> [Config; 3] {
    [EXACT, with_margin(length), with_margin(length).with_mode(Mode::Fat)]
}

fn pairs(outcomes: &[Outcome]) -> Vec<Vec<SlotPair>> {
    outcomes.iter().map(|outcome| sorted(&outcome.pairs)).collect()
}

/// A world of these boxes on every setup, after its first step, with room for twice as many.
fn each_world(config: Config, boxes: &[Aabb], jobs: &[Jobs], test: impl Fn(&mut Checked<'_>, &[Id], Setup)) {
    let pairs = 16 * boxes.len() + expected(boxes).len();
    for setup in Setup::each(jobs) {
        let config = setup.configure(config.with_capacity(ample(2 * boxes.len() + 8, pairs)));
        let mut slab = Slab::new::<u32>(&config.with_events());
        let mut checked = Checked::<u32>::new(slab.world(&config.with_events()));
        let ids = checked.insert_many(boxes);
        checked.step(setup);
        test(&mut checked, &ids, setup);
    }
}

/// Everything that a world says to these frames, without a look at the model.
fn transcript(config: Config, frames: &[Vec<Aabb>], setup: Setup) -> Vec<Result<Outcome, Error>> {
    let mut capacity = ample(frames[0].len(), 40 * frames[0].len());
    capacity.leaf_refs = frames[0].len() as u32;
    let config = setup.configure(config.with_capacity(capacity).with_events());
    let mut slab = Slab::new::<u32>(&config);
    let mut world: World<'_> = slab.world(&config);
    world.insert_many(Boxes::new(&frames[0])).expect("room for all");
    let mut step = |frame: &Vec<Aabb>| {
        let step = world.under(&setup).step_over(Boxes::new(frame))?;
        Ok(Outcome::of(&step))
    };
    frames.iter().map(&mut step).collect()
}

/// Boxes that are not boxes because of `value` in one of their six numbers.
fn spoilt(value: f32) -> [Aabb; 6] {
    [0, 1, 2, 3, 4, 5].map(|i| {
        let mut aabb = cube(0.0, 0.0, 0.0);
        if i < 3 {
            aabb.min[i] = value
        } else {
            aabb.max[i - 3] = value
        }
        aabb
    })
}

/// Every way in must refuse these boxes, name the culprit and touch nobody else.
fn refused_everywhere(bad_boxes: &[Aabb]) {
    for count in [3, 1200] {
        each_world(with_margin(0.01), &scenes::uniform(count, 20), &Jobs::USUAL, |world, ids, setup| {
            let good = cube(1.0, 2.0, 3.0);
            for bad in bad_boxes {
                assert_eq!(world.refuse(|w| w.insert(*bad)), Error::BadBox { index: 0 });
                assert_eq!(world.refuse(|w| w.set_aabb(ids[1], *bad)), Error::BadBox { index: 0 });
                let batch = [good, good, *bad];
                let error = world.refuse(|w| w.insert_many(Boxes::new(&batch)).map(drop));
                assert_eq!(error, Error::BadBox { index: 2 });
                let error = world.refuse(|w| w.update_many(&ids[..3], Boxes::new(&batch)));
                assert_eq!(error, Error::BadBox { index: 2 });
                // In a bounds array it is skipped: the others move.
                let outcome = world.step_over(&[shifted(&good, [0.0, 0.5, 0.0]), *bad, good], setup);
                assert_eq!(outcome.rejected, Some(Rejected { first: ids[1], count: 1 }), "{bad:?}");
                let outcome = world.step_over(&[*bad, good, *bad], setup);
                assert_eq!(outcome.rejected, Some(Rejected { first: ids[0], count: 2 }), "{bad:?}");
                assert_eq!(world.step(setup).rejected, None);
            }
        });
    }
}

#[test]
fn nan_is_refused_at_the_door() {
    refused_everywhere(&spoilt(f32::NAN));
    // As an integer key, NaN with a sign sorts first.
    refused_everywhere(&spoilt(-f32::NAN));
    refused_everywhere(&spoilt(f32::from_bits(0x7f80_0001)));
    refused_everywhere(&[Aabb::new([f32::NAN; 3], [f32::NAN; 3])]);
}

#[test]
fn min_above_max_is_refused() {
    let above = [0, 1, 2].map(|k| {
        let mut aabb = cube(0.0, 0.0, 0.0);
        (aabb.min[k], aabb.max[k]) = (1.0, 1.0_f32.next_down());
        aabb
    });
    refused_everywhere(&above);
    let inf = f32::INFINITY;
    refused_everywhere(&[Aabb::new([inf; 3], [-inf; 3]), Aabb::new([1.0; 3], [-1.0; 3])]);
    // By one denormal, and only in the second axis.
    refused_everywhere(&[Aabb::new([0.0, f32::from_bits(2), 0.0], [1.0, f32::from_bits(1), 1.0])]);
}

#[test]
fn infinite_boxes_are_unbounded() {
    let inf = f32::INFINITY;
    let ground = Aabb::new([-inf, -inf, -inf], [inf, 0.0, inf]);
    let half_space = Aabb::new([1.0, -inf, -inf], [inf; 3]);
    let pole = Aabb::new([0.25, -inf, 0.25], [0.5, inf, 0.5]);
    let space = Aabb::new([-inf; 3], [inf; 3]);
    let horizon = Aabb::new([inf, 0.0, 0.0], [inf, 1.0, 1.0]);
    let far = Aabb::new([f32::MAX, 0.0, 0.0], [f32::MAX, 1.0, 1.0]);
    let standing = cube(0.0, 0.0, 0.0);
    let flying = cube(-3.0, 2.0, 0.0);
    let frame = vec![ground, half_space, pole, space, horizon, far, standing, flying];
    // They may come and go, and turn into ordinary boxes and back.
    let mut rotated = frame.clone();
    rotated.rotate_left(3);
    let frames = [frame.clone(), frame.clone(), rotated, frame];
    let exact = expected(&frames[0]);
    assert!(exact.contains(&[0, 6]) && exact.contains(&[1, 4]) && !exact.contains(&[4, 5]));
    // A length is taken as it is; a share of an infinite extent is bounded by the largest margin.
    let mut configs = modes(0.1).to_vec();
    configs.push(EXACT.with_margin(Margin { per_extent: 0.01, min: 0.0, max: 2.0 }));
    configs.push(EXACT.with_margin(Margin::share(0.5)));
    for config in configs {
        // No copies side by side: all these infinite boxes would meet each other.
        let outcomes = play_alone(config, &frames);
        assert_eq!(outcomes[1].stats.moved, 0, "{config:?}");
        play_among_fillers(config, &frames);
    }
    // In a world with a tree they live in a list of their own.
    let mut boxes = scenes::uniform(2000, 21);
    boxes.extend(&frames[0]);
    let outcomes = on_every_setup(EXACT, &[boxes], &Jobs::USUAL);
    // Ground, half-space and space; the rest reaches far only where no plane is.
    assert!(outcomes[0].stats.large >= 3, "{:?}", outcomes[0].stats);
    assert!(outcomes[0].stats.leaves > 1, "{:?}", outcomes[0].stats);
    // Many of them, in every mixture.
    let mut rng = Rng::new(22);
    let mut some = scenes::uniform(1500, 22);
    for aabb in some.iter_mut().step_by(40) {
        let axis = rng.below(3);
        if rng.once_in(2) { aabb.min[axis] = -inf } else { aabb.max[axis] = inf }
    }
    let mut frames = vec![some.clone()];
    scenes::walk(&mut some, 500, 1.0, &mut rng);
    frames.push(some.clone());
    scenes::walk(&mut some, 3, 1.0, &mut rng);
    frames.push(some);
    for config in modes(0.1) {
        on_every_setup(config, &frames, &Jobs::USUAL);
    }
}

#[test]
fn negative_zero_is_zero() {
    for axis in 0..3 {
        for [low, high] in [[0.0, -0.0], [-0.0, 0.0], [0.0, 0.0], [-0.0, -0.0]] {
            let mut below = cube(-0.5, -0.5, -0.5);
            let mut above = cube(-0.5, -0.5, -0.5);
            (below.min[axis], below.max[axis]) = (-1.0, low);
            (above.min[axis], above.max[axis]) = (high, 1.0);
            let mut flat = below;
            (flat.min[axis], flat.max[axis]) = (high, low);
            // Later frames change the sign of a zero and nothing else: nobody has moved.
            let swapped = |aabb: &Aabb| {
                let turn = |x: f32| if x == 0.0 { -x } else { x };
                Aabb::new(aabb.min.map(turn), aabb.max.map(turn))
            };
            let frame = vec![below, above, flat];
            let turned: Vec<Aabb> = frame.iter().map(swapped).collect();
            let outcomes = play_alone(EXACT, &[frame.clone(), turned, frame]);
            assert_eq!(pairs(&outcomes), vec![[[0, 1], [0, 2], [1, 2]]; 3], "axis {axis}, {low} and {high}");
            assert!(outcomes[1..].iter().all(|outcome| outcome.stats.moved == 0));
        }
    }
    // In a tree, with every minimum on a plane.
    let mut rng = Rng::new(23);
    let zero = |rng: &mut Rng| if rng.once_in(2) { 0.0 } else { -0.0 };
    let mut place = |i: usize| {
        let mut aabb = at([0.0, (i / 40) as f32, (i % 40) as f32], [0.0, 1.0, 1.0]);
        (aabb.min[0], aabb.max[0]) = (zero(&mut rng), zero(&mut rng));
        if i.is_multiple_of(3) {
            aabb.min[0] = -1.0
        }
        if i.is_multiple_of(5) {
            aabb.max[0] = 1.0
        }
        aabb
    };
    let frames = [0, 1].map(|_| (0..1600).map(&mut place).collect::<Vec<_>>());
    on_every_setup(EXACT, &frames, &Jobs::ALL);
}

/// A lattice so fine that all its coordinates are denormal.
fn denormal_lattice(count: usize, seed: u64) -> Vec<Aabb> {
    let mut rng = Rng::new(seed);
    let unit = |i: i32| f32::from_bits(i.unsigned_abs()).copysign(i as f32);
    let mut place = || {
        let corner = [(); 3].map(|()| rng.below(41) as i32 - 20);
        let edges = [(); 3].map(|()| rng.below(3) as i32);
        Aabb::new(corner.map(unit), [0, 1, 2].map(|k| unit(corner[k] + edges[k])))
    };
    (0..count).map(|_| place()).collect()
}

#[test]
fn denormals_count_in_every_mode_of_the_host() {
    let apart = f32::from_bits(1);
    let frame = vec![on_x(-1.0, 0.0), on_x(apart, 1.0), on_x(-apart, -0.0), on_x(apart, apart)];
    let outcomes = play(EXACT, &[frame.clone(), frame]);
    assert_eq!(pairs(&outcomes), vec![vec![[0, 2], [1, 3]]; 2]);

    // Margins whose arithmetic is denormal may round away, but that never changes the result.
    let frames = [24, 25, 26].map(|seed| denormal_lattice(1500, seed));
    for config in [EXACT, with_margin(f32::from_bits(1))] {
        on_every_setup(config, &frames, &Jobs::ALL);
    }
    for count in [1, 30, 500, 1500] {
        let frames = [0, 1, 2].map(|i| frames[i][..count].to_vec());
        for setup in Setup::each(&Jobs::ALL) {
            let plain = transcript(EXACT, &frames, setup);
            assert!(plain.iter().all(Result::is_ok));
            assert!(flushed(|| transcript(EXACT, &frames, setup)) == plain, "{count} boxes, {setup:?}");
        }
    }
    // With an ordinary margin around boxes of denormal size, which all meet then.
    let few = [0, 1, 2].map(|i| frames[i][..30].to_vec());
    for config in modes(0.01) {
        for setup in Setup::each(&Jobs::ALL) {
            assert_eq!(
                flushed(|| transcript(config, &few, setup)),
                transcript(config, &few, setup),
                "{setup:?}"
            );
        }
    }
    // A box that is inverted by a denormal is no box in either mode.
    let inverted = Aabb::new([f32::from_bits(2), 0.0, 0.0], [f32::from_bits(1), 1.0, 1.0]);
    let mut slab = Slab::new::<u32>(&Config::new(ample(4, 4)));
    let mut world: World<'_> = slab.world(&Config::new(ample(4, 4)));
    assert_eq!(flushed(|| world.insert(inverted)), Err(Error::BadBox { index: 0 }));
}

#[test]
fn touching_faces_edges_and_corners_overlap() {
    // All 26 neighbours of a cube touch it; an ulp further out none does.
    let neighbours = |gap: f32| {
        let mut boxes = vec![cube(1.0, 1.0, 1.0)];
        for i in 0..27 {
            let side = [i % 3, i / 3 % 3, i / 9];
            if side != [1, 1, 1] {
                let place = |k: usize| match side[k] {
                    0 => [0.0, 1.0 - gap],
                    1 => [1.0, 2.0],
                    _ => [2.0 + 2.0 * gap, 3.0],
                };
                boxes.push(Aabb::new([0, 1, 2].map(|k| place(k)[0]), [0, 1, 2].map(|k| place(k)[1])));
            }
        }
        boxes
    };
    let outcomes = play_alone(EXACT, &[neighbours(0.0), neighbours(f32::EPSILON), neighbours(0.0)]);
    let with_centre = |outcome: &Outcome| outcome.pairs.iter().filter(|pair| pair[0] == 0).count();
    assert_eq!(outcomes.iter().map(with_centre).collect::<Vec<_>>(), [26, 0, 26]);
}

#[test]
fn zero_volume_boxes_overlap() {
    // A point, a segment and a square, on a corner of the cube, through it, and just beside it.
    let beside = 1.0_f32.next_up();
    let frame = vec![
        cube(0.0, 0.0, 0.0),
        at([1.0; 3], [0.0; 3]),
        at([0.5, 0.5, -9.0], [0.0, 0.0, 20.0]),
        at([-5.0, 1.0, -5.0], [10.0, 0.0, 10.0]),
        at([beside, 0.0, 0.0], [0.0; 3]),
        at([0.5; 3], [0.0; 3]),
        at([0.5; 3], [0.0; 3]),
    ];
    let with_cube: Vec<SlotPair> = pairs(&play(EXACT, &[frame])).concat();
    assert_eq!(with_cube.iter().filter(|pair| pair[0] == 0).count(), 5);
    assert!(with_cube.contains(&[5, 6]) && !with_cube.contains(&[0, 4]));
    let frames = [scenes::points(3000, 27), scenes::points(3000, 28)];
    assert!(on_every_setup(EXACT, &frames, &Jobs::ALL)[0].stats.leaves > 1);
}

#[test]
fn equal_keys_have_one_order() {
    let frames = |boxes: Vec<Aabb>| {
        let mut moved = boxes.clone();
        scenes::walk(&mut moved, 10, 1.0, &mut Rng::new(29));
        [boxes.clone(), moved, boxes]
    };
    for boxes in [
        scenes::voxels(12),
        scenes::identical(600),
        scenes::flat(1800, 0, 30),
        scenes::flat(1800, 1, 30),
        scenes::flat(1800, 2, 30),
        // All minima and maxima on one lattice plane, in two heaps.
        (0..1200).map(|i| cube((i % 2) as f32, (i / 2) as f32 * 2.0, 0.0)).collect(),
    ] {
        on_every_setup(EXACT, &frames(boxes), &Jobs::ALL);
    }
}

#[test]
fn a_margin_below_one_ulp_changes_nothing() {
    for far in [262_144.0, 1e9, 1e30] {
        let away = |boxes: Vec<Aabb>| boxes.iter().map(|b| shifted(b, [far, -far, far])).collect::<Vec<_>>();
        let near: Vec<Aabb> = away(scenes::uniform(40, 31));
        let step = |boxes: &[Aabb]| {
            let up = |aabb: &Aabb| Aabb::new(aabb.min.map(f32::next_up), aabb.max.map(f32::next_up));
            boxes.iter().map(up).collect::<Vec<_>>()
        };
        for config in modes(0.01) {
            let outcomes =
                on_every_setup(config, &[near.clone(), near.clone(), step(&near), near.clone()], &Jobs::ALL);
            // The fat box contains its own box, whatever the margin was rounded to.
            assert_eq!(outcomes[1].stats.moved, 0, "{config:?} at {far}");
        }
    }
    let frames = [32, 33].map(|seed| scenes::uniform(1500, seed));
    let frames =
        frames.map(|boxes| boxes.iter().map(|b| shifted(b, [262_144.0, 0.0, 0.0])).collect::<Vec<_>>());
    for config in modes(0.01) {
        on_every_setup(config, &frames, &Jobs::USUAL);
    }
}

#[test]
fn a_margin_that_overflows_saturates() {
    let max = f32::MAX;
    let frame = vec![
        Aabb::new([-max; 3], [max; 3]),
        Aabb::new([max; 3], [max; 3]),
        Aabb::new([-max; 3], [-max; 3]),
        Aabb::new([f32::INFINITY; 3], [f32::INFINITY; 3]),
        Aabb::new([0.0; 3], [max, 1.0, max]),
        cube(0.0, 0.0, 0.0),
    ];
    let mut boxes = scenes::uniform(1500, 34);
    boxes.extend(&frame);
    let margins = [Margin::length(max), Margin::length(1e38), Margin::share(max), Margin::share(1.0)];
    for mode in [Mode::Exact, Mode::Fat] {
        for margin in margins {
            let config = EXACT.with_margin(margin).with_mode(mode);
            let outcomes = play_alone(config, &[frame.clone(), frame.clone(), frame.clone()]);
            assert_eq!(outcomes[1].stats.moved, 0, "{margin:?}");
        }
    }
    let share = EXACT.with_margin(Margin { per_extent: 1e-3, min: 0.0, max });
    on_every_setup(share, &[boxes.clone(), boxes], &Jobs::USUAL);
}

/// Centres and half extents round; minima and maxima do not. Neighbours meet or miss each other by one ulp.
#[test]
fn overlaps_of_one_ulp_are_not_missed() {
    let mut rng = Rng::new(35);
    let frames = [(); 3].map(|()| {
        let mut boxes = Vec::new();
        for _ in 0..1000 {
            let aabb = at(rng.point(-100.0, 100.0), rng.point(0.01, 2.0));
            let axis = rng.below(3);
            let mut next = shifted(&aabb, rng.point(-0.01, 0.01));
            next.min[axis] = match rng.below(3) {
                0 => aabb.max[axis],
                1 => aabb.max[axis].next_up(),
                _ => aabb.max[axis].next_down(),
            };
            next.max[axis] = next.min[axis] + 1.0;
            boxes.extend([aabb, next]);
        }
        boxes
    });
    for config in [EXACT, with_margin(0.02)] {
        on_every_setup(config, &frames, &Jobs::USUAL);
    }
}

#[test]
fn far_from_the_origin_the_pairs_are_right_and_the_world_warns() {
    // 64 unit cubes in a row have two distinct coordinates here.
    let row = |far: f32| (0..64).map(|i| cube(far + i as f32, 0.0, 0.0)).collect::<Vec<_>>();
    let outcomes = play_alone(EXACT, &[row(1e9)]);
    assert!(outcomes[0].coarse);
    assert!(outcomes[0].pairs.len() > 63, "a superset of the neighbours");
    assert!(!play_alone(EXACT, &[row(0.0)])[0].coarse);

    let uniform = scenes::uniform(2000, 36);
    let away = |far: f32| uniform.iter().map(|b| shifted(b, [0.0, far, 0.0])).collect::<Vec<_>>();
    assert!(on_every_setup(EXACT, &[away(1e9)], &Jobs::USUAL)[0].coarse);
    assert!(!on_every_setup(EXACT, &[away(0.0)], &Jobs::USUAL)[0].coarse);

    // Boxes that have lost all their sides, by rounding to the nearest, are seen too; points that are told apart are points.
    let vanished = |far: f32| {
        let centres = uniform.iter().map(|b| b.min.map(|x| x + far));
        centres.map(|c| Aabb::new(c.map(|x| x - 0.5), c.map(|x| x + 0.5))).collect::<Vec<_>>()
    };
    assert!(vanished(1e9).iter().all(|b| b.min == b.max), "some have a side left");
    for count in [20, 300, 2000] {
        let warns =
            |boxes: &[Aabb]| on_every_setup(EXACT, &[boxes[..count].to_vec()], &Jobs::USUAL)[0].coarse;
        assert!(warns(&vanished(1e9)), "{count}");
        for far in [0.0, 100.0, 1e4] {
            let points: Vec<_> =
                uniform.iter().map(|b| b.min.map(|x| x + far)).map(|c| Aabb::new(c, c)).collect();
            assert!(!warns(&points), "{count} points at {far}");
        }
    }

    // Shifting the origin by an amount that is exact for all changes no pair.
    let lattice: Vec<Aabb> = uniform.iter().map(|b| at(b.min.map(|x| x.floor()), [1.0; 3])).collect();
    let back: Vec<Aabb> = lattice.iter().map(|b| shifted(b, [-4096.0, 8192.0, 1024.0])).collect();
    let outcomes = on_every_setup(EXACT, &[lattice, back], &Jobs::USUAL);
    assert_eq!(sorted(&outcomes[0].pairs), sorted(&outcomes[1].pairs));
    assert!(outcomes[1].found.is_empty() && outcomes[1].lost.is_empty());
}

#[test]
fn world_coordinates_in_f64_lose_no_pair() {
    let mut rng = Rng::new(61);
    for far in [0.0, 1e3, 1e6, 1e9, 1e12] {
        for origin in [[0.0; 3], [far, 0.0, -far]] {
            // Boxes that touch exactly in f64, at places that f32 cannot tell.
            let mut place = |_| {
                let corner = rng.point(0.0, 6.0).map(f64::from);
                [corner[0] + far, corner[1] / 3.0, corner[2] - far]
            };
            let boxes: Vec<([f64; 3], [f64; 3])> = (0..200)
                .map(&mut place)
                .flat_map(|min| {
                    let max = min.map(|x| x + 0.7);
                    [(min, max), (max, max.map(|x| x + 0.1))]
                })
                .collect();
            let rounded: Vec<Aabb> =
                boxes.iter().map(|(min, max)| Aabb::from_f64(*min, *max, origin)).collect();
            let outcomes = play_alone(EXACT, core::slice::from_ref(&rounded));
            let mut overlaps = 0;
            for (a, (low, high)) in boxes.iter().enumerate() {
                // Outward, by no more than a step of f32.
                for k in 0..3 {
                    let (min, max) = (f64::from(rounded[a].min[k]), f64::from(rounded[a].max[k]));
                    assert!(min + origin[k] <= low[k] && high[k] <= max + origin[k], "{far} {origin:?}");
                    assert!(f64::from(rounded[a].min[k].next_up()) + origin[k] >= low[k]);
                }
                for (b, (other_low, other_high)) in boxes.iter().enumerate().skip(a + 1) {
                    if (0..3).all(|k| low[k] <= other_high[k] && other_low[k] <= high[k]) {
                        overlaps += 1;
                        assert!(outcomes[0].pairs.contains(&[a as u32, b as u32]), "{far}: {a} and {b}");
                    }
                }
            }
            assert!(overlaps >= 200, "each box touches its neighbour");
        }
    }
    // Beyond f32, and no numbers.
    let huge = Aabb::from_f64([-1e300; 3], [1e300; 3], [0.0; 3]);
    assert_eq!((huge.min, huge.max), ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]));
    let beyond = Aabb::from_f64([1e300; 3], [1e300; 3], [0.0; 3]);
    assert_eq!((beyond.min, beyond.max), ([f32::MAX; 3], [f32::INFINITY; 3]));
    assert!(!Aabb::from_f64([f64::NAN; 3], [0.0; 3], [0.0; 3]).is_valid());
    let unbounded = Aabb::from_f64([f64::NEG_INFINITY; 3], [f64::INFINITY; 3], [5.0; 3]);
    assert_eq!((unbounded.min, unbounded.max), ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]));
}

#[test]
fn fixed_point_finds_the_pairs_of_the_f32_path() {
    const FRACTION_BITS: u32 = 12;
    const UNIT: i32 = 1 << FRACTION_BITS;
    // Boxes of one to two units, and the bits of the range of their corners.
    for (count, bits) in [(40, 15), (200, 16), (900, 17), (200, 30)] {
        let mut rng = Rng::new(83);
        // Integers from the upper bits of floats: up to 24 of them, so that the lowest ones need numbers of their own.
        let mut below = |limit: i32| rng.point(0.0, 1.0).map(|x| (f64::from(x) * f64::from(limit)) as i32);
        // Beyond 24 bits the cubes grow too, or none would overlap.
        let size = UNIT.max(1 << (bits - 3));
        let mut boxes: Vec<[[i32; 3]; 2]> = (0..count)
            .map(|_| {
                let (min, lowest, extent) = (below(1 << bits), below(128), below(size));
                [[0, 1, 2].map(|k| (min[k] ^ lowest[k]) - (1 << (bits - 1))), extent]
            })
            .map(|[min, extent]| [min, [0, 1, 2].map(|k| min[k] + size + (extent[k] | 1))])
            .collect();
        let mut frames: Vec<Vec<[[i32; 3]; 2]>> = Vec::new();
        for _ in 0..6 {
            frames.push(boxes.clone());
            for corners in &mut boxes {
                let by = below(size / 2).map(|x| x - size / 4);
                *corners = corners.map(|corner| [0, 1, 2].map(|k| corner[k] + by[k]));
            }
        }
        let in_f32 = |x: i32| x as f32 / UNIT as f32;
        let in_f64 = |corner: [i32; 3]| corner.map(|x| f64::from(x) / f64::from(UNIT));
        let through = |make: &dyn Fn(&[[i32; 3]; 2]) -> Aabb| -> Vec<Vec<Aabb>> {
            frames.iter().map(|frame| frame.iter().map(make).collect()).collect()
        };
        let fixed = through(&|[min, max]| Aabb::from_fixed(*min, *max, FRACTION_BITS));
        let floats = if bits < 24 {
            through(&|[min, max]| Aabb::new(min.map(in_f32), max.map(in_f32)))
        } else {
            through(&|[min, max]| Aabb::from_f64(in_f64(*min), in_f64(*max), [0.0; 3]))
        };
        let outcomes = on_every_setup(EXACT, &fixed, &Jobs::USUAL);
        let expected = on_every_setup(EXACT, &floats, &Jobs::USUAL);
        let all = |of: &[Outcome]| -> Vec<[Vec<SlotPair>; 3]> {
            of.iter().map(|step| [&step.pairs, &step.found, &step.lost].map(|pairs| sorted(pairs))).collect()
        };
        assert_eq!(all(&outcomes), all(&expected), "{count} objects, {bits} bits");
        // And none of the integers' own overlaps is missing, nor, where nothing is rounded, is there another one.
        for (frame, outcome) in frames.iter().zip(&outcomes) {
            let mut overlaps = Vec::new();
            for (a, [low, high]) in frame.iter().enumerate() {
                for (b, [other_low, other_high]) in frame.iter().enumerate().skip(a + 1) {
                    if (0..3).all(|k| low[k] <= other_high[k] && other_low[k] <= high[k]) {
                        overlaps.push([a as u32, b as u32]);
                    }
                }
            }
            assert!(overlaps.len() > count / 4, "{} overlaps of {count}", overlaps.len());
            let pairs = sorted(&outcome.pairs);
            if bits < 24 {
                assert_eq!(pairs, overlaps);
            }
            assert!(overlaps.iter().all(|pair| pairs.binary_search(pair).is_ok()));
        }
    }
}

#[test]
fn slow_creep_inside_the_fat_box_is_filtered_tightly() {
    for (boxes, jobs) in
        [(scenes::uniform(400, 37), &Jobs::ALL[..]), (scenes::uniform(1500, 37), &Jobs::USUAL)]
    {
        let mut rng = Rng::new(38);
        let mut frames = vec![boxes];
        for _ in 0..10 {
            let mut next = frames[frames.len() - 1].clone();
            scenes::walk(&mut next, 300, 0.04, &mut rng);
            frames.push(next);
        }
        let outcomes = on_every_setup(with_margin(0.5).without_predicted_boxes(), &frames, jobs);
        let resting = &outcomes[1..];
        assert!(resting.iter().all(|outcome| outcome.stats.moved == 0), "nobody leaves so large a margin");
        assert!(resting.iter().any(|outcome| !outcome.found.is_empty()), "creeping made no pair");
        assert!(resting.iter().any(|outcome| !outcome.lost.is_empty()), "creeping broke no pair");
    }
}

#[test]
fn sizes_over_twelve_orders_of_magnitude() {
    let mut rng = Rng::new(39);
    let mut place = |_| {
        let scale = 10_f32.powi(rng.below(13) as i32 - 6);
        at(rng.point(-scale * 20.0, scale * 20.0), rng.point(0.5, 1.0).map(|x| x * scale))
    };
    let boxes: Vec<Aabb> = (0..2000).map(&mut place).collect();
    let mut frames = vec![boxes];
    for thousandths in [5, 1000] {
        let mut next = frames[frames.len() - 1].clone();
        scenes::walk(&mut next, thousandths, 0.5, &mut rng);
        frames.push(next);
    }
    let share = Margin { per_extent: 0.05, min: 0.0, max: 1e5 };
    for config in [EXACT, EXACT.with_margin(share), EXACT.with_margin(share).with_mode(Mode::Fat)] {
        for outcome in on_every_setup(config, &frames, &Jobs::USUAL) {
            assert!(outcome.stats.copies <= 16 * 2000, "copies are bounded: {:?}", outcome.stats);
        }
    }
    // One speck among giants, one giant among specks.
    let speck = |i: usize| at([i as f32 * 3e-6, 0.0, 0.0], [1e-6; 3]);
    let specks: Vec<Aabb> =
        (0..1200).map(|i| if i == 600 { at([-1e6; 3], [2e6; 3]) } else { speck(i) }).collect();
    let outcomes = on_every_setup(EXACT, &[specks], &Jobs::USUAL);
    assert_eq!(outcomes[0].pairs.len(), 1199);
    assert!(outcomes[0].stats.copies < 1200, "{:?}", outcomes[0].stats);
}

/// Everything overlaps: the count goes on where the buffer ends. (`tests/runs/src/bin/overflow.rs` counts beyond 32 bits.)
#[test]
fn everything_overlaps() {
    let count_only = |count: usize, setup: Setup| {
        let config = setup.configure(Config::new(ample(count, 1000)).with_events());
        let mut slab = Slab::new::<u32>(&config);
        let mut world: World<'_> = slab.world(&config);
        let boxes = scenes::identical(count);
        world.insert_many(Boxes::new(&boxes)).expect("room for all");
        let error = world.under(&setup).step().map(|step| step.pairs().len());
        let count = count as u64;
        let full = Error::PairsFull { needed: count * (count - 1) / 2, room: 1000 };
        assert_eq!(error, Err(full), "{setup:?}");
        assert_eq!(world.pairs().len(), 1000);
        assert!(world.pairs().iter().all(|[a, b]| a < b && u64::from(*b) < count));
        assert!(world.found().is_empty() && world.lost().is_empty());
        world.validate().expect("a valid world");
    };
    for setup in Setup::each(&Jobs::ALL) {
        count_only(300, setup);
        count_only(3000, setup);
    }
}

#[test]
fn an_id_reused_in_one_frame_is_another_object() {
    for count in [2, 1500] {
        for config in modes(0.1) {
            let mut boxes = scenes::uniform(count, 40);
            boxes[0] = cube(-5.0, -5.0, -5.0);
            boxes[1] = cube(-5.5, -5.5, -5.5);
            each_world(config, &boxes, &Jobs::USUAL, |world, ids, setup| {
                // The same box in the same slot: the pair is lost and found.
                world.remove(ids[1]);
                let again = world.insert(boxes[1]);
                assert_eq!((again.slot(), again.generation()), (ids[1].slot(), 2));
                assert_eq!(world.refuse(|w| w.set_aabb(ids[1], boxes[1])), Error::StaleId { id: ids[1] });
                let outcome = world.step(setup);
                assert!(outcome.lost.contains(&[0, 1]) && outcome.found.contains(&[0, 1]), "{setup:?}");
                // Removed, and another box in its slot.
                world.remove(again);
                let third = world.insert(cube(-50.0, 0.0, 0.0));
                assert_eq!(third.slot(), 1);
                let outcome = world.step(setup);
                assert_eq!((outcome.lost, outcome.found), (vec![[0, 1]], vec![]), "{setup:?}");
                // Inserted and removed between two steps: nobody saw it.
                let ghost = world.insert(boxes[0]);
                world.remove(ghost);
                let outcome = world.step(setup);
                assert!(outcome.lost.is_empty() && outcome.found.is_empty(), "{setup:?}");
                // All at once.
                let all = world.model().ids();
                world.remove_many(&all);
                world.insert_many(&boxes);
                world.step(setup);
                assert!(world.step(setup).found.is_empty());
            });
        }
    }
}

#[test]
fn none_one_two_and_as_many_as_fit() {
    for capacity in [0, 1, 2, 3, 600] {
        let boxes = scenes::uniform(capacity, 41);
        for setup in Setup::each(&Jobs::ALL) {
            let config = setup.configure(Config::new(ample(capacity, 4 * capacity)).with_events());
            let mut slab = Slab::new::<u16>(&config);
            let mut checked = Checked::<u16>::new(slab.world(&config));
            for _ in 0..2 {
                assert_eq!(checked.step(setup).pairs, NO_PAIRS);
                assert_eq!(checked.step_over(&[], setup).pairs, NO_PAIRS);
                checked.step_over(&[cube(0.0, 0.0, 0.0)], setup);
                let ids = checked.insert_many(&boxes);
                checked.step(setup);
                assert_eq!(
                    checked.refuse(|w| w.insert(cube(0.0, 0.0, 0.0))),
                    Error::ObjectsFull { needed: capacity as u64 + 1, room: capacity as u32 }
                );
                checked.step_over(&boxes, setup);
                checked.remove_many(&ids);
                checked.step(setup);
            }
        }
    }
}

#[test]
fn teleporting_all_objects_costs_no_square() {
    let frames: Vec<Vec<Aabb>> = (0..8).map(|seed| scenes::uniform(4000, 42 + seed)).collect();
    for config in modes(0.1) {
        for outcome in on_every_setup(config, &frames, &Jobs::USUAL) {
            assert!(outcome.stats.candidates < 4000 * 300, "{:?}", outcome.stats);
        }
    }
    // From one heap to another, so that every leaf empties and one takes all.
    let heap = |x: f32| scenes::uniform(1500, 43).iter().map(|b| shifted(b, [x, x, 0.0])).collect::<Vec<_>>();
    let frames: Vec<Vec<Aabb>> = (0..6).map(|i| heap(if i % 2 == 0 { 0.0 } else { 1e4 })).collect();
    on_every_setup(EXACT, &frames, &Jobs::ALL);
}

#[test]
fn swinging_between_leaves_makes_no_events() {
    // Pairs of cubes that stay together while they swing across the world; nobody meets anybody else.
    let frame = |i: usize| {
        let swing = if i.is_multiple_of(2) { 0.0 } else { 300.0 };
        let place = |n: usize| {
            let (pair, second) = (n / 2, n % 2);
            let by = if pair < 100 { swing } else { 0.0 };
            cube((pair % 30) as f32 * 10.0 + by, (pair / 30) as f32 * 10.0, 0.5 * second as f32)
        };
        (0..1800).map(place).collect::<Vec<_>>()
    };
    let frames: Vec<Vec<Aabb>> = (0..12).map(frame).collect();
    for config in [EXACT, with_margin(1.0)] {
        for outcome in &on_every_setup(config, &frames, &Jobs::ALL)[1..] {
            assert_eq!(outcome.pairs.len(), 900);
            assert!(outcome.found.is_empty() && outcome.lost.is_empty());
            assert_eq!(outcome.stats.moved, 200);
        }
    }
}

/// What counts up is generations (there are no step stamps): one slot through many lives, and many steps.
#[test]
fn counters_go_on_for_long() {
    let config = Config::new(ample(2, 2)).with_events();
    let mut slab = Slab::new::<u16>(&config);
    let mut world: World<'_, u16> = slab.world(&config);
    let unit = cube(0.0, 0.0, 0.0);
    world.insert(unit).expect("room");
    let mut old: Vec<Id> = Vec::new();
    for life in 1..200_000_u32 {
        let id = world.insert(unit).expect("room");
        assert_eq!((id.slot(), id.generation()), (1, life));
        if life.is_power_of_two() {
            old.push(id);
            let step = world.set_kernels(Setup::REFERENCE.kernels).on(&Jobs::Serial).step().expect("room");
            assert_eq!((step.pairs().len(), step.found().len()), (1, 1), "life {life}");
            assert!(old[..old.len() - 1].iter().all(|id| !world.contains(*id)));
        }
        world.remove(id).expect("it is alive");
        assert_eq!(world.remove(id), Err(Error::StaleId { id }));
    }
    for i in 0..100_000 {
        let step = world.set_kernels(Setup::REFERENCE.kernels).on(&Jobs::Serial).step().expect("room");
        assert!(step.pairs().is_empty() && step.lost().len() == usize::from(i == 0));
    }
    world.validate().expect("a valid world");
}

/// P1: exactly the closed overlaps, or a counted superset; each pair once, the lower slot first.
#[test]
fn p1_every_step_returns_the_overlaps() {
    for count in [100, 2200] {
        for (one, two) in scenes::all(count, 50).into_iter().zip(scenes::all(count, 51)) {
            let mut creeping = one.boxes.clone();
            scenes::walk(&mut creeping, 200, 0.02, &mut Rng::new(52));
            let mut few = creeping.clone();
            scenes::walk(&mut few, 4, 3.0, &mut Rng::new(53));
            let frames = [one.boxes, creeping, few, two.boxes];
            for config in modes(0.05) {
                // `Checked`, inside, compares every step with the model.
                on_every_setup(config, &frames, &Jobs::USUAL);
            }
        }
    }
}

/// P2: whatever comes in, no panic. (`allocation.rs` has the other half: no allocation.)
#[test]
fn p2_no_input_panics() {
    let odd = [
        f32::NAN,
        -f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
        -f32::from_bits(1),
        0.0,
        -0.0,
        1.0,
        -1.0,
        16_777_217.0,
    ];
    for setup in Setup::each(&Jobs::ALL) {
        for (config, count) in modes(0.1).into_iter().zip([40, 1300, 700]) {
            let survived = catch_unwind(AssertUnwindSafe(|| {
                let mut rng = Rng::new(60);
                let mut any =
                    || Aabb::new([(); 3].map(|()| odd[rng.below(14)]), [(); 3].map(|()| odd[rng.below(14)]));
                let config = setup.configure(config.with_capacity(ample(count, 500)).with_events());
                let mut slab = Slab::new::<u32>(&config);
                let mut world: World<'_> = slab.world(&config);
                for _ in 0..4 {
                    // One in eight is a box by chance.
                    for i in 0..8 * count {
                        let aabb = any();
                        if let Ok(id) = world.insert(aabb) {
                            let _ = world.set_aabb(id, any());
                            let _ = world.set_margin(id, odd[i % odd.len()]);
                        }
                        let _ = world.set_aabb(Id::from_bits((1 << 32) + i as u64).expect("an id"), any());
                    }
                    let bounds: Vec<Aabb> = (0..count + 10).map(|_| any()).collect();
                    let _ = world.under(&setup).step_over(Boxes::new(&bounds));
                    for slot in 0..count as u32 / 2 {
                        let _ = world.id_at(slot * 2).map(|id| world.remove(id));
                    }
                    let _ = world.under(&setup).step().map(|step| step.surplus());
                    world.validate().expect("a valid world");
                }
            }));
            assert!(survived.is_ok(), "{setup:?} {config:?}");
        }
    }
}

/// P3: the same bytes for the same calls, for any number of workers and any kernel.
#[test]
fn p3_the_same_calls_give_the_same_bytes() {
    let mut scene = Brownian::new(6000, 70);
    let mut frames = vec![scene.boxes().to_vec()];
    for _ in 0..4 {
        frames.push(scene.advance().to_vec());
    }
    let mut few = frames[4].clone();
    scenes::walk(&mut few, 6, 1.0, &mut Rng::new(71));
    frames.extend([few.clone(), few]);
    for config in modes(0.2) {
        let reference = transcript(config, &frames, Setup::REFERENCE);
        let jobs: Vec<Jobs> = Jobs::ALL.into_iter().chain([3, 5, 8, 32].map(Jobs::Threads)).collect();
        for setup in Setup::each(&jobs) {
            let again = transcript(config, &frames, setup);
            // Not assert_eq: that would print thousands of pairs.
            assert!(again == reference, "{setup:?} {config:?}");
        }
    }
}

/// P4: a full buffer is an error that says how much was needed, and the world goes on. (`capacity.rs` has every
/// size; this is the promise in short.)
#[test]
fn p4_a_full_buffer_is_an_error_that_says_the_need() {
    let boxes = scenes::uniform(1300, 80);
    let needed = expected(&boxes).len();
    for setup in Setup::each(&Jobs::ALL) {
        let config = setup.configure(Config::new(ample(1300, needed - 1)).with_events());
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        let ids = checked.insert_many(&boxes);
        assert_eq!(checked.refuse(|w| w.insert(boxes[0])), Error::ObjectsFull { needed: 1301, room: 1300 });
        let error = checked.try_step(setup).expect_err("one pair too many");
        assert_eq!(error, Error::PairsFull { needed: needed as u64, room: needed as u32 - 1 });
        let in_pair = checked.model().pairs()[0][0];
        checked.remove(ids[in_pair as usize]);
        let outcome = checked.step(setup);
        assert_eq!(outcome.found.len(), outcome.pairs.len(), "the first complete step finds everything");
    }
}

/// P5: a bad box harms only itself.
#[test]
fn p5_a_bad_box_harms_only_itself() {
    for count in [50, 1800] {
        for config in modes(0.05) {
            each_world(config, &scenes::uniform(count, 90), &Jobs::ALL, |world, ids, setup| {
                let mut next = scenes::uniform(count, 91);
                let bad = |i: usize| i % 7 == 3;
                for (i, aabb) in next.iter_mut().enumerate().filter(|(i, _)| bad(*i)) {
                    *aabb = spoilt(f32::NAN)[i % 6];
                }
                let outcome = world.step_over(&next, setup);
                let number = (0..count).filter(|i| bad(*i)).count() as u32;
                assert_eq!(outcome.rejected, Some(Rejected { first: ids[3], count: number }));
                // A dead slot's box is nobody's, good or bad.
                world.remove(ids[3]);
                let outcome = world.step_over(&next[..9], setup);
                assert_eq!(outcome.rejected, None);
            });
        }
    }
}

/// P6: the bytes of a world are the world: a copy that is reopened answers like the original, to the last byte.
#[test]
fn p6_a_copy_of_the_bytes_goes_on_like_the_original() {
    for count in [60, 1700] {
        for config in modes(0.1) {
            let mut rng = Rng::new(100);
            let mut frames = vec![scenes::uniform(count, 100)];
            for thousandths in [1000, 10, 0, 500, 10, 1000] {
                let mut next = frames[frames.len() - 1].clone();
                scenes::walk(&mut next, thousandths, 0.3, &mut rng);
                frames.push(next);
            }
            for setup in Setup::each(&Jobs::USUAL) {
                let config = setup.configure(config.with_capacity(ample(count, 20 * count)).with_events());
                let mut original = Slab::new::<u32>(&config);
                let mut model = {
                    let mut checked = Checked::<u32>::new(original.world(&config));
                    checked.insert_many(&frames[0]);
                    checked.into_model()
                };
                for (i, frame) in frames.iter().enumerate() {
                    let mut copy = original.clone();
                    let go_on = |slab: &mut Slab, model| {
                        let world = World::open(slab.bytes_mut()).expect("the world that was there");
                        assert_eq!(world.config(), config);
                        let mut checked = Checked::<u32>::resume(world, model);
                        let outcome = checked.step_over(frame, setup);
                        (outcome, checked.into_model())
                    };
                    let (copied, _) = go_on(&mut copy, model.clone());
                    let (outcome, next) = go_on(&mut original, model);
                    assert!(copied == outcome, "frame {i} {setup:?}");
                    // Threads share scratch memory as they come; without them every byte is the same.
                    assert!(
                        setup.jobs != Jobs::Serial || copy.bytes() == original.bytes(),
                        "frame {i} {setup:?}"
                    );
                    model = next;
                }
            }
        }
    }
}
