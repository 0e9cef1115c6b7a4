//! Boxes that move without a physics engine.

use super::random::Random;
use super::{FRAME_SECONDS, Gravity, Kind, Setup};
use crate::Aabb;

/// A scene that moves: [`Synthetic::boxes`] are the boxes of a frame, [`Synthetic::advance`] goes to the next.
#[derive(Clone, Debug)]
pub struct Synthetic {
    setup: Setup,
    random: Random,
    gravity: Gravity,
    movers: Vec<Mover>,
    boxes: Vec<Aabb>,
}

/// A box that bounces between walls of its own.
#[derive(Clone, Copy, Debug)]
struct Mover {
    /// Half the extents of the bounding box.
    half: [f32; 3],
    /// Where its centre can be.
    low: [f32; 3],
    high: [f32; 3],
    position: [f32; 3],
    velocity: [f32; 3],
    resting: bool,
}

impl Synthetic {
    /// The first frame of a scene.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let mut random = Random::new(setup.seed, 1);
        let half_side = setup.side() / 2.0;
        let spread = spread(setup.kind).map(|share| share * setup.side());
        let movers: Vec<_> = setup
            .bodies()
            .map(|body| {
                let half = half_extents(body.edges, random.rotation());
                let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
                for k in 0..3 {
                    let inset = random.unit() * spread[k];
                    low[k] = inset + half[k] - half_side;
                    high[k] = half_side - half[k] - (spread[k] - inset);
                    // A box that is too long for the cube stays in its middle.
                    if low[k] > high[k] {
                        (low[k], high[k]) = (0.0, 0.0);
                    }
                }
                let position = [0, 1, 2].map(|k| body.position[k].clamp(low[k], high[k]));
                Mover { half, low, high, position, velocity: body.velocity, resting: false }
            })
            .collect();
        let boxes = movers.iter().map(Mover::aabb).collect();
        Self { setup, random: Random::new(setup.seed, 2), gravity: setup.gravity(), movers, boxes }
    }

    /// What the scene started from.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The boxes of this frame.
    #[must_use]
    pub fn boxes(&self) -> &[Aabb] {
        &self.boxes
    }

    /// Goes to the next frame.
    pub fn advance(&mut self) {
        for (object, velocity) in self.setup.kicks(&mut self.random) {
            self.movers[object].velocity = velocity;
        }
        let gravity = self.gravity.next().unwrap_or_default();
        for (mover, aabb) in self.movers.iter_mut().zip(&mut self.boxes) {
            if !mover.resting {
                mover.advance(self.setup.kind, gravity);
                *aabb = mover.aabb();
            }
        }
    }
}

/// How far apart, in sides of the cube, the walls of different boxes are: the thickness of a pile in which the boxes
/// take about a third of the volume. It lies on one wall in free fall, and in a corner where gravity turns.
fn spread(kind: Kind) -> [f32; 3] {
    match kind {
        Kind::Brownian => [0.0; 3],
        Kind::FreeFall => [0.0, 0.3, 0.0],
        Kind::Gravity => [0.6; 3],
    }
}

impl Mover {
    fn aabb(&self) -> Aabb {
        Aabb::new(
            [0, 1, 2].map(|k| self.position[k] - self.half[k]),
            [0, 1, 2].map(|k| self.position[k] + self.half[k]),
        )
    }

    fn advance(&mut self, kind: Kind, gravity: [f32; 3]) {
        // What is left of the speed after a bounce.
        let rebound = match kind {
            Kind::Brownian => 1.0,
            Kind::FreeFall | Kind::Gravity => 0.4,
        };
        for (k, pull) in gravity.into_iter().enumerate() {
            self.velocity[k] += pull * FRAME_SECONDS;
            let (low, high) = (self.low[k], self.high[k]);
            let goal = self.position[k] + self.velocity[k] * FRAME_SECONDS;
            let (bounced, wall) = if goal < low {
                (true, low)
            } else if goal > high {
                (true, high)
            } else {
                (false, goal)
            };
            if bounced {
                // As far back as it went through the wall, but not through the other wall.
                self.position[k] = (wall + (wall - goal) * rebound).clamp(low, high);
                self.velocity[k] *= -rebound;
            } else {
                self.position[k] = goal;
            }
        }
        if kind == Kind::FreeFall {
            self.settle(-gravity[1]);
        }
    }

