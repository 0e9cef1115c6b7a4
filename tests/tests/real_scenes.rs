//! The scenes of games and simulations: the pairs of every frame are those of brute force, and the events are the differences
//! from frame to frame.

use trisap::scene::real::{Kind, Scene, Setup as SceneSetup};
use trisap_core::{Aabb, Capacity, Config, Kernels, Margin, Mode};
use trisap_tests::checked::Checked;
use trisap_tests::jobs::Jobs;
use trisap_tests::oracle::{all_live, brute_force};
use trisap_tests::sorted;
use trisap_tests::worlds::{Setup, Slab};

/// Enough for a tree.
const COUNT: u32 = 700;
const FRAMES: u32 = 30;

const EXACT: Config =
    Config::new(Capacity::for_objects(COUNT).with_leaf_refs(8 * COUNT).with_pairs(COUNT * COUNT))
        .with_events();

fn frames(kind: Kind) -> Vec<Vec<Aabb>> {
    let mut scene = Scene::new(SceneSetup { kind, count: COUNT, seed: 5 }).expect("enough boxes");
    let next = |_| {
        let boxes = scene.boxes().to_vec();
        scene.advance();
        boxes
    };
    (0..FRAMES).map(next).collect()
}

/// Steps through all frames. [`Checked`] compares each step with its model, events and statistics included; the pairs are
/// compared with brute force here too, as the model sweeps.
fn play(kind: Kind, config: Config, jobs: Jobs) {
    let setup = Setup { kernels: Kernels::detect(), jobs };
    let config = setup.configure(config);
    let mut slab = Slab::new::<u16>(&config);
    let mut world = Checked::<u16>::new(slab.world(&config));
    let (mut last, mut changed, mut has_tree) = (Vec::new(), 0, false);
    for (frame, boxes) in frames(kind).iter().enumerate() {
        if frame == 0 {
            world.insert_many(boxes);
        }
        let outcome = world.step_over(boxes, setup);
        let (pairs, expected) = (sorted(&outcome.pairs), brute_force(&all_live(boxes)));
        match config.mode {
            Mode::Exact => assert!(pairs == expected, "{kind}, frame {frame}"),
            Mode::Fat => {
                let all = expected.iter().all(|pair| pairs.binary_search(pair).is_ok());
                assert!(all, "{kind}, frame {frame}");
            }
        }
        let only = |a: &[[u32; 2]], b: &[[u32; 2]]| -> Vec<_> {
            a.iter().filter(|pair| b.binary_search(pair).is_err()).copied().collect()
        };
        assert_eq!(sorted(&outcome.found), only(&pairs, &last), "{kind}, frame {frame}: found");
        assert_eq!(sorted(&outcome.lost), only(&last, &pairs), "{kind}, frame {frame}: lost");
        if frame > 0 {
            changed += outcome.found.len() + outcome.lost.len();
        }
        has_tree |= outcome.stats.leaves > 1;
        last = pairs;
    }
    // What shivers never leaves its margin.
    let has_events = changed > 0 || config.mode == Mode::Fat;
    assert!(!last.is_empty() && has_events, "{kind} tests nothing: {} pairs, {changed} events", last.len());
    assert!(has_tree || kind == Kind::Spawn, "{kind} never has a tree");
}

#[test]
fn the_pairs_and_events_of_every_scene_are_right() {
    for kind in Kind::ALL {
        play(kind, EXACT, Jobs::Serial);
    }
}

#[test]
fn with_margins_too() {
    for kind in Kind::ALL {
        let margin = EXACT.with_margin(Margin::share(0.1));
        play(kind, margin, Jobs::Serial);
        play(kind, margin.with_mode(Mode::Fat), Jobs::Serial);
    }
}
