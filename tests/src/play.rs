//! Plays small counterexamples in worlds of three sizes, on every kernel and under every job system.
//!
//! A few boxes alone never see a tree: they are swept from one list. So each counterexample is played alone, in
//! the middle of thousands of resting boxes (few movers in a large tree, whose planes cut through the middle),
//! and as a lattice of copies of itself (wherever the planes lie, some copies straddle them, and all of them
//! move at once).

use crate::checked::{Checked, Outcome};
use crate::jobs::Jobs;
use crate::scenes::{Rng, at, shifted};
use crate::sorted;
use crate::worlds::{Setup, Slab, ample};
use trisap_core::{Aabb, Capacity, Config};

/// Copies of a counterexample on each axis of the lattice, and how far they are apart.
const COPIES: usize = 11;
const PITCH: f32 = 16.0;

/// Boxes around the counterexample, and how far out they reach.
const FILLERS: usize = 4000;
const REACH: f32 = 200.0;

/// The outcomes of a counterexample alone, a frame each; the checks of all other worlds have been made.
///
/// `config` tells mode and margin; events are always on, and the capacities are ample. All frames have the same
/// boxes in the same order.
///
/// # Panics
/// If any world differs from the model in any step, or any setup from the reference in any byte.
#[must_use]
pub fn play(config: Config, frames: &[Vec<Aabb>]) -> Vec<Outcome> {
    let outcomes = play_alone(config, frames);
    play_among_fillers(config, frames);
    play_copies(config, frames);
    outcomes
}

/// The counterexample and nothing else.
pub fn play_alone(config: Config, frames: &[Vec<Aabb>]) -> Vec<Outcome> {
    let outcomes = on_every_setup(config, frames, &Jobs::ALL);
    assert_eq!(outcomes.len(), frames.len());
    outcomes
}

/// The counterexample in the middle of a large world at rest.
pub fn play_among_fillers(config: Config, frames: &[Vec<Aabb>]) {
    let mut rng = Rng::new(7);
    let fillers: Vec<Aabb> = (0..FILLERS).map(|_| at(rng.point(-REACH, REACH), [1.0; 3])).collect();
    let embed = |frame: &Vec<Aabb>| frame.iter().chain(&fillers).copied().collect();
    let frames: Vec<Vec<Aabb>> = frames.iter().map(embed).collect();
    for outcome in on_every_setup(config, &frames, &Jobs::ALL) {
        assert!(outcome.stats.leaves > 1, "no tree among {FILLERS} fillers: {:?}", outcome.stats);
    }
}

/// Many copies of the counterexample side by side.
pub fn play_copies(config: Config, frames: &[Vec<Aabb>]) {
    let frames: Vec<Vec<Aabb>> = frames.iter().map(|frame| copies(frame)).collect();
    for outcome in on_every_setup(config, &frames, &Jobs::USUAL) {
        assert!(outcome.stats.leaves > 1, "no tree over {} boxes: {:?}", frames[0].len(), outcome.stats);
    }
}

fn copies(frame: &[Aabb]) -> Vec<Aabb> {
    let place = |i: usize| (i as f32 - (COPIES / 2) as f32) * PITCH;
    let mut boxes = Vec::with_capacity(frame.len() * COPIES * COPIES * COPIES);
    for i in 0..COPIES * COPIES * COPIES {
        let by = [place(i % COPIES), place(i / COPIES % COPIES), place(i / COPIES / COPIES)];
        boxes.extend(frame.iter().map(|aabb| shifted(aabb, by)));
    }
    boxes
}

/// Plays frames as they are on each kernel with each of the job systems, compares each step with the model and
/// all setups with each other, and returns the outcomes.
pub fn on_every_setup(config: Config, frames: &[Vec<Aabb>], jobs: &[Jobs]) -> Vec<Outcome> {
    let first = frames.first().expect("a frame");
    let pairs = frames.iter().map(|frame| crate::checked::expected(frame).len()).max().unwrap_or(0);
    // Fat boxes meet more often than the boxes themselves.
    // Worlds for fewer sweep no boxes with margins.
    let room = first.len().max(if config.margin.is_some() { 65 } else { 0 });
    let capacity: Capacity = ample(room, 4 * pairs + 4 * first.len() + 64);
    let config = config.with_capacity(capacity).with_events();
    let mut reference: Option<Vec<Outcome>> = None;
    for setup in Setup::each(jobs) {
        let outcomes = play_once(config, frames, setup);
        match &reference {
            None => reference = Some(outcomes),
            Some(reference) => assert_identical(&outcomes, reference, setup),
        }
    }
    reference.expect("one kernel at least")
}

fn play_once(config: Config, frames: &[Vec<Aabb>], setup: Setup) -> Vec<Outcome> {
    let config = setup.configure(config);
    let mut slab = Slab::new::<u32>(&config);
    let mut checked = Checked::<u32>::new(slab.world(&config));
    let ids = checked.insert_many(&frames[0]);
    assert!(ids.iter().zip(0..).all(|(id, slot)| id.slot() == slot), "slots are given out in order");
    let mut outcomes = vec![checked.step(setup)];
    for frame in &frames[1..] {
        outcomes.push(checked.step_over(frame, setup));
    }
    outcomes
}

/// Compares the outcomes of two setups, byte for byte.
///
/// # Panics
/// If they differ.
pub fn assert_identical(outcomes: &[Outcome], reference: &[Outcome], setup: Setup) {
    for (frame, (outcome, reference)) in outcomes.iter().zip(reference).enumerate() {
        if outcome != reference {
            let same_set = sorted(&outcome.pairs) == sorted(&reference.pairs);
            assert!(same_set, "frame {frame}: {setup:?} has other pairs than the reference");
            assert_eq!(outcome.stats, reference.stats, "frame {frame}: {setup:?} has other statistics");
            panic!("frame {frame}: {setup:?} has the same pairs in another order");
        }
    }
    assert_eq!(outcomes.len(), reference.len());
}
