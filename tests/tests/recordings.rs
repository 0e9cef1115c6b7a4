//! The recorded simulations: every frame, pair for pair, on every kernel, with any number of workers.
//!
//! `TRISAP_RECORDINGS` names a folder of more recordings, which are tested in the same way.

use trisap_core::{Boxes, Config, Margin, Mode, World};
use trisap_tests::checked::Outcome;
use trisap_tests::doing::On as _;
use trisap_tests::jobs::Jobs;
use trisap_tests::model::Model;
use trisap_tests::recordings::{self, Recording};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{SlotPair, oracle, sorted};

/// A tenth of an edge of the cubes.
const MARGIN: Margin = Margin::share(0.1);

const WORKERS: [Jobs; 5] =
    [Jobs::Serial, Jobs::Threads(2), Jobs::Threads(3), Jobs::Threads(4), Jobs::Threads(8)];

/// Steps through the recording, all boxes handed over as they are in the file. Also the world after the last frame, as a
/// snapshot.
fn outcomes(recording: &Recording, config: Config, setup: Setup) -> (Vec<Outcome>, Vec<u8>) {
    let objects = recording.objects();
    let config = setup.configure(config.with_capacity(ample(objects, 40 * objects)));
    let mut slab = Slab::new::<u16>(&config);
    let mut world: World<'_, u16> = slab.world(&config);
    world.insert_many(Boxes::padded(&recording.frames[0])).expect("room for all");
    let mut step = |frame: &Vec<[f32; 8]>| {
        let step = world.under(&setup).step_over(Boxes::padded(frame)).expect("room for all");
        let outcome = Outcome::of(&step);
        world.validate().unwrap_or_else(|invalid| panic!("{} {setup:?}: {invalid}", recording.name));
        outcome
    };
    let outcomes = recording.frames.iter().map(&mut step).collect();
    let mut snapshot = vec![0; world.snapshot_size()];
    world.save(&mut snapshot).expect("as long as was asked for");
    (outcomes, snapshot)
}

/// The pairs of each frame by all against all.
fn exact_pairs(recording: &Recording) -> Vec<Vec<SlotPair>> {
    let frames = 0..recording.frames.len();
    frames.map(|frame| oracle::brute_force(&oracle::all_live(&recording.boxes(frame)))).collect()
}

/// Compares one run with all against all, and every other kernel and number of workers with that run.
fn every_frame(base: Config, check: impl Fn(&Outcome, &[SlotPair], &str)) {
    let config = base.with_events();
    for recording in recordings::all() {
        let exact = exact_pairs(&recording);
        let (reference, snapshot) = outcomes(&recording, config, Setup::REFERENCE);
        assert_eq!(reference.len(), exact.len());
        let mut model = Model::of_events(recording.objects());
        for (frame, (outcome, exact)) in reference.iter().zip(&exact).enumerate() {
            let at = format!("{} frame {frame}", recording.name);
            check(outcome, exact, &at);
            let events = model.complete(&sorted(&outcome.pairs));
            assert_eq!(sorted(&outcome.found), events.found, "{at}: found");
            assert_eq!(sorted(&outcome.lost), events.lost, "{at}: lost");
        }
        for setup in Setup::each(&WORKERS) {
            let (outcomes, last) = outcomes(&recording, config, setup);
            for (frame, (outcome, reference)) in outcomes.iter().zip(&reference).enumerate() {
                assert!(outcome == reference, "{} frame {frame}: {setup:?} differs", recording.name);
            }
            assert!(last == snapshot, "{}: {setup:?} has another world in the end", recording.name);
        }
    }
}

fn is_exact(outcome: &Outcome, exact: &[SlotPair], at: &str) {
    assert!(sorted(&outcome.pairs) == exact, "{at}: {} pairs for {}", outcome.pairs.len(), exact.len());
    assert_eq!(outcome.surplus, 0, "{at}");
}

#[test]
fn exact() {
    every_frame(Config::new(ample(0, 0)), is_exact);
}

#[test]
fn exact_with_a_margin() {
    every_frame(Config::new(ample(0, 0)).with_margin(MARGIN), is_exact);
}

#[test]
fn fat() {
    every_frame(Config::new(ample(0, 0)).with_margin(MARGIN).with_mode(Mode::Fat), |outcome, exact, at| {
        let pairs = sorted(&outcome.pairs);
        assert!(pairs.windows(2).all(|two| two[0] < two[1]), "{at}: a pair is told twice");
        let missing = exact.iter().find(|pair| pairs.binary_search(pair).is_err());
        assert_eq!(missing, None, "{at}: an overlap that is not among the fat pairs");
        assert_eq!(outcome.surplus, (pairs.len() - exact.len()) as u64, "{at}");
        assert!(outcome.surplus > 0, "{at}: the margin made no difference");
    });
}
