//! What the library chooses by counts, and what the caller may choose instead: the pairs are right either way, the statistics
//! say what was chosen and why, and margins go to those that gain by them.

use trisap_core::{Aabb, Choice, Config, Margin, Mode, Path, Reason, Stats};
use trisap_tests::checked::{Checked, Outcome, expected};
use trisap_tests::jobs::Jobs;
use trisap_tests::play::{assert_identical, on_every_setup, play};
use trisap_tests::scenes::{self, Rng, cube, on_x, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};

const COUNT: usize = 5000;

/// Frames in which so many thousandths of all boxes go to a place nearby.
fn frames(thousandths: usize, steps: usize) -> Vec<Vec<Aabb>> {
    let mut boxes = scenes::uniform(COUNT, 4);
    let mut rng = Rng::new(9);
    let mut frames = vec![boxes.clone()];
    for _ in 0..steps {
        scenes::walk(&mut boxes, thousandths, 0.4, &mut rng);
        frames.push(boxes.clone());
    }
    frames
}

/// The statistics of all steps, of which every pair is compared with the model's, and every byte between kernels and job
/// systems.
fn stats(config: Config, thousandths: usize) -> Vec<Stats> {
    let outcomes = on_every_setup(config, &frames(thousandths, 4), &Jobs::USUAL);
    outcomes.iter().map(|outcome| outcome.stats).collect()
}

const PLAIN: Config = Config::new(ample(0, 0));

fn routes(stats: &[Stats]) -> Vec<(Path, Reason)> {
    stats.iter().map(|stats| (stats.path, stats.reason)).collect()
}

#[test]
fn the_number_of_movers_chooses_the_path_or_the_caller_does() {
    use Choice::{Always, Automatic, Never};
    const FIRST: (Path, Reason) = (Path::Rebuilt, Reason::NothingKept);
    const STILL: (Path, Reason) = (Path::Unchanged, Reason::NoMovers);
    const MOVERS: (Path, Reason) = (Path::Movers, Reason::Fixed);
    const FULL: (Path, Reason) = (Path::Full, Reason::Fixed);
    for (choice, thousandths, later) in [
        (Automatic, 0, STILL),
        (Automatic, 20, (Path::Movers, Reason::FewMovers)),
        (Automatic, 900, (Path::Full, Reason::ManyMovers)),
        (Never, 0, FULL),
        (Never, 20, FULL),
        (Never, 300, FULL),
        (Always, 0, STILL),
        (Always, 20, MOVERS),
    ] {
        let stats = stats(PLAIN.with_movers_only(choice), thousandths);
        assert_eq!(routes(&stats), [FIRST, later, later, later, later], "{choice:?}, {thousandths}");
    }
    // With many movers a leaf and its neighbours may be full in the end, and the leaves have to be filled anew.
    let many = routes(&stats(PLAIN.with_movers_only(Always), 300));
    assert!(many[1..].iter().all(|route| [MOVERS, (Path::Full, Reason::NoRoom)].contains(route)), "{many:?}");
    assert!(many.contains(&MOVERS), "{many:?}");
}

#[test]
fn other_reasons_have_their_names() {
    let config = Config::new(ample(COUNT, 400 * COUNT)).with_fine_leaves(Choice::Never);
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let setup = Setup::REFERENCE;
    let route = |outcome: Outcome| (outcome.stats.path, outcome.stats.reason);
    let lean = on_every_setup(PLAIN.with_lean(), &[scenes::uniform(100, 1)], &Jobs::USUAL);
    assert_eq!(lean.into_iter().map(route).collect::<Vec<_>>(), [(Path::Lists, Reason::FewObjects)]);
    world.insert_many(&scenes::uniform(100, 1));
    assert_eq!(route(world.step(setup)), (Path::Rebuilt, Reason::NothingKept));
    // Leaves are divided where they stand.
    world.insert_many(&scenes::uniform(900, 2));
    assert_eq!(route(world.step(setup)), (Path::Full, Reason::ManyMovers));
    world.insert_many(&scenes::uniform(3000, 3));
    assert_eq!(route(world.step(setup)), (Path::Full, Reason::ManyMovers));
    assert_eq!(world.world().stats().rebalanced, 4000);
    // All in one corner.
    let boxes: Vec<Aabb> = world
        .model()
        .boxes()
        .iter()
        .flatten()
        .map(|b| scenes::at(b.min.map(|x| x / 50.0), [0.01; 3]))
        .collect();
    assert_eq!(route(world.step_over(&boxes, setup)), (Path::Full, Reason::ManyMovers));
    assert_eq!(route(world.step_over(&boxes, setup)), (Path::Unchanged, Reason::NoMovers));
    // Objects go into one leaf, few in each step: its neighbours make room, but not for too many.
    let mut crowded = boxes.clone();
    let mut crowd = |count: usize| {
        for (at, aabb) in crowded[..count].iter_mut().enumerate() {
            // Side by side, since many pairs would be a reason for steps of another kind.
            *aabb = scenes::at(boxes[3990].min.map(|x| x + at as f32 * 1e-6), [5e-7; 3]);
        }
        route(world.step_over(&crowded, setup))
    };
    assert_eq!([50, 100].map(&mut crowd), [(Path::Movers, Reason::FewMovers); 2]);
    assert_eq!(
        [440, 680, 900]
            .map(&mut crowd)
            .iter()
            .filter(|route| **route == (Path::Full, Reason::NoRoom))
            .count(),
        1
    );
}

