//! A layer of cubes on a ground.

use super::body::{Body, Motion};
use super::{Ground, Random, Start};

/// From one cube of the layer to the next, and how far from its place in the grid a cube stands at most, on x and on z.
const SPACING: f32 = 2.0;
const ASTRAY: f32 = 0.7;

/// How far a cube shivers on x and z, and how deep it is pressed into the ground: what a physics engine leaves.
const SHIVER: f32 = 0.01;

/// How thick the ground is.
const THICKNESS: f32 = 1.0;

pub(super) fn start(ground: Ground, count: u32, random: &mut Random) -> Start {
    let cubes = if ground == Ground::None { count } else { count - 1 };
    let across = f64::from(cubes).sqrt().ceil() as u32;
    let side = across as f32 * SPACING;
    let slab = |edge: f32| Body::resting([edge, THICKNESS, edge], [0.0, -THICKNESS / 2.0, 0.0]);
    let mut bodies = Vec::with_capacity(count as usize);
    bodies.extend(match ground {
        Ground::None => None,
        Ground::Pile => Some(slab(side)),
        Ground::Wide => Some(slab(2e4)),
        Ground::Infinite => Some(slab(f32::INFINITY)),
    });
    for at in 0..cubes {
        let mut place =
            |step: u32| (step as f32 + 0.5) * SPACING - side / 2.0 + random.between(-ASTRAY, ASTRAY);
        let (x, z) = (place(at % across), place(at / across));
        // Never above the ground, so that it always touches it.
        let home = [x, (1.0 - SHIVER) / 2.0, z];
        let motion = Motion::Shiver { home, reach: [SHIVER, SHIVER / 2.0, SHIVER] };
        bodies.push(Body { half: [0.5; 3], centre: [x, 0.5, z], motion });
    }
    Start::steady(bodies)
}
