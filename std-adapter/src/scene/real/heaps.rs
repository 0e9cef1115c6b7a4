//! What lies on each other: a pile of cubes, and grains.

use super::super::cube_root;
use super::body::{Body, direction};
use super::{Random, Start};

/// From one cube of a pile to the next: as if they touched.
const SPACING: f32 = 1.0;

/// How far a cube of a pile is from its place in the grid, and how far it goes from there, on each axis.
const ASTRAY: f32 = 0.15;
const REACH: f32 = 0.2;

/// How far a cube of a pile moves in a frame.
const CREEP: f32 = 0.05;

/// How much farther than up a heap reaches to each side.
const SLOPE: f32 = 1.5;

/// A cone of cubes.
pub(super) fn pile(count: u32, random: &mut Random) -> Start {
    // The volume of a cone is a third of that of the cylinder around it.
    let volume = 3.0 / (std::f64::consts::PI * f64::from(SLOPE * SLOPE));
    let mut height = cube_root(f64::from(count) * volume) as f32;
    let places = loop {
        let places = cone(height, count as usize);
        if places.len() == count as usize {
            break places;
        }
        height *= 1.02;
    };
    let bodies = places.into_iter().map(|place| {
        let home = place.map(|x| x * SPACING + random.between(-ASTRAY, ASTRAY));
        Body::near_home([1.0; 3], home, direction(CREEP, random), [REACH; 3])
    });
    Start::steady(bodies.collect())
}

/// The first so many places of a grid with spacing 1 that are in a cone of this height, from the bottom up.
fn cone(height: f32, count: usize) -> Vec<[f32; 3]> {
    let mut places = Vec::with_capacity(count);
    for layer in 0..=height as i32 {
        let y = layer as f32;
        let radius = SLOPE * (height - y) + 0.5;
        let reach = radius as i32;
        for x in -reach..=reach {
            for z in -reach..=reach {
                let (x, z) = (x as f32, z as f32);
                if x * x + z * z <= radius * radius && places.len() < count {
                    places.push([x, y + 0.5, z]);
                }
            }
        }
    }
    places
}

/// The radii of grains, of which there are equally many.
pub(super) const RADII: [f32; 3] = [0.3, 0.4, 0.5];

/// The share of the space that packed balls fill.
const FILLED: f64 = 0.6;

/// How far a grain moves in a frame, in radii.
const GRAIN_CREEP: f32 = 0.02;

/// Balls in a box, as far from their places in a grid as packed balls are.
pub(super) fn grains(count: u32, random: &mut Random) -> Start {
    let ball = |radius: f32| 4.0 / 3.0 * std::f64::consts::PI * f64::from(radius * radius * radius);
    let volume = RADII.map(ball).iter().sum::<f64>() / (RADII.len() as f64 * FILLED);
    let spacing = cube_root(volume) as f32;
    let across = cube_root(f64::from(count)).ceil() as u32;
    let bodies = (0..count).map(|at| {
        let place = [at % across, at / across / across, at / across % across];
        let home = place.map(|step| (step as f32 + random.between(0.3, 0.7)) * spacing);
        let radius = RADII[random.below(RADII.len() as u32) as usize];
        let velocity = direction(GRAIN_CREEP * radius, random);
        Body::near_home([2.0 * radius; 3], home, velocity, [0.2 * spacing; 3])
    });
    Start::steady(bodies.collect())
}