#[test]
fn leaves_are_fine_when_it_is_calm_or_as_the_caller_has_it() {
    let fine = |choice, thousandths| {
        let stats = stats(PLAIN.with_fine_leaves(choice), thousandths);
        let leaves = stats.iter().map(|stats| stats.leaves).max().unwrap_or_default();
        assert_eq!(stats.iter().any(|stats| stats.fine_leaves), leaves > stats[0].leaves);
        stats.iter().map(|stats| stats.fine_leaves).collect::<Vec<_>>()
    };
    assert_eq!(fine(Choice::Automatic, 10), [false, false, true, true, true]);
    assert_eq!(fine(Choice::Always, 10), [false, true, true, true, true]);
    assert_eq!(fine(Choice::Never, 10), [false; 5]);
    // Full steps need the other leaves.
    assert_eq!(fine(Choice::Always, 300), [false; 5]);
}

#[test]
fn steps_are_shared_from_some_thousand_objects_on_or_as_the_caller_has_it() {
    let shared = |count: usize, choice| {
        let frames = [scenes::uniform(count, 3), scenes::uniform(count, 4)];
        let outcomes = on_every_setup(PLAIN.with_sharing(choice), &frames, &Jobs::USUAL);
        assert_eq!(outcomes[0].stats.shared, outcomes[1].stats.shared);
        outcomes[0].stats.shared
    };
    for (count, automatic) in [(60, false), (4000, false), (5000, true)] {
        assert_eq!(shared(count, Choice::Automatic), automatic, "{count}");
        assert!(!shared(count, Choice::Never));
        assert_eq!(shared(count, Choice::Always), count > 64, "{count}");
    }
}

#[test]
fn a_world_knows_its_choices_when_it_is_opened_again() {
    let all = [Choice::Automatic, Choice::Never, Choice::Always];
    for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|order| order.map(|at| all[at])) {
        let config = Config::new(ample(10, 10)).with_movers_only(a).with_fine_leaves(b).with_sharing(c);
        for config in [config, config.with_margin(Margin::share(0.5)).with_fixed_margins()] {
            let mut slab = Slab::new::<u32>(&config);
            slab.world::<u32>(&config);
            let world = trisap_core::World::<u32>::open(slab.bytes_mut()).expect("it was made just now");
            assert_eq!(world.config(), config);
        }
    }
}

const MARGIN: f32 = 0.2;

/// Boxes in a row that go along x by so much in each frame.
fn convoy(by: f32, frames: usize) -> Vec<Vec<Aabb>> {
    (0..frames).map(|frame| (0..40).map(|i| cube(by * frame as f32, 1.1 * i as f32, 0.0)).collect()).collect()
}

#[test]
fn who_outruns_a_margin_has_none() {
    let fat = PLAIN.with_margin(Margin::length(MARGIN)).with_mode(Mode::Fat);
    // Neighbours are 0.1 apart: they meet where both have their margins.
    let slow = play(fat, &convoy(0.15, 6));
    assert!(slow.iter().all(|outcome| outcome.surplus == 39 && outcome.stats.outran == 0));
    let fast = play(fat, &convoy(0.25, 6));
    assert_eq!(fast[0].surplus, 39, "nothing is known of the first frame");
    for outcome in &fast[1..] {
        assert_eq!((outcome.surplus, outcome.stats.moved, outcome.stats.outran), (0, 40, 40));
    }
    let fixed = play(fat.with_fixed_margins(), &convoy(0.25, 6));
    assert!(fixed.iter().all(|outcome| outcome.surplus == 39 && outcome.stats.outran == 0));
    // The exact mode has other candidates, but no other pairs.
    let exact = play(fat.with_mode(Mode::Exact), &convoy(0.25, 6));
    assert!(exact[1..].iter().all(|outcome| outcome.stats.surplus == 0 && outcome.pairs.is_empty()));
}

