//! Worlds whose boxes are all the same point on an axis, as in a game in two dimensions, and worlds where only nearly all are:
//! compared with brute force, on all kernels, alone and with workers.

use trisap_core::{Aabb, Config};
use trisap_tests::checked::Checked;
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};

/// No multiple of four, since boxes are looked at in fours.
const COUNT: usize = 2603;

/// Puts boxes at one point of an axis, of which zero has two signs.
fn flatten(boxes: &mut [Aabb], axis: usize, point: f32) {
    for (index, aabb) in boxes.iter_mut().enumerate() {
        let point = if point == 0.0 && index % 3 == 0 { -point } else { point };
        (aabb.min[axis], aabb.max[axis]) = (point, point);
    }
}

/// Steps flat worlds in which most objects move; `spoil` may change some boxes. Returns the candidates, and those that tied.
fn steps(spoil: impl Fn(&mut [Aabb], usize, f32)) -> (u64, u64) {
    let config = Config::new(ample(COUNT, 60 * COUNT)).with_events();
    let (mut candidates, mut tied) = (0, 0);
    for setup in Setup::each(&[Jobs::Serial, Jobs::Threads(3)]) {
        for (axis, point) in [(0, 0.0), (1, 7.5), (2, 0.0), (2, -300.0), (0, f32::from_bits(1))] {
            let config = setup.configure(config);
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::new(slab.world::<u32>(&config));
            let mut boxes = scenes::Brownian::new(COUNT, 5).boxes().to_vec();
            let mut rng = Rng::new(7);
            flatten(&mut boxes, axis, point);
            spoil(&mut boxes, axis, point);
            let ids = world.insert_many(&boxes);
            // Slots without an object stand among all others.
            world.remove_many(&[ids[3], ids[70], ids[COUNT - 2]]);
            world.set_enabled(&[ids[12], ids[301]], false);
            for thousandths in [1000, 900, 1000, 300] {
                scenes::walk(&mut boxes, thousandths, 0.4, &mut rng);
                flatten(&mut boxes, axis, point);
                spoil(&mut boxes, axis, point);
                let stats = world.step_over(&boxes, setup).stats;
                candidates += stats.candidates;
                tied += stats.tied;
            }
        }
    }
    (candidates, tied)
}

#[test]
fn hardly_any_candidate_waits_for_the_exact_test() {
    let (candidates, tied) = steps(|_, _, _| {});
    assert!(candidates > 1000 && tied < candidates / 20, "{tied} of {candidates} tied");
}

#[test]
fn boxes_that_are_not_flat() {
    // One that is apart from all others by the least step.
    steps(|boxes, axis, point| boxes[9].max[axis] = point.next_up());
    steps(|boxes, axis, point| {
        (boxes[9].min[axis], boxes[9].max[axis]) = (point.next_up(), point.next_up());
    });
    steps(|boxes, axis, point| {
        (boxes[COUNT - 1].min[axis], boxes[COUNT - 1].max[axis]) = (point.next_down(), point.next_down());
    });
    // A tall one, a large flat one elsewhere, and one without bounds.
    steps(|boxes, axis, point| {
        boxes[11].min[axis] = point - 5.0;
        let mut large = Aabb::new([-1e4; 3], [1e4; 3]);
        (large.min[axis], large.max[axis]) = (point.next_down(), point.next_down());
        boxes[400] = large;
        boxes[401] = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
    });
    // Every seventh one is elsewhere.
    steps(|boxes, axis, point| {
        for aabb in boxes.iter_mut().step_by(7) {
            (aabb.min[axis], aabb.max[axis]) = (point.next_down(), point.next_down());
        }
    });
}

/// Bricks in rows, numbered row by row: a sample at a fixed step sees one column of some of these walls, and all others are taken
/// for outliers of the grid.
#[test]
fn walls_with_rows_of_any_length() {
    let config = Config::new(ample(COUNT, 60 * COUNT));
    for columns in 3..40 {
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::new(slab.world::<u32>(&config));
        let (mut boxes, mut rng) = (Vec::new(), Rng::new(columns));
        for index in 0..COUNT as u64 {
            let (row, column) = (index / columns, index % columns);
            let [x, y] = [column as f32 + 0.5 * (row % 2) as f32, row as f32];
            boxes.push(Aabb::new([x, y, 0.0], [x + 1.0, y + 1.0, 1.0]));
        }
        world.insert_many(&boxes);
        for _ in 0..3 {
            scenes::walk(&mut boxes, 1000, 0.001, &mut rng);
            let stats = world.step_over(&boxes, Setup::REFERENCE).stats;
            // Each brick has three neighbours to come; of bricks that share a step of the grid more are tested.
            assert!(stats.candidates < 4 * COUNT as u64, "{columns} columns: {}", stats.candidates);
        }
    }
}
