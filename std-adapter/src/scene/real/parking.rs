//! A car park.

use super::body::Body;
use super::{Random, Start};

/// One car in so many drives, and one at least.
const DRIVING: u32 = 200;

/// From one bay to the next along a row, and from one row to the next: two rows stand nose to nose, and between these pairs
/// of rows there are lanes.
const BAY: f32 = 2.6;
const DEPTH: f32 = 4.9;
const LANE: f32 = 6.0;

/// How far from the middle of a lane a car drives: on its own side, where it brushes the boxes of parked cars.
const ASIDE: f32 = 2.4;

/// How fast a car drives at most, in metres a frame: 6 m/s.
const PACE: f32 = 0.2;

pub(super) fn start(count: u32, random: &mut Random) -> Start {
    let driving = count.div_ceil(DRIVING);
    // A row is about as long as all rows together are deep.
    let a_row = (f64::from(count) * f64::from((DEPTH + LANE / 2.0) / BAY)).sqrt().ceil() as u32;
    let rows = count.div_ceil(a_row);
    let length = a_row as f32 * BAY;
    let lane = |pair: u32| pair as f32 * (2.0 * DEPTH + LANE);
    let mut bodies = Vec::with_capacity(count as usize);
    for at in 0..count {
        let size = [random.between(1.7, 2.0), random.between(1.4, 2.0), random.between(3.8, 4.8)];
        bodies.push(if at < driving {
            let z = lane(random.below(rows.div_ceil(2))) - LANE / 2.0 + ASIDE;
            let edges = [size[2], size[1], size[0]];
            let velocity = [random.between(PACE / 2.0, PACE), 0.0, 0.0];
            let room = ([0.0, 0.0, z - 1.0], [length.max(edges[0]), edges[1], z + 1.0]);
            Body::walking(edges, [random.between(0.0, length), 0.0, z], velocity, room)
        } else {
            let (bay, row) = (at % a_row, at / a_row);
            // They stand at an angle, so that the boxes are wider than the cars; no driver meets it well.
            let turn = random.between(0.1, 0.3);
            let edges = [size[0] + turn * size[2], size[1], size[2] + turn * size[0]];
            let x = (bay as f32 + 0.5) * BAY + random.between(-0.2, 0.2);
            let z = lane(row / 2) + (row % 2) as f32 * DEPTH + DEPTH / 2.0 + random.between(-0.2, 0.2);
            Body::resting(edges, [x, edges[1] / 2.0, z])
        });
    }
    Start::steady(bodies)
}