    /// Comes to rest on the floor once a bounce is as small as a frame of falling.
    fn settle(&mut self, strength: f32) {
        let step = strength * FRAME_SECONDS;
        let on_floor = self.position[1] - self.low[1] < step * FRAME_SECONDS;
        if on_floor && self.velocity[1].abs() <= step {
            self.position[1] = self.low[1];
            self.velocity[1] = 0.0;
            // Friction.
            self.velocity[0] *= 0.5;
            self.velocity[2] *= 0.5;
            self.resting = self.velocity[0].abs().max(self.velocity[2].abs()) <= step;
        }
    }
}

/// Half the extents of the bounding box of a box with these edges, rotated by a unit quaternion.
fn half_extents(edges: [f32; 3], [x, y, z, w]: [f32; 4]) -> [f32; 3] {
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    rows.map(|row| row.iter().zip(edges).map(|(cell, edge)| cell.abs() * edge).sum::<f32>() / 2.0)
}

#[cfg(test)]
mod tests {
    use super::super::Objects;
    use super::*;

    fn setups() -> impl Iterator<Item = Setup> {
        Kind::ALL.into_iter().flat_map(|kind| {
            Objects::ALL.into_iter().flat_map(move |objects| {
                [1, 2, 700].into_iter().map(move |count| Setup { kind, objects, count, seed: 11 })
            })
        })
    }

    #[test]
    fn the_same_seed_gives_the_same_boxes() {
        for setup in setups() {
            let (mut a, mut b) = (Synthetic::new(setup), Synthetic::new(setup));
            let mut other = Synthetic::new(Setup { seed: 12, ..setup });
            for _ in 0..20 {
                assert_eq!(a.boxes(), b.boxes());
                assert_ne!(a.boxes(), other.boxes());
                a.advance();
                b.advance();
                other.advance();
            }
        }
    }

    /// FNV-1a over the bits of all boxes.
    fn hash(boxes: &[Aabb]) -> u64 {
        let words = boxes.iter().flat_map(|aabb| aabb.min.into_iter().chain(aabb.max));
        words
            .flat_map(f32::to_le_bytes)
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    #[test]
    fn the_boxes_are_those_of_all_releases_and_platforms() {
        let hashes = Kind::ALL.map(|kind| {
            let mut scene = Synthetic::new(Setup { kind, objects: Objects::Assorted, count: 300, seed: 9 });
            for _ in 0..100 {
                scene.advance();
            }
            hash(scene.boxes())
        });
        assert_eq!(hashes, [0x79f4_b19c_c776_af42, 0x9970_6ed1_a094_00a5, 0x9672_8a92_2130_5219]);
    }

    #[test]
    fn boxes_are_valid_and_inside() {
        for setup in setups() {
            let mut scene = Synthetic::new(setup);
            let world = setup.world();
            let room = setup.side();
            for _ in 0..300 {
                assert_eq!(scene.boxes().len(), setup.count as usize);
                for aabb in scene.boxes() {
                    assert!(aabb.is_valid(), "{aabb:?}");
                    for k in 0..3 {
                        let fits = aabb.max[k] - aabb.min[k] <= 0.3 * room;
                        let inside = aabb.min[k] >= world.min[k] - 1e-3 && aabb.max[k] <= world.max[k] + 1e-3;
                        assert!(inside || !fits, "{setup:?}: {aabb:?}");
                    }
                }
                scene.advance();
            }
        }
    }

    #[test]
    fn free_fall_comes_to_rest_and_the_others_do_not() {
        for (kind, at_rest) in [(Kind::Brownian, false), (Kind::FreeFall, true), (Kind::Gravity, false)] {
            let mut scene = Synthetic::new(Setup { kind, objects: Objects::Cubes, count: 500, seed: 5 });
            for _ in 0..400 {
                scene.advance();
            }
            let before = scene.boxes().to_vec();
            scene.advance();
            let moved = before.iter().zip(scene.boxes()).filter(|(a, b)| a != b).count();
            assert_eq!(moved == 0, at_rest, "{kind:?}: {moved} moved");
        }
    }

    #[test]
    fn pairs_are_as_many_as_in_recordings() {
        for (kind, range) in
            [(Kind::Brownian, 0.8..4.0), (Kind::FreeFall, 2.0..8.0), (Kind::Gravity, 1.5..12.0)]
        {
            let mut scene = Synthetic::new(Setup { kind, objects: Objects::Cubes, count: 1000, seed: 5 });
            for _ in 0..200 {
                scene.advance();
            }
            let boxes = scene.boxes();
            let pairs = (0..boxes.len())
                .map(|a| boxes[a + 1..].iter().filter(|b| b.overlaps(&boxes[a])).count())
                .sum::<usize>();
            let per_object = pairs as f64 / boxes.len() as f64;
            assert!(range.contains(&per_object), "{kind:?}: {per_object}");
        }
    }
}
