//! The caller's code panics inside of a call, the caller catches that and goes on: what the next calls say is
//! right.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread;
use trisap_core::{
    Aabb, Boxes, Config, Error, Executor, Filter, Id, Kernels, Margin, Mode, Path, Region, Stage,
};
use trisap_tests::checked::{Checked, Outcome};
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::scenes::{self, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};

/// Burns down by one each time that the world calls the caller's code; at the end that code panics, once.
struct Fuse(AtomicU32);

impl Fuse {
    fn burn(&self) {
        if self.0.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1)) == Ok(1) {
            // Unlike `panic!`, this does not write a message for each.
            resume_unwind(Box::new("the caller's own"));
        }
    }
}

/// Starts threads. It panics where it is asked for them and between its calls, and so do workers before and after theirs.
struct Fused<'f> {
    workers: u32,
    fuse: &'f Fuse,
}

impl Executor for Fused<'_> {
    fn workers(&self) -> u32 {
        self.fuse.burn();
        self.workers
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.fuse.burn();
        let work = || {
            self.fuse.burn();
            job();
            self.fuse.burn();
        };
        thread::scope(|scope| {
            let workers: Vec<_> = (0..width).map(|_| scope.spawn(work)).collect();
            let ends = workers.into_iter().map(thread::ScopedJoinHandle::join);
            // All have ended before the first panic goes on.
            if let Some(panic) = ends.collect::<Vec<_>>().into_iter().find_map(Result::err) {
                resume_unwind(panic);
            }
        });
        self.fuse.burn();
    }

    fn enter(&self, stage: Stage) {
        // Where a step is done, it is complete.
        if stage != Stage::Done {
            self.fuse.burn();
        }
    }
}

/// A step that may panic: what it said, or `None`.
fn fused_step(
    checked: &mut Checked<'_>,
    boxes: Option<&[Aabb]>,
    workers: u32,
    calls: u32,
) -> Option<Result<Outcome, Error>> {
    let fuse = Fuse(AtomicU32::new(calls));
    let executor = Fused { workers, fuse: &fuse };
    let (world, model) = checked.parts_mut();
    let rule = |a, b| {
        fuse.burn();
        model.agree(a, b)
    };
    let mut step = || {
        let mut stepper = world.set_kernels(Kernels::BASELINE).on(&executor);
        if model.has_rule() {
            stepper = stepper.with_rule(&rule);
        }
        let step = match boxes {
            Some(boxes) => stepper.step_over(Boxes::new(boxes)),
            None => stepper.step(),
        };
        step.map(|step| Outcome::of(&step))
    };
    catch_unwind(AssertUnwindSafe(&mut step)).ok()
}

/// Which objects move in a step, in thousandths.
const SHARES: [usize; 4] = [4, 40, 333, 1000];

