//! What the library chooses by counts, and what the caller may choose instead: the pairs are right either way, the statistics
//! say what was chosen and why, and fat boxes are there where they gain something.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use trisap_core::{Aabb, Config, Error, Margin, Mode, Path, Reason, Stats};
use trisap_tests::checked::{Checked, Outcome, expected};
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::play::{assert_identical, on_every_setup};
use trisap_tests::scenes::{self, Rng, shifted};
use trisap_tests::sorted;
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

/// Kinds of steps are those of boxes as given.
const PLAIN: Config = Config::new(ample(0, 0)).without_predicted_boxes();

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
    let many = routes(&stats(PLAIN.with_movers_only(Always), 120));
    assert!(many[1..].iter().all(|route| [MOVERS, (Path::Full, Reason::NoRoom)].contains(route)), "{many:?}");
    assert!(many.contains(&MOVERS), "{many:?}");
}

#[test]
fn other_reasons_have_their_names() {
    let config =
        Config::new(ample(COUNT, 400 * COUNT)).with_fine_leaves(Choice::Never).without_predicted_boxes();
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

/// Boxes that go on in directions of their own, by so much of their side in each frame, and shiver a little.
fn drift(by: f32, steps: usize) -> Vec<Vec<Aabb>> {
    going(by, 0.001, steps)
}

fn going(by: f32, shiver: f32, steps: usize) -> Vec<Vec<Aabb>> {
    let mut rng = Rng::new(5);
    let mut boxes = scenes::uniform(COUNT, 4);
    let ways: Vec<_> = boxes.iter().map(|_| rng.in_ball()).collect();
    let mut frames = vec![boxes.clone()];
    for _ in 0..steps {
        for (aabb, way) in boxes.iter_mut().zip(&ways) {
            let shiver = rng.point(-shiver, shiver);
            *aabb = shifted(aabb, [0, 1, 2].map(|k| by * way[k] + shiver[k]));
        }
        frames.push(boxes.clone());
    }
    frames
}

/// Steps in which nobody left a fat box.
fn quiet(outcomes: &[Outcome]) -> usize {
    outcomes.iter().filter(|outcome| outcome.stats.path == Path::Unchanged).count()
}

#[test]
fn predicted_boxes_hold_what_goes_on_for_some_steps() {
    let plain = Config::new(ample(COUNT, 20 * COUNT));
    for config in [plain, plain.with_events()] {
        let frames = drift(0.02, 24);
        let predicted = on_every_setup(config, &frames, &Jobs::USUAL);
        // Some objects try them in the first steps. Then they are made anew about every eighth step, in the step in which many
        // would leave theirs.
        let steps = quiet(&predicted);
        assert!(steps >= 17, "{steps} quiet steps of 24");
        let grown = config.without_predicted_boxes().with_margin(Margin::length(0.1));
        let grown = on_every_setup(grown, &frames, &Jobs::USUAL);
        assert!(quiet(&grown) < steps, "{} of grown boxes, {steps} of predicted ones", quiet(&grown));
    }
}

/// Quiet steps keep no boxes for events. Where some leave predicted boxes that the sample before the step does not see, or many
/// do, events are right all the same.
#[test]
fn events_are_right_where_no_boxes_are_kept() {
    for (leavers, path) in [(60, Path::Movers), (COUNT, Path::Full)] {
        let mut frames = drift(0.02, 16);
        let mut rng = Rng::new(3);
        // The sample is one in 78, and some places behind.
        for at in (0..leavers).filter(|at| (10..70).contains(&(at % 78))) {
            let way = rng.in_ball();
            frames[12..].iter_mut().for_each(|boxes| boxes[at] = shifted(&boxes[at], way));
        }
        let outcomes = on_every_setup(Config::new(ample(0, 0)), &frames, &Jobs::USUAL);
        assert_eq!(outcomes[12].stats.path, path, "{leavers}");
    }
}

/// A world that reports boxes with margins sweeps predicted boxes around these.
#[test]
fn predicted_boxes_hold_boxes_with_margins_for_some_steps() {
    let fat =
        Config::new(ample(COUNT, 20 * COUNT)).with_mode(Mode::Fat).with_margin(Margin::length(MARGIN / 4.0));
    for config in [fat, fat.with_events()] {
        let frames = drift(0.02, 48);
        let steps = quiet(&on_every_setup(config, &frames, &Jobs::USUAL)[24..]);
        assert!(steps >= 16, "{steps} quiet steps of 25");
        let without = quiet(&on_every_setup(config.without_predicted_boxes(), &frames, &Jobs::USUAL)[24..]);
        assert!(without < steps, "{without} quiet steps of 25 without, {steps} with");
    }
}

/// Whether every two of some boxes that overlap are reported, and no two that are apart by more than twice their margins.
fn assert_in_margins(frame: &[Aabb], outcome: &Outcome, step: usize) {
    let pairs = sorted(&outcome.pairs);
    let grown: Vec<_> = frame.iter().map(|aabb| grown(aabb, 2.0 * MARGIN)).collect();
    for pair in expected(frame) {
        assert!(pairs.binary_search(&pair).is_ok(), "step {step}: {pair:?} is missing");
    }
    for [a, b] in pairs {
        assert!(grown[a as usize].overlaps(&grown[b as usize]), "step {step}: {a} and {b} are apart");
    }
}

fn grown(aabb: &Aabb, by: f32) -> Aabb {
    Aabb::new(aabb.min.map(|x| x - by), aabb.max.map(|x| x + by))
}

/// What they sweep changes nothing: a box with its margin stays until the box leaves it, where few do.
#[test]
fn fat_worlds_report_the_overlaps_of_boxes_with_margins() {
    let fat = Config::new(ample(COUNT, 40 * COUNT)).with_mode(Mode::Fat).with_margin(Margin::length(MARGIN));
    for frames in [drift(0.02, 40), drift(0.2, 24), going(0.0, 0.7, 20), going(0.01, 0.1, 24)] {
        for (step, (frame, outcome)) in
            frames.iter().zip(on_every_setup(fat, &frames, &[Jobs::Serial])).enumerate()
        {
            assert_in_margins(frame, &outcome, step);
        }
        // One in 32 moves.
        let few: Vec<Vec<Aabb>> = (frames.iter())
            .map(|frame| (0..COUNT).map(|at| if at % 32 == 5 { frame[at] } else { frames[0][at] }).collect())
            .collect();
        let mut reported = vec![Aabb::new([f32::MAX; 3], [f32::MAX; 3]); COUNT];
        for (step, (frame, outcome)) in few.iter().zip(on_every_setup(fat, &few, &[Jobs::Serial])).enumerate()
        {
            for (reported, aabb) in reported.iter_mut().zip(frame) {
                if (0..3).any(|k| aabb.min[k] < reported.min[k] || aabb.max[k] > reported.max[k]) {
                    *reported = grown(aabb, MARGIN);
                }
            }
            assert_eq!(sorted(&outcome.pairs), expected(&reported), "step {step}");
        }
    }
}

/// Where many leave theirs, all get new ones, so that they are left in the same steps and most steps are quiet.
#[test]
fn boxes_that_are_reported_are_made_anew_together() {
    let fat = Config::new(ample(COUNT, 40 * COUNT)).with_mode(Mode::Fat).with_margin(Margin::length(MARGIN));
    let fat = fat.without_predicted_boxes();
    for config in [fat, fat.with_events()] {
        let frames = drift(MARGIN / 10.0, 60);
        let steps = quiet(&on_every_setup(config, &frames, &Jobs::USUAL)[20..]);
        assert!(steps >= 24, "{steps} quiet steps of 41");
    }
}

/// Boxes that the caller's array has for resting objects are not theirs, so nobody leaves a box by these.
#[test]
fn boxes_of_a_pool_that_rests_renew_nothing() {
    let fat = Config::new(ample(COUNT, 40 * COUNT)).with_mode(Mode::Fat).with_margin(Margin::length(MARGIN));
    for config in [fat, fat.without_predicted_boxes(), fat.with_mode(Mode::Exact)] {
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let frames = drift(MARGIN / 200.0, 40);
        let ids = world.insert_many(&frames[0]);
        world.set_resting(&ids[..COUNT / 2]);
        let mut quiet = 0;
        for frame in &frames {
            let mut boxes = frame.clone();
            boxes[..COUNT / 2].fill(Aabb::new([1e3; 3], [1e3; 3]));
            world.step_over(&boxes, Setup::REFERENCE);
            quiet += usize::from(world.world().stats().path == Path::Unchanged);
        }
        assert!(quiet >= 30, "{quiet} quiet steps of 41");
    }
}

/// Their boxes are several times as large, and most steps are quiet all the same.
#[test]
fn predicted_boxes_hold_what_goes_on_far() {
    let config = Config::new(ample(COUNT, 20 * COUNT));
    for config in [config, config.with_events()] {
        let steps = quiet(&on_every_setup(config, &drift(0.2, 24), &Jobs::USUAL));
        assert!(steps >= 16, "{steps} quiet steps of 24");
    }
}

#[test]
fn predicted_boxes_are_left_unused_where_all_move_far() {
    let config = Config::new(ample(COUNT, 20 * COUNT));
    for config in [config, config.with_events()] {
        let outcomes = on_every_setup(config, &going(0.0, 0.7, 20), &Jobs::USUAL);
        let used = outcomes.iter().filter(|outcome| outcome.stats.surplus > 0).count();
        assert!(used <= if config.events { 1 } else { 2 }, "in use in {used} steps");
    }
}

#[test]
fn a_teleport_predicts_nothing() {
    let config = Config::new(ample(COUNT, 20 * COUNT)).with_events();
    let mut frames = drift(0.01, 12);
    for frame in frames.iter_mut().skip(6) {
        for aabb in frame.iter_mut().step_by(100) {
            *aabb = shifted(aabb, [40.0, -40.0, 40.0]);
        }
    }
    let outcomes = on_every_setup(config, &frames, &Jobs::USUAL);
    let surplus: Vec<_> = outcomes.iter().map(|outcome| outcome.stats.surplus).collect();
    assert!(surplus[6] <= surplus[5] + 200, "{surplus:?}");
}

/// Boxes that are large for one frame leave no large boxes behind, in which small ones would stay for ever.
#[test]
fn large_boxes_of_one_frame_are_forgotten() {
    let config = Config::new(ample(COUNT, 300 * COUNT));
    for config in [config, config.with_events()] {
        let mut frames = drift(0.01, 16);
        for aabb in &mut frames[5] {
            *aabb = Aabb::new(aabb.min.map(|x| x - 4.0), aabb.max.map(|x| x + 4.0));
        }
        let outcomes = on_every_setup(config, &frames, &Jobs::USUAL);
        let surplus: Vec<_> = outcomes.iter().map(|outcome| outcome.stats.surplus).collect();
        assert!(surplus[8..].iter().all(|surplus| *surplus < 2 * COUNT as u64), "{surplus:?}");
    }
    // One that is given by itself.
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let boxes = scenes::uniform(COUNT, 4);
    let ids = world.insert_many(&boxes);
    world.step(Setup::REFERENCE);
    for aabb in [Aabb::new([-1e3; 3], [1e3; 3]), boxes[7]] {
        world.set(ids[7], aabb);
        world.step(Setup::REFERENCE);
    }
    assert!(world.world().stats().surplus < COUNT as u64 / 10, "{:?}", world.world().stats());
    // One that shrinks little by little.
    let config = config.with_margin(Margin::length(0.1));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let ids = world.insert_many(&boxes);
    world.step(Setup::REFERENCE);
    let mut half = 1e3;
    while half > 0.5 {
        world.set(ids[7], Aabb::new([-half; 3], [half; 3]));
        world.step(Setup::REFERENCE);
        half *= 0.7;
    }
    assert!(world.world().stats().surplus < COUNT as u64 / 2, "{:?}", world.world().stats());
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

/// What happens beside or between quiet steps, of which the next one keeps no boxes of before.
#[derive(Clone, Copy, Debug)]
enum Meanwhile {
    /// The rule panics, and the step is done once more.
    Panic,
    /// The origin moves.
    Shift,
    /// The world is saved and loaded.
    Load,
    /// It goes on in a copy, with more room.
    Growth,
    /// There is no room for all pairs in that step.
    Full,
}

/// Events are right where a quiet world is interrupted before a step in which some leave their predicted boxes.
#[test]
fn events_are_right_where_quiet_steps_are_interrupted() {
    use Meanwhile::{Full, Growth, Load, Panic, Shift};
    let mut frames = drift(0.02, 34);
    let mut rng = Rng::new(3);
    // The sample is one in 78, and some places behind.
    for (nth, at) in (0..900).filter(|at| (10..70).contains(&(at % 78))).enumerate() {
        let way = rng.in_ball();
        frames[14 + 6 * (nth % 3)..].iter_mut().for_each(|boxes| boxes[at] = shifted(&boxes[at], way));
    }
    let most = frames.iter().map(|frame| expected(frame).len()).max().unwrap_or(0);
    for meanwhile in [Panic, Shift, Load, Growth, Full] {
        let config = Config::new(ample(COUNT, 40 * COUNT)).with_events().with_filters();
        let larger = config.with_capacity(ample(COUNT + 1, 50 * COUNT));
        let mut slabs = [&config, &larger].map(Slab::new::<u32>);
        let [slab, grown] = &mut slabs;
        let mut checked = Checked::<u32>::new(slab.world(&config));
        checked.rule();
        checked.insert_many(&frames[0]);
        let (mut moved_by, mut quiet, mut room) = ([0.0; 3], 0, Some(grown));
        for (step, frame) in frames.iter().enumerate() {
            let interrupted = step >= 12 && step % 6 == 2;
            let mut boxes: Vec<Aabb> = frame.iter().map(|aabb| shifted(aabb, moved_by)).collect();
            match meanwhile {
                _ if !interrupted => {}
                Panic => {
                    let (world, model) = checked.parts_mut();
                    let rule =
                        |a, b| if a % 5 == 0 { resume_unwind(Box::new("a rule")) } else { model.agree(a, b) };
                    let step = || world.with_rule(&rule).step_over(&boxes).map(|_| ());
                    assert!(catch_unwind(AssertUnwindSafe(step)).is_err(), "nobody asked the rule");
                    checked.model_mut().fail();
                    // All boxes were taken in.
                    let ids = checked.model().ids();
                    ids.iter().for_each(|id| checked.model_mut().set(*id, boxes[id.slot() as usize]));
                }
                Shift => {
                    checked.world_mut().shift_origin([0.5, -1.0, 2.0]).expect("finite");
                    for id in checked.model().ids() {
                        let aabb = checked.world().aabb(id).expect("alive");
                        checked.model_mut().shift(id, aabb);
                    }
                    moved_by = [0, 1, 2].map(|k| moved_by[k] - [0.5, -1.0, 2.0][k]);
                    boxes = frame.iter().map(|aabb| shifted(aabb, moved_by)).collect();
                }
                Load => {
                    let saved = checked.save();
                    checked.load(&saved);
                }
                Growth => {
                    if let Some(grown) = room.take() {
                        let world = checked.world().move_into(grown.bytes_mut(), &larger).expect("more room");
                        checked = Checked::resume(world, checked.into_model());
                    }
                }
                Full => {
                    // All in one place, for that step alone.
                    let heap: Vec<Aabb> = boxes.iter().map(|_| boxes[0]).collect();
                    let error = checked.try_step_over(&heap, Setup::REFERENCE).err();
                    assert!(matches!(error, Some(Error::PairsFull { .. })), "{most} pairs fit: {error:?}");
                }
            }
            let outcome = checked.step_over(&boxes, Setup::REFERENCE);
            quiet += usize::from(outcome.stats.path == Path::Unchanged);
        }
        assert!(quiet >= 8, "{quiet} quiet steps, {meanwhile:?}");
    }
}
