//! What is sudden: bullets, a spawn, a hitch.

use super::super::cube_root;
use super::body::{Body, Motion, direction, point, room};
use super::{Random, Start};
use crate::Aabb;

/// The frame from which on the cubes of a spawn are spread; the first frame is 0.
pub const SPREAD_FRAMES: u32 = 4;

/// The one frame of a hitch in which all boxes are large; the first frame is 0.
pub const HITCH_FRAME: u32 = 10;

/// How many frames a hitch takes.
const HITCH_STEPS: u32 = 24;

/// How far a cube moves in a frame at most.
const PACE: f32 = 0.75;

/// All pairs of a place overlap when boxes are spawned there: 8,192 have 33,550,336 pairs.
const MOST_IN_A_PLACE: u32 = 8192;
pub(super) const MOST_SPAWNED: u32 = 8 * MOST_IN_A_PLACE;

/// One object in so many is a bullet.
const BULLETS: u32 = 20;

/// Least and greatest length that a bullet flies in a frame: at 30 frames a second, 100 to 300 m/s.
const FLIGHT: [f32; 2] = [10.0 / 3.0, 10.0];

/// What happens to all bodies at once.
#[derive(Clone, Debug)]
pub(super) enum Sudden {
    Nothing,
    /// Bodies come out of these places, each with as many as the others.
    Spawn(Vec<[f32; 3]>),
    Hitch,
}

impl Sudden {
    pub(super) fn is_hitch(&self, frame: u32) -> bool {
        matches!(self, Self::Hitch) && frame == HITCH_FRAME
    }

    /// Puts spawned boxes where they are on their way out.
    pub(super) fn change(&self, frame: u32, bodies: &[Body], boxes: &mut [Aabb]) {
        let Self::Spawn(places) = self else { return };
        if frame >= SPREAD_FRAMES {
            return;
        }
        let share = frame as f32 / SPREAD_FRAMES as f32;
        let a_place = bodies.len().div_ceil(places.len());
        for (at, (body, aabb)) in bodies.iter().zip(boxes).enumerate() {
            let from = places[at / a_place];
            let centre = [0, 1, 2].map(|k| from[k] + share * (body.centre[k] - from[k]));
            *aabb = Body { centre, ..*body }.aabb();
        }
    }
}

/// The box of all that a body passes in a hitch; the body is at its end then.
pub(super) fn swept(body: &mut Body, random: &mut Random) -> Aabb {
    let mut all = body.aabb();
    for _ in 0..HITCH_STEPS {
        body.advance(random);
        let now = body.aabb();
        for k in 0..3 {
            all.min[k] = all.min[k].min(now.min[k]);
            all.max[k] = all.max[k].max(now.max[k]);
        }
    }
    all
}

/// The side of the room of which so many cubes fill a tenth.
fn side(count: u32) -> f32 {
    cube_root(10.0 * f64::from(count)) as f32
}

fn cube(side: f32, random: &mut Random) -> Body {
    let centre = point(room(side), random);
    Body::walking([1.0; 3], centre, random.in_ball(PACE), room(side))
}

fn cubes(count: u32, random: &mut Random) -> Vec<Body> {
    let side = side(count);
    (0..count).map(|_| cube(side, random)).collect()
}

pub(super) fn bullets(count: u32, random: &mut Random) -> Start {
    // In a smaller room every bullet would pass from wall to wall.
    let side = side(count).max(FLIGHT[1]);
    let bodies =
        (0..count).map(|at| if at % BULLETS == 0 { bullet(side, random) } else { cube(side, random) });
    Start { bodies: bodies.collect(), sudden: Sudden::Nothing, kick: PACE }
}

fn bullet(side: f32, random: &mut Random) -> Body {
    let (low, high) = room(side);
    let length = random.between(FLIGHT[0], FLIGHT[1]);
    let mut velocity = direction(length, random);
    // Players shoot at what is about as high as they are.
    velocity[1] *= 0.1;
    Body { half: [0.05; 3], centre: point((low, high), random), motion: Motion::Fly { velocity, low, high } }
}

pub(super) fn spawn(count: u32, random: &mut Random) -> Start {
    let bodies = cubes(count, random);
    let places = count.div_ceil(MOST_IN_A_PLACE);
    let places = (0..places).map(|_| point(room(side(count)), random)).collect();
    Start { bodies, sudden: Sudden::Spawn(places), kick: PACE }
}

pub(super) fn hitch(count: u32, random: &mut Random) -> Start {
    Start { bodies: cubes(count, random), sudden: Sudden::Hitch, kick: PACE }
}
