//! Whatever an executor does, a step gives the same bytes: results, statistics, and all of the world that outlives
//! the step.

use std::sync::Mutex;
use std::thread;
use trisap_core::{
    Aabb, Boxes, Capacity, Config, Error, Executor, Id, Index, Kernels, Margin, Mode, Path, World, layout,
};
use trisap_tests::checked::Outcome;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::saved;
use trisap_tests::scenes::{self, Brownian, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};

/// Workers of every world here, so that the same bytes can be asked for whatever the executor promises.
const WORKERS: u32 = 8;

/// More than one leaf, and several blocks in every stage.
const TREE: usize = 5000;
/// One leaf, swept from a list.
const LEAF: usize = 300;

/// Everything that can be seen of a world after a call of `step`.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    result: Result<Outcome, Error>,
    bytes: Vec<u8>,
}

/// The length of the part of a world's memory that outlives a step, but for the pairs: behind these there is what a step has
/// written on its way, and what they are is in a snapshot. At the end stand the workers' staged pairs and their scratch, which the
/// next step writes before it reads them.
fn persistent<I: Index>(config: &Config) -> usize {
    let no_pairs = config.with_capacity(config.capacity.with_pairs(0));
    let bytes = |workers| layout::<I>(&no_pairs.with_workers(workers)).expect("a world").bytes;
    // One worker stages nothing; four more workers cost four scratches, without rounding.
    let scratch = (bytes(6) - bytes(2)) / 4;
    bytes(1) - scratch.next_multiple_of(64)
}

/// What happens to a world before a step.
enum Act {
    /// Boxes for all slots.
    Over(Vec<Aabb>),
    /// New boxes for some slots.
    Set(Vec<(u32, Aabb)>),
    /// The objects of these slots go.
    Remove(Vec<u32>),
    /// New objects come.
    Insert(Vec<Aabb>),
    /// Nothing.
    Rest,
}

/// Steps of all kinds: everything at once, all move, few move, none, some go and come, bad boxes.
fn script(count: usize) -> Vec<Act> {
    let mut rng = Rng::new(3);
    let mut scene = Brownian::new(count, 4);
    let mut acts = vec![Act::Insert(scene.boxes().to_vec()), Act::Over(scene.advance().to_vec()), Act::Rest];
    let mut few = scene.boxes().to_vec();
    for _ in 0..2 {
        scenes::walk(&mut few, 9, 1.5, &mut rng);
        acts.push(Act::Over(few.clone()));
    }
    let slots = |step: usize| (0..count as u32).step_by(step);
    acts.push(Act::Set(slots(40).map(|slot| (slot, scenes::cube(slot as f32 / 90.0, 1.0, 2.0))).collect()));
    acts.push(Act::Remove(slots(50).collect()));
    acts.push(Act::Insert(scenes::uniform(count / 60, 5)));
    let mut bad = scene.advance().to_vec();
    bad.iter_mut().step_by(7).for_each(|aabb| aabb.max[1] = f32::NAN);
    acts.extend([
        Act::Over(bad),
        Act::Over(scenes::clustered(count, 6)),
        Act::Over(scene.advance().to_vec()),
    ]);
    acts
}

