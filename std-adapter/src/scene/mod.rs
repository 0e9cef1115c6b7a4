//! Scenes of moving boxes, the same on every machine for the same seed.
//!
//! A [`Setup`] describes the start of a scene: boxes that fill 10 % of a walled cube, in a ball of 0.9 of its half
//! side, with speeds in a ball of 0.75 sides a second (the scenes of Serpa and Rodrigues' Broadmark). Rigid-body
//! engines can start from its [bodies](Setup::bodies).
//!
//! [`Synthetic`] moves them without such an engine, at a few nanoseconds a box, so that a scene may have millions.
//! It is no rigid-body simulation: boxes pass through each other and do not spin. Each box has walls of its own,
//! so that boxes that have fallen fill a pile instead of a plane. Pairs per object are of the order that a real
//! simulation gives, their coherence is not; to measure on real motion, record a simulation.
//!
//! [`real`] has the scenes of games and simulations: a ground, a town, sizes over three decades, a spawn point and others.

mod bodies;
mod gravity;
mod random;
pub mod real;
mod synthetic;

pub use bodies::{Bodies, Body};
pub use gravity::Gravity;
pub use random::Random;
pub use synthetic::Synthetic;

use crate::Aabb;

/// Seconds from one frame to the next.
pub const FRAME_SECONDS: f32 = 1.0 / 30.0;

/// What happens in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// No gravity; in each frame one object in a hundred gets a new random speed.
    Brownian,
    /// Objects fall and come to rest.
    FreeFall,
    /// Four times the gravity, whose direction turns (once in 6.2 s): everything piles up and moves.
    Gravity,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Brownian, Self::FreeFall, Self::Gravity];

    /// The name in recordings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Brownian => "Brownian",
            Self::FreeFall => "FreeFall",
            Self::Gravity => "Gravity",
        }
    }
}

/// Which boxes there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Objects {
    /// Unit cubes.
    Cubes,
    /// A mix of cubes, bars, planks, squares and random boxes that repeats every 80 objects, with edges from 0.1 to
    /// 15.2 and a mean volume of about 1.
    Assorted,
}

impl Objects {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Cubes, Self::Assorted];

    /// The name in recordings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cubes => "Cubes",
            Self::Assorted => "Assorted",
        }
    }
}

/// The start of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Setup {
    /// What happens.
    pub kind: Kind,
    /// Which boxes there are.
    pub objects: Objects,
    /// How many of them.
    pub count: u32,
    /// Another seed gives other random numbers.
    pub seed: u64,
}

impl Setup {
    /// The side of the walled cube: one object per ten units of volume.
    #[must_use]
    pub fn side(&self) -> f32 {
        cube_root(10.0 * f64::from(self.count)) as f32
    }

    /// The walled cube; its centre is the origin.
    #[must_use]
    pub fn world(&self) -> Aabb {
        let half = self.side() / 2.0;
        Aabb::new([-half; 3], [half; 3])
    }

    /// The largest start speed in units a second.
    #[must_use]
    pub fn speed(&self) -> f32 {
        0.75 * self.side()
    }

    /// The objects as they start, in order.
    #[must_use]
    pub fn bodies(&self) -> Bodies {
        Bodies::new(self)
    }

    /// The strength of the gravity in units a second squared.
    #[must_use]
    pub fn gravity_strength(&self) -> f32 {
        match self.kind {
            Kind::Brownian => 0.0,
            Kind::FreeFall => 0.0981 * self.side(),
            Kind::Gravity => 4.0 * 0.0981 * self.side(),
        }
    }

    /// The gravity of one frame after another, without end.
    #[must_use]
    pub fn gravity(&self) -> Gravity {
        Gravity {
            strength: self.gravity_strength(),
            turns: self.kind == Kind::Gravity,
            down: [0.0, -1.0, 0.0],
            axis: [1.0, 0.0, 0.0],
        }
    }

    /// The objects of [`Kind::Brownian`] that get a new speed in a frame, and that speed. Nothing in other scenes.
    pub fn kicks(&self, random: &mut Random) -> impl Iterator<Item = (usize, [f32; 3])> {
        let count = if self.kind == Kind::Brownian { self.count } else { 0 };
        let (hundreds, rest) = (count / 100, count % 100);
        let more = rest > 0 && random.below(100) < rest;
        let speed = self.speed();
        (0..hundreds + u32::from(more)).map(move |_| {
            let object = random.below(count) as usize;
            (object, random.in_ball(speed))
        })
    }
}

/// Newton's method: unlike the maths library, it gives the same bits on every platform.
fn cube_root(x: f64) -> f64 {
    let mut root = x.max(1.0);
    for _ in 0..100 {
        root = (2.0 * root + x / (root * root)) / 3.0;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(kind: Kind) -> Setup {
        Setup { kind, objects: Objects::Cubes, count: 1000, seed: 1 }
    }

    #[test]
    fn boxes_fill_a_tenth() {
        assert!((setup(Kind::Brownian).side() - 21.544_35).abs() < 1e-4);
        let assorted = Setup { objects: Objects::Assorted, count: 80_000, ..setup(Kind::Brownian) };
        let volume: f64 = assorted.bodies().map(|body| f64::from(body.edges.iter().product::<f32>())).sum();
        let share = volume / f64::from(assorted.side()).powi(3);
        assert!((0.095..0.105).contains(&share), "{share}");
    }

    #[test]
    fn gravity_turns_and_keeps_its_strength() {
        let scene = setup(Kind::Gravity);
        let strength = scene.gravity_strength();
        let mut lows = [0.0_f32; 3];
        let mut highs = [0.0_f32; 3];
        for direction in scene.gravity().take(2000) {
            let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((length / strength - 1.0).abs() < 1e-5);
            for k in 0..3 {
                lows[k] = lows[k].min(direction[k] / strength);
                highs[k] = highs[k].max(direction[k] / strength);
            }
        }
        assert!(
            lows.iter().all(|&low| low < -0.6) && highs.iter().all(|&high| high > 0.6),
            "{lows:?} {highs:?}"
        );
        assert!(setup(Kind::FreeFall).gravity().take(9).all(|g| g[0] == 0.0 && g[1] < 0.0 && g[2] == 0.0));
        assert!(setup(Kind::Brownian).gravity().take(9).all(|g| g == [0.0; 3]));
    }

    #[test]
    fn one_in_a_hundred_is_kicked() {
        let scene = Setup { count: 150, ..setup(Kind::Brownian) };
        let mut random = Random::new(1, 1);
        let counts: Vec<_> = (0..1000).map(|_| scene.kicks(&mut random).count()).collect();
        assert!(counts.iter().all(|&count| count == 1 || count == 2));
        let mean = counts.iter().sum::<usize>() as f64 / 1000.0;
        assert!((1.4..1.6).contains(&mean), "{mean}");
        assert_eq!(setup(Kind::FreeFall).kicks(&mut random).count(), 0);
    }
}