/// Plays frames of which most panic once or several times in a row, each compared with brute force.
fn play(config: Config, count: usize, workers: u32, frames: usize, seed: u64) {
    let config = config.with_capacity(ample(count, 8 * count)).with_workers(workers);
    let mut rng = Rng::new(seed);
    let mut slab = Slab::new::<u32>(&config);
    let mut checked = Checked::<u32>::new(slab.world(&config));
    checked.insert_many(&scenes::uniform(count - 8, seed));
    if config.filters {
        checked.rule();
    }
    let (mut panics, mut paths) = (0, [0; 6]);
    for frame in 0..frames {
        let share = SHARES[(frame / 8 + rng.below(2)) % SHARES.len()];
        // At each slot the box that its object gets.
        let mut boxes: Vec<Aabb> =
            checked.model().boxes().iter().map(|aabb| aabb.unwrap_or_default()).collect();
        scenes::walk(&mut boxes, share, 1.0, &mut rng);
        let over = rng.once_in(2);
        let mut tries = rng.below(4);
        loop {
            if rng.once_in(3) {
                change(&mut checked, &mut rng);
                boxes.resize(checked.model().boxes().len(), Aabb::default());
                for (to, aabb) in boxes.iter_mut().zip(checked.model().boxes()) {
                    *to = aabb.filter(|_| rng.once_in(2)).unwrap_or(*to);
                }
            }
            if !over {
                for id in checked.model().ids() {
                    let aabb = boxes[id.slot() as usize];
                    if checked.world().aabb(id) != Some(aabb) {
                        let (world, _) = checked.parts_mut();
                        world.set_aabb(id, aabb).expect("it lives");
                        checked.model_mut().set(id, aabb);
                    }
                }
            }
            let most = [3, 8, 60, 2000][rng.below(4)];
            let calls = if tries == 0 { 0 } else { 1 + rng.below(most) as u32 };
            tries = tries.saturating_sub(1);
            let said = fused_step(&mut checked, over.then_some(&boxes[..]), workers, calls);
            // Some boxes may have been taken in before the panic.
            for id in checked.model().ids() {
                let known = checked.world().aabb(id).expect("it lives");
                let given = boxes[id.slot() as usize];
                let old = checked.model().boxes()[id.slot() as usize];
                assert!(known == given || said.is_none() && Some(known) == old, "the box of {id}");
                checked.model_mut().set(id, known);
            }
            if let Some(said) = said {
                if let Ok(outcome) = checked.settle(said, None) {
                    paths[outcome.stats.path as usize] += 1;
                }
                break;
            }
            panics += 1;
            checked.model_mut().fail();
            after_panic(&mut checked, &mut rng);
        }
    }
    assert!(panics > frames / 4, "{panics} panics in {frames} frames");
    let lists = [Path::Lists as usize];
    let kinds = if paths[lists[0]] > 0 { 1 } else { 2 };
    assert!(paths.iter().filter(|count| **count > 0).count() >= kinds, "kinds of steps: {paths:?}");
}

/// What a panic in a step leaves behind: a valid world without a result, whose queries are right.
fn after_panic(checked: &mut Checked<'_>, rng: &mut Rng) {
    checked.check();
    let world = checked.world();
    assert!(world.pairs().is_empty() && world.found().is_empty() && world.lost().is_empty(), "no result");
    let all = Region::Sphere { center: [0.0; 3], radius: f32::INFINITY };
    let near = Region::Aabb(scenes::at(rng.point(0.0, 8.0), [3.0; 3]));
    for region in [all, near] {
        let mut told = Vec::new();
        world
            .visit_overlaps(&region, &mut |id| {
                told.push(id);
                ControlFlow::Continue(())
            })
            .expect("a good region");
        told.sort_by_key(|id| id.slot());
        let Region::Aabb(aabb) = near else { unreachable!() };
        let meets = |id: &Id| region == all || world.aabb(*id).is_some_and(|other| other.overlaps(&aabb));
        assert_eq!(told, world.ids().filter(meets).collect::<Vec<_>>());
    }
    if rng.once_in(8) {
        let saved = checked.save();
        checked.load(&saved);
    }
}

/// Objects come, go and change their filters.
fn change(checked: &mut Checked<'_>, rng: &mut Rng) {
    let ids = checked.model().ids();
    let some: Vec<Id> = (0..3).map(|k| ids[(rng.below(ids.len() / 3)) * 3 + k]).collect();
    match rng.below(3) {
        0 if ids.len() > 12 => checked.remove_many(&some),
        1 if ids.len() + 3 <= checked.world().capacity().objects as usize => {
            let boxes: Vec<Aabb> = some.iter().filter_map(|id| checked.world().aabb(*id)).collect();
            checked.insert_many(&boxes);
        }
        _ if checked.world().config().filters => {
            checked.refilter(some[0], rng.below(3) as u32);
            checked
                .set_filter(some[1], [Filter::ALL, Filter::groups(1, 6), Filter::groups(3, 3)][rng.below(3)]);
        }
        _ => {}
    }
}

const BARE: Config = Config::new(ample(0, 0));
const PLAIN: Config = BARE.with_filters();
const MARGIN: Margin = Margin { per_extent: 0.05, min: 0.02, max: 1.0 };