/// Plays a script in a fresh world, which is checked after each step.
fn play<I: Index>(config: &Config, acts: &[Act], kernels: Kernels, executor: &dyn Executor) -> Vec<Frame> {
    play_and(|world: &World<'_, I>| assert_eq!(world.validate(), Ok(())), config, acts, kernels, executor)
}

/// The same without the check. All that it reads is among the bytes that are compared with those of a world that was checked.
fn replay<I: Index>(config: &Config, acts: &[Act], kernels: Kernels, executor: &dyn Executor) -> Vec<Frame> {
    play_and(|_: &World<'_, I>| {}, config, acts, kernels, executor)
}

fn play_and<I: Index>(
    check: impl Fn(&World<'_, I>),
    config: &Config,
    acts: &[Act],
    kernels: Kernels,
    executor: &dyn Executor,
) -> Vec<Frame> {
    let mut slab = Slab::new::<I>(config);
    let persistent = persistent::<I>(config);
    let mut frames = Vec::new();
    let _ = slab.world::<I>(config);
    for act in acts {
        let mut world = World::<I>::open(slab.bytes_mut()).expect("the world of the last frame");
        let ids = |world: &World<'_, I>, slots: &[u32]| -> Vec<Id> {
            slots.iter().filter_map(|&slot| world.id_at(slot)).collect()
        };
        match act {
            Act::Over(_) | Act::Rest => {}
            Act::Set(boxes) => {
                let (slots, boxes): (Vec<u32>, Vec<Aabb>) = boxes.iter().copied().unzip();
                world.update_many(&ids(&world, &slots), Boxes::new(&boxes)).expect("living objects");
            }
            Act::Remove(slots) => world.remove_many(&ids(&world, slots)).expect("living objects"),
            Act::Insert(boxes) => {
                world.insert_many(Boxes::new(boxes)).expect("room");
            }
        }
        let result = match act {
            Act::Over(boxes) => world.set_kernels(kernels).on(executor).step_over(Boxes::new(boxes)),
            _ => world.set_kernels(kernels).on(executor).step(),
        };
        let result = result.map(|step| Outcome::of(&step));
        if !cfg!(miri) {
            check(&world);
        }
        let snapshot = saved(&world);
        frames.push(Frame { result, bytes: [&slab.bytes()[..persistent], &snapshot].concat() });
    }
    frames
}

/// Says where two plays differ, and not by thousands of numbers.
fn compare(frames: &[Frame], reference: &[Frame], who: &str) {
    assert_eq!(frames.len(), reference.len());
    for (at, (frame, reference)) in frames.iter().zip(reference).enumerate() {
        let stats =
            |frame: &Frame| frame.result.as_ref().map(|outcome| outcome.stats).map_err(|&error| error);
        assert_eq!(stats(frame), stats(reference), "frame {at}: {who} has other statistics");
        assert!(frame.result == reference.result, "frame {at}: {who} has other pairs, or another order");
        let differs = || (0..frame.bytes.len()).find(|&byte| frame.bytes[byte] != reference.bytes[byte]);
        assert!(frame.bytes == reference.bytes, "frame {at}: {who} has another byte at {:?}", differs());
    }
}

/// Every way to keep the contract, and every number of workers.
fn every() -> Vec<Jobs> {
    let counts = (1..=WORKERS).map(Jobs::Threads).chain([2, 3, WORKERS].map(Jobs::Helping));
    Jobs::ALL.into_iter().chain(Jobs::PERVERSE).chain(counts).collect()
}

/// Enough objects that several threads sort them and make parts of the tree.
const FOREST: usize = 20_000;

#[test]
fn a_tree_is_the_same_whoever_makes_it() {
    let config = Config::new(ample(FOREST, 8 * FOREST)).with_workers(WORKERS);
    // Sorted by slot at first, then in the order of an axis, then parts by their leaves.
    let mut drift = scenes::clustered(FOREST, 8);
    drift.iter_mut().for_each(|aabb| aabb.min[2] -= 0.5);
    let acts = [
        Act::Insert(scenes::uniform(FOREST, 5)),
        Act::Over(scenes::clustered(FOREST, 6)),
        Act::Over(scenes::clustered(FOREST, 7)),
        Act::Over(drift),
        Act::Over(scenes::uniform(FOREST, 9)),
    ];
    let reference = play::<u32>(&config, &acts, Setup::REFERENCE.kernels, &Jobs::Serial);
    let rebuilt = |frame: &&Frame| frame.result.as_ref().is_ok_and(|outcome| outcome.stats.rebalanced > 0);
    assert!(reference.iter().filter(rebuilt).count() > 1, "the tree was made once");
    for jobs in [Jobs::Never, Jobs::Threads(2), Jobs::Threads(5), Jobs::Reversed, Jobs::Late] {
        compare(&replay::<u32>(&config, &acts, Kernels::detect(), &jobs), &reference, &format!("{jobs:?}"));
    }
}

/// Plays a script on every kernel under every executor; returns the reference.
fn on_every_executor<I: Index>(config: Config, count: usize) -> Vec<Frame> {
    let config = config.with_workers(WORKERS);
    let acts = script(count);
    let reference = play::<I>(&config, &acts, Setup::REFERENCE.kernels, &Jobs::Serial);
    for setup in Setup::each(&every()) {
        let who = format!("{setup:?} {:?} {:?}", config.mode, config.margin);
        compare(&replay::<I>(&config, &acts, setup.kernels, &setup.jobs), &reference, &who);
    }
    reference
}

fn modes(count: usize) -> [Config; 4] {
    let plain = Config::new(ample(count, 30 * count));
    let margin = plain.with_margin(Margin::length(0.05)).with_events();
    [plain, plain.with_events(), margin, margin.with_mode(Mode::Fat)]
}

fn paths(frames: &[Frame]) -> Vec<Path> {
    frames.iter().flat_map(|frame| &frame.result).map(|outcome| outcome.stats.path).collect()
}

#[test]
fn a_tree_is_the_same_under_every_executor() {
    for config in modes(TREE) {
        let frames = on_every_executor::<u32>(config, TREE);
        let paths = paths(&frames);
        for path in [Path::Rebuilt, Path::Full, Path::Movers, Path::Unchanged] {
            assert!(paths.contains(&path), "no step goes the way {path:?}: {paths:?}");
        }
        let outcomes = || frames.iter().flat_map(|frame| &frame.result);
        assert!(outcomes().all(|outcome| outcome.stats.leaves >= 8), "a tree of several blocks");
        assert!(outcomes().any(|outcome| outcome.rejected.is_some()), "bad boxes");
        assert_eq!(outcomes().any(|outcome| !outcome.lost.is_empty()), config.events, "events");
    }
}

#[test]
fn one_leaf_is_the_same_under_every_executor() {
    for config in modes(LEAF) {
        let paths = paths(&on_every_executor::<u16>(config, LEAF));
        assert!(paths.contains(&Path::Rebuilt), "{paths:?}");
    }
}

/// The pairs do not fit, hardly fit, and just fit: staging has no room to spare then.
#[test]
fn a_full_buffer_is_the_same_under_every_executor() {
    let ample = modes(TREE)[1];
    let most = play::<u32>(&ample, &script(TREE), Kernels::SCALAR, &Jobs::Serial);
    let most =
        most.iter().flat_map(|frame| &frame.result).map(|outcome| outcome.pairs.len()).max().unwrap_or(0);
    for pairs in [10, most / 3, most] {
        let mut config = ample;
        config.capacity.pairs = pairs as u32;
        let frames = on_every_executor::<u32>(config, TREE);
        let full = frames.iter().filter(|frame| frame.result.is_err()).count();
        assert_eq!(full > 0, pairs < most, "{full} steps are full with room for {pairs} of {most}");
    }
}

/// Few enough boxes for an interpreter that looks for races and undefined behaviour; one seed takes minutes even so:
/// `cargo +nightly miri test -p trisap-tests --test conformance a_small_tree`.
#[test]
fn a_small_tree_is_the_same_on_threads() {
    const COUNT: usize = 1040;
    let mut config = modes(COUNT)[2].with_workers(2).with_sharing(Choice::Always);
    config.capacity = Capacity::for_objects(1040).with_leaf_refs(1040).with_pairs(2000);
    let all = scenes::uniform(COUNT, 9);
    let few = [3, 400, 900].map(|slot| (slot, all[slot as usize + 5])).to_vec();
    let next = all.iter().map(|aabb| scenes::shifted(aabb, [0.5, 0.0, 0.25])).collect();
    let acts = [Act::Insert(all), Act::Set(few), Act::Over(next)];
    let reference = play::<u32>(&config, &acts, Kernels::SCALAR, &Jobs::Serial);
    let two_blocks = |frame: &Frame| frame.result.as_ref().is_ok_and(|outcome| outcome.stats.leaves == 4);
    assert!(reference.iter().all(two_blocks), "something to share in every stage");
    for setup in Setup::each(&[Jobs::Helping(2)]) {
        compare(&play::<u32>(&config, &acts, setup.kernels, &setup.jobs), &reference, "a small tree");
    }
}

/// The test of the test: worlds that differ are told apart, by their results and by their bytes.
#[test]
fn a_difference_is_seen() {
    let config = modes(LEAF)[1];
    let acts = script(LEAF);
    let mut other = script(LEAF);
    let Act::Over(boxes) = &mut other[1] else { panic!("the second act moves all") };
    boxes[7].max[0] = f32::from_bits(boxes[7].max[0].to_bits() + 1);
    let [frames, others] =
        [acts, other].map(|acts| play::<u32>(&config, &acts, Kernels::SCALAR, &Jobs::Serial));
    assert_eq!(frames[0], others[0]);
    assert_ne!(frames[1].bytes, others[1].bytes, "one bit of one box");
}

/// What a step asks an executor for.
struct Asked {
    workers: u32,
    widths: Mutex<Vec<u32>>,
}

impl Executor for Asked {
    fn workers(&self) -> u32 {
        self.workers
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.widths.lock().expect("no panic").push(width);
        Jobs::Helping(width).fork_join(width, job);
    }
}

#[test]
fn the_width_is_within_what_was_promised() {
    for (workers, config_workers) in [(1, 8), (2, 8), (8, 2), (8, 8), (u32::MAX, 32), (8, 1)] {
        let asked = Asked { workers, widths: Mutex::default() };
        let config = modes(TREE)[2].with_workers(config_workers);
        play::<u32>(&config, &script(TREE), Kernels::SCALAR, &asked);
        let widths = asked.widths.into_inner().expect("no panic");
        let most = workers.min(config_workers);
        assert!(widths.iter().all(|width| (2..=most).contains(width)), "{workers}: {widths:?}");
        assert_eq!(widths.is_empty(), most == 1, "help is asked for where there is some");
        assert!(most > 5 || most == 1 || widths.contains(&most), "{workers}: {widths:?}");
    }
}

/// Threads with no more stack than the contract promises to need, and what the platform needs for itself.
struct Cramped;

impl Executor for Cramped {
    fn workers(&self) -> u32 {
        2
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        thread::scope(|scope| {
            for _ in 0..width {
                let cramped = thread::Builder::new().stack_size(16 << 10);
                cramped.spawn_scoped(scope, job).expect("a thread");
            }
        });
    }
}

#[test]
fn a_call_needs_little_stack() {
    let config = modes(TREE)[3].with_workers(WORKERS);
    let acts = script(TREE);
    let reference = play::<u32>(&config, &acts, Kernels::SCALAR, &Jobs::Serial);
    for kernels in Kernels::all() {
        compare(&play::<u32>(&config, &acts, kernels, &Cramped), &reference, "a small stack");
    }
}
