//! A world of 200,000 objects against an independent sweep. (`examples/million.rs` has five times as many.)

use trisap_core::{Boxes, Config, World};
use trisap_tests::checked::slots;
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{Brownian, Rng, walk};
use trisap_tests::worlds::{Slab, ample};
use trisap_tests::{oracle, sorted};

const COUNT: usize = 200_000;

#[test]
fn a_large_brownian_world_is_exact() {
    let mut scene = Brownian::new(COUNT, 200);
    let mut frames = vec![scene.boxes().to_vec(), scene.advance().to_vec(), scene.advance().to_vec()];
    let mut few = frames[2].clone();
    walk(&mut few, 3, 1.0, &mut Rng::new(201));
    frames.push(few);

    let mut config = Config::new(ample(COUNT, 8 * COUNT)).with_events().with_workers(2);
    config.capacity.leaf_refs = COUNT as u32 / 2;
    let mut slab = Slab::new::<u32>(&config);
    let mut world: World<'_> = slab.world(&config);
    world.insert_many(Boxes::new(&frames[0])).expect("room for all");
    let mut before = 0;
    for frame in &frames {
        let step = world.on(&Jobs::Threads(2)).step_over(Boxes::new(frame)).expect("room for all");
        let (stats, pairs) = (step.stats(), sorted(&slots(step.pairs())));
        let expected = oracle::sweep(&oracle::all_live(frame));
        assert!(pairs == expected, "{} pairs for {}: {stats:?}", pairs.len(), expected.len());
        assert_eq!(before + stats.found - stats.lost, stats.pairs);
        before = stats.pairs;
        world.validate().expect("a valid world");
    }
}
