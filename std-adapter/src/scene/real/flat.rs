//! A flat world.

use super::body::Body;
use super::{Random, Start};

/// The area of the world, in square metres a box.
const SPACE: f32 = 5.0;

/// One object in so many is a platform.
const PLATFORMS: u32 = 6;

/// How far a body moves in a frame at most.
const PACE: f32 = 0.2;

pub(super) fn start(count: u32, random: &mut Random) -> Start {
    // Platformers are wide and low.
    let height = (SPACE * count as f32 / 4.0).sqrt();
    let room = ([-2.0 * height, 0.0, 0.0], [2.0 * height, height, 0.0]);
    let mut bodies: Vec<Body> = Vec::with_capacity(count as usize);
    for at in 0..count {
        let place = [random.between(room.0[0], room.1[0]), random.between(room.0[1], room.1[1]), 0.0];
        bodies.push(if at % PLATFORMS == 0 {
            Body::resting([random.between(2.0, 12.0), 0.5, 0.0], place)
        } else {
            let edges = [random.between(0.5, 1.5), random.between(0.5, 2.0), 0.0];
            let [x, y, _] = random.in_ball(PACE);
            Body::walking(edges, place, [x, y, 0.0], room)
        });
    }
    Start::steady(bodies)
}
