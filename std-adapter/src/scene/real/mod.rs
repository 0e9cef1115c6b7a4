//! Scenes as games and simulations have them: a ground, a town, sizes over three decades, a spawn point.
//!
//! Broadmark's scenes have boxes of similar size in a closed room. What is hard for a broad phase is mostly elsewhere: one
//! box that is larger than all others together, thousands of boxes in one place, one frame in which all boxes are large.
//! Each [`Kind`] here has one such thing. The boxes move without a physics engine, as those of the other
//! [scenes](super): they pass through each other.
//!
//! Units are metres; y points up; most boxes are cubes with edges of about 1. A frame takes
//! [`FRAME_SECONDS`](super::FRAME_SECONDS). The same [`Setup`] gives the same boxes on every machine.
//!
//! ```
//! use trisap::scene::real::{Kind, Scene, Setup};
//!
//! let mut scene = Scene::new(Setup { kind: Kind::Town, count: 1000, seed: 1 })?;
//! scene.advance();
//! assert_eq!(scene.boxes().len(), 1000);
//! # Ok::<(), trisap::scene::real::BadCount>(())
//! ```

mod body;
mod flat;
mod ground;
mod heaps;
mod kind;
mod level;
mod parking;
mod sizes;
mod sudden;
#[cfg(test)]
mod tests;
mod town;

pub use kind::{Ground, Kind};
pub use sudden::{HITCH_FRAME, SPREAD_FRAMES};

use super::Random;
use crate::Aabb;
use body::Body;
use std::error::Error;
use std::fmt;
use std::ops::RangeInclusive;
use sudden::Sudden;

/// The start of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Setup {
    /// What there is and what happens.
    pub kind: Kind,
    /// How many boxes, grounds and walls included: one of [`Kind::counts`].
    pub count: u32,
    /// Another seed gives other random numbers.
    pub seed: u64,
}

/// A kind of scene that there is not with so many boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadCount {
    /// What was asked for.
    pub setup: Setup,
}

impl fmt::Display for BadCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Setup { kind, count, .. } = self.setup;
        let counts = kind.counts();
        write!(f, "the scene '{kind}' has {} to {} boxes, not {count}", counts.start(), counts.end())
    }
}

impl Error for BadCount {}

/// A scene that moves: [`Scene::boxes`] are the boxes of a frame, [`Scene::advance`] goes to the next.
#[derive(Clone, Debug)]
pub struct Scene {
    setup: Setup,
    frame: u32,
    random: Random,
    bodies: Vec<Body>,
    sudden: Sudden,
    kick: f32,
    boxes: Vec<Aabb>,
}

/// The bodies of a scene as they start, and what happens to them beside their own motion.
#[derive(Debug)]
struct Start {
    bodies: Vec<Body>,
    sudden: Sudden,
    /// One body in a hundred gets a new random velocity in each frame, of so many metres a frame at most; 0: none does.
    kick: f32,
}

impl Start {
    /// Bodies to which nothing happens beside their own motion.
    fn steady(bodies: Vec<Body>) -> Self {
        Self { bodies, sudden: Sudden::Nothing, kick: 0.0 }
    }
}

impl Scene {
    /// The first frame of a scene.
    ///
    /// # Errors
    /// If there is no such scene with so many boxes: see [`Kind::counts`].
    pub fn new(setup: Setup) -> Result<Self, BadCount> {
        let Setup { kind, count, seed } = setup;
        if !kind.counts().contains(&count) {
            return Err(BadCount { setup });
        }
        let mut random = Random::new(seed, 3);
        let Start { bodies, sudden, kick } = match kind {
            Kind::Ground(ground) => ground::start(ground, count, &mut random),
            Kind::Pile => heaps::pile(count, &mut random),
            Kind::Town => town::start(count, &mut random),
            Kind::Level => level::start(count, &mut random),
            Kind::LogNormal => sizes::start(count, &mut random),
            Kind::Grains => heaps::grains(count, &mut random),
            Kind::Bullets => sudden::bullets(count, &mut random),
            Kind::Spawn => sudden::spawn(count, &mut random),
            Kind::Hitch => sudden::hitch(count, &mut random),
            Kind::Flat => flat::start(count, &mut random),
            Kind::Parking => parking::start(count, &mut random),
        };
        let mut scene =
            Self { setup, frame: 0, random: Random::new(seed, 4), bodies, sudden, kick, boxes: Vec::new() };
        scene.boxes = scene.bodies.iter().map(Body::aabb).collect();
        scene.sudden.change(0, &scene.bodies, &mut scene.boxes);
        Ok(scene)
    }

    /// What the scene started from.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The number of this frame; that of the first is 0.
    #[must_use]
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// The boxes of this frame.
    #[must_use]
    pub fn boxes(&self) -> &[Aabb] {
        &self.boxes
    }

    /// Goes to the next frame.
    pub fn advance(&mut self) {
        self.frame += 1;
        self.kick();
        let is_hitch = self.sudden.is_hitch(self.frame);
        for (body, aabb) in self.bodies.iter_mut().zip(&mut self.boxes) {
            if is_hitch {
                *aabb = sudden::swept(body, &mut self.random);
            } else if body.advance(&mut self.random) {
                *aabb = body.aabb();
            }
        }
        self.sudden.change(self.frame, &self.bodies, &mut self.boxes);
    }

    fn kick(&mut self) {
        if self.kick == 0.0 {
            return;
        }
        let count = self.setup.count;
        let more = self.random.below(100) < count % 100;
        for _ in 0..count / 100 + u32::from(more) {
            let at = self.random.below(count) as usize;
            let velocity = self.random.in_ball(self.kick);
            self.bodies[at].kick(velocity);
        }
    }
}

/// The counts of a scene that needs so many boxes at least: as many as a world can hold.
const fn from(least: u32) -> RangeInclusive<u32> {
    least..=1 << 27
}