#[test]
fn a_step_after_a_panic_finds_what_brute_force_finds_in_a_list() {
    for (at, config) in [PLAIN, PLAIN.with_events()].into_iter().enumerate() {
        for count in [20, 60] {
            play(config, count, 1, 150, at as u64);
        }
        play(config.with_lean(), 200, 1, 100, at as u64);
    }
}

#[test]
fn a_step_after_a_panic_finds_what_brute_force_finds_in_a_tree() {
    for (at, config) in [PLAIN, PLAIN.with_events()].into_iter().enumerate() {
        play(config, 150, 1, 150, 3 + at as u64);
        play(config, 900, 1, 100, 5 + at as u64);
    }
}

#[test]
fn a_step_after_a_panic_finds_what_brute_force_finds_with_workers() {
    for (at, config) in [BARE, BARE.with_events()].into_iter().enumerate() {
        let config = config.with_sharing(Choice::Always);
        play(config.with_filters(), 1500, 2, 60, 7 + at as u64);
        play(config, 1500, 2, 60, 9 + at as u64);
    }
}

#[test]
fn a_step_after_a_panic_finds_what_brute_force_finds_with_margins() {
    let config = PLAIN.with_margin(MARGIN).with_events();
    for (at, config) in [config, config.with_mode(Mode::Fat)].into_iter().enumerate() {
        play(config, 60, 1, 100, 11 + at as u64);
        play(config.with_sharing(Choice::Always), 700, 2, 100, 13 + at as u64);
    }
}

/// Queries only look: after a visitor or a condition has panicked they answer as before, and so does the next step.
#[test]
fn visitors_and_conditions_leave_nothing_behind() {
    for config in [Config::new(ample(1000, 20_000)).with_events(), Config::new(ample(40, 800)).with_events()]
    {
        let boxes = scenes::uniform(config.capacity.objects as usize, 3);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        world.insert_many(&boxes);
        world.step(Setup::REFERENCE);
        let region = Region::Aabb(boxes[7]);
        let answers = |world: &Checked<'_>| {
            let mut ids = vec![];
            let visit = &mut |id| {
                ids.push(id);
                ControlFlow::Continue(())
            };
            world.world().visit_overlaps(&region, visit).expect("a region");
            ids
        };
        let before = answers(&world);
        assert!(!before.is_empty());
        let panics = |call: &dyn Fn() -> bool| {
            assert!(catch_unwind(AssertUnwindSafe(call)).is_err(), "nobody was asked");
            assert_eq!(answers(&world), before);
        };
        let now = world.world();
        panics(&|| now.visit_overlaps(&region, &mut |_| resume_unwind(Box::new(()))).is_ok());
        panics(&|| now.visit_nearest([0.0; 3], f64::INFINITY, &mut |_| resume_unwind(Box::new(()))).is_ok());
        panics(&|| now.among(|_| resume_unwind(Box::new(()))).nearest([0.0; 3], &mut [None]).is_ok());
        world.step_over(&boxes, Setup::REFERENCE);
    }
}

/// Half of the ids are taken, then the iterator is forgotten: those objects are there and no others, and steps are right.
#[test]
fn an_iterator_that_is_forgotten_leaves_a_whole_world() {
    let config = Config::new(ample(300, 6000)).with_events();
    let boxes = scenes::uniform(300, 3);
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    let mut inserted = world.insert_many(Boxes::new(&boxes)).expect("room");
    let ids: Vec<Id> = inserted.by_ref().take(150).collect();
    std::mem::forget(inserted);
    assert_eq!((world.len(), world.validate()), (150, Ok(())));
    let expected =
        trisap_tests::oracle::overlaps(&boxes[..150].iter().copied().map(Some).collect::<Vec<_>>());
    let step = world.step().expect("room");
    assert_eq!(
        (trisap_tests::sorted(step.pairs()), trisap_tests::sorted(step.found())),
        (expected.clone(), expected)
    );
    assert!(ids.iter().all(|id| world.contains(*id)));
    assert_eq!(world.insert_many(Boxes::new(&boxes[150..])).expect("room").count(), 150);
    assert_eq!((world.len(), world.validate()), (300, Ok(())));
}