#[test]
fn who_slows_down_has_a_margin_again() {
    let places = [0.0, 1.0, 2.0, 2.1, 2.15, 2.2, 2.2, 3.2, 3.2, 3.3];
    let frames: Vec<Vec<Aabb>> = places.iter().map(|&x| vec![on_x(x, x + 1.0)]).collect();
    let outcomes = play(PLAIN.with_margin(Margin::length(MARGIN)).with_mode(Mode::Fat), &frames);
    let told = outcomes.iter().map(|outcome| (outcome.stats.moved, outcome.stats.outran));
    let expected = [(1, 0), (1, 1), (1, 1), (1, 0), (0, 0), (0, 0), (0, 0), (1, 1), (0, 0), (1, 0)];
    assert!(told.eq(expected), "{outcomes:?}");
}

#[test]
fn who_has_shrunk_has_a_smaller_fat_box() {
    let fat = PLAIN.with_margin(Margin::length(MARGIN)).with_mode(Mode::Fat);
    let frames = [10.0, 9.9, 9.5, 5.0, 1.0, 1.0].map(|edge| vec![on_x(0.0, edge), on_x(10.1, 11.0)]);
    let surplus = |config| play(config, &frames).iter().map(|outcome| outcome.surplus).collect::<Vec<_>>();
    assert_eq!(surplus(fat), [1, 1, 1, 0, 0, 0]);
    assert_eq!(surplus(fat.with_fixed_margins()), [1; 6]);
    // A box that creeps, however it turns, is left alone: so much smaller it must be.
    let turning = [1.0, 1.2, 1.4, 1.2, 1.0, 1.2_f32].map(|edge| vec![on_x(0.0, edge)]);
    let moved: Vec<_> = play(fat, &turning).iter().map(|outcome| outcome.stats.moved).collect();
    assert_eq!(moved, [1, 0, 1, 0, 0, 0]);
}

/// Slow and fast objects of many sizes, of which some change their pace: with margins that adapt, every pair is reported
/// (the checks see to that), fewer are that do not overlap, and not many more objects count as moved.
#[test]
fn margins_that_adapt_lose_nothing_and_report_less_surplus() {
    for seed in 1..4 {
        let mut rng = Rng::new(seed);
        let mut boxes: Vec<Aabb> =
            scenes::uniform(3000, seed).iter().map(|b| scenes::at(b.min, rng.point(0.2, 1.5))).collect();
        let mut pace: Vec<f32> = (0..boxes.len()).map(|_| rng.between(0.0, 3.0 * MARGIN)).collect();
        let mut frames = vec![boxes.clone()];
        for _ in 0..6 {
            for (aabb, pace) in boxes.iter_mut().zip(&mut pace) {
                if rng.once_in(10) {
                    *pace = rng.between(0.0, 3.0 * MARGIN);
                }
                *aabb = shifted(aabb, rng.in_ball().map(|x| x * *pace));
            }
            frames.push(boxes.clone());
        }
        let margin = PLAIN.with_margin(Margin::length(MARGIN));
        let truth: Vec<_> = frames.iter().map(|frame| expected(frame).len() as u64).collect();
        for mode in [Mode::Exact, Mode::Fat] {
            let adapting = on_every_setup(margin.with_mode(mode), &frames, &Jobs::USUAL);
            let fixed = on_every_setup(margin.with_mode(mode).with_fixed_margins(), &frames, &Jobs::USUAL);
            for ((adapting, fixed), truth) in adapting.iter().zip(&fixed).zip(&truth).skip(1) {
                let surplus = |outcome: &Outcome| outcome.surplus + outcome.stats.surplus;
                assert_eq!(adapting.stats.pairs - adapting.surplus, *truth);
                assert!(5 * surplus(adapting) < 4 * surplus(fixed), "{adapting:?} {fixed:?}");
                assert_eq!(fixed.stats.outran, 0);
                // After three steps of so many movers an exact world leaves its margins unused.
                if mode == Mode::Exact && surplus(adapting) == 0 {
                    continue;
                }
                assert!(adapting.stats.outran > 0);
                // These turn round at any time; now and then one comes back to where it would have had a margin.
                assert!(4 * adapting.stats.moved < 5 * fixed.stats.moved, "{adapting:?} {fixed:?}");
            }
        }
    }
}

#[test]
fn a_run_with_other_choices_is_repeated_byte_for_byte() {
    let config = PLAIN
        .with_margin(Margin::length(MARGIN))
        .with_movers_only(Choice::Always)
        .with_fine_leaves(Choice::Always)
        .with_sharing(Choice::Always);
    let frames = frames(100, 5);
    let first = on_every_setup(config, &frames, &Jobs::USUAL);
    assert_identical(&on_every_setup(config, &frames, &Jobs::USUAL), &first, Setup::REFERENCE);
}
