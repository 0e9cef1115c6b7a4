//! The objects of a scene as they start.

use super::random::Random;
use super::{Objects, Setup};

/// An object as it starts: a box that is not rotated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Full edge lengths along x, y and z.
    pub edges: [f32; 3],
    /// The centre.
    pub position: [f32; 3],
    /// In units a second.
    pub velocity: [f32; 3],
}

/// The objects of a [`Setup`], in order.
#[derive(Clone, Debug)]
pub struct Bodies {
    random: Random,
    objects: Objects,
    radius: f32,
    speed: f32,
    next: u32,
    count: u32,
}

impl Bodies {
    pub(super) fn new(setup: &Setup) -> Self {
        Self {
            random: Random::new(setup.seed, 0),
            objects: setup.objects,
            radius: 0.9 * setup.side() / 2.0,
            speed: setup.speed(),
            next: 0,
            count: setup.count,
        }
    }
}

impl Iterator for Bodies {
    type Item = Body;

    fn next(&mut self) -> Option<Body> {
        if self.next == self.count {
            return None;
        }
        let edges = match self.objects {
            Objects::Cubes => [1.0; 3],
            Objects::Assorted => assorted(self.next, &mut self.random),
        };
        self.next += 1;
        let position = self.random.in_ball(self.radius);
        let velocity = self.random.in_ball(self.speed);
        Some(Body { edges, position, velocity })
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.count - self.next) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for Bodies {}

/// The edges of the object at `index` in Broadmark's assorted mix.
fn assorted(index: u32, random: &mut Random) -> [f32; 3] {
    const THIN: f32 = 0.1;
    const WIDE: f32 = 1.9;
    const BAR: [f32; 2] = [8.0 * WIDE, 4.0 * THIN];
    match index % 80 {
        0..=3 => [5.0 * THIN; 3],
        4..=7 => [WIDE; 3],
        8..=10 => [BAR[0], BAR[1], BAR[1]],
        11 => [BAR[1], BAR[0], BAR[1]],
        12 => [BAR[1], BAR[1], BAR[0]],
        13 => [WIDE, 3.0 * WIDE, THIN],
        14 => [WIDE, THIN, 3.0 * WIDE],
        15 => [THIN, WIDE, 3.0 * THIN],
        16 => [2.0 * WIDE, 2.0 * WIDE, THIN],
        17 => [2.0 * WIDE, THIN, 2.0 * WIDE],
        18 => [THIN, 2.0 * WIDE, 2.0 * WIDE],
        // The factor brings the mean volume of the mix to about 1.
        _ => [(); 3].map(|()| 0.803 * (THIN + random.unit() * (WIDE - THIN))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Kind;
    use super::*;

    #[test]
    fn start_in_the_ball() {
        for objects in Objects::ALL {
            let setup = Setup { kind: Kind::Gravity, objects, count: 500, seed: 3 };
            let length = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
            let bodies = setup.bodies();
            assert_eq!(bodies.len(), 500);
            for body in bodies {
                assert!(length(body.position) <= 0.4501 * setup.side());
                assert!(length(body.velocity) <= 0.7501 * setup.side());
                assert!(body.edges.iter().all(|&edge| (0.08..=15.2).contains(&edge)), "{body:?}");
            }
        }
    }
}
