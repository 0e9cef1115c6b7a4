//! Seeded scenes. The same seed gives the same boxes on every machine: only integers, comparisons and single
//! float operations are used.

use crate::doing;
use trisap_core::Aabb;

/// A small random number generator (SplitMix64), so that scenes do not depend on a crate's version.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// A generator of its own sequence for every seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        doing::drew(seed);
        Self(seed)
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// An integer below `end`, which must not be zero.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// True once in `times` calls on average.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    /// A number of `low..high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        const STEP: f32 = 1.0 / (1 << 24) as f32;
        low + (high - low) * ((self.bits() >> 40) as f32 * STEP)
    }

    /// A point of the cube of `low..high`.
    pub fn point(&mut self, low: f32, high: f32) -> [f32; 3] {
        [(); 3].map(|()| self.between(low, high))
    }

    /// A vector of length one at most.
    pub fn in_ball(&mut self) -> [f32; 3] {
        loop {
            let v = self.point(-1.0, 1.0);
            if v[0] * v[0] + v[1] * v[1] + v[2] * v[2] <= 1.0 {
                return v;
            }
        }
    }
}

/// A box by its lowest corner and its edges.
#[must_use]
pub fn at(min: [f32; 3], edges: [f32; 3]) -> Aabb {
    Aabb::new(min, [0, 1, 2].map(|k| min[k] + edges[k]))
}

/// A unit cube by its lowest corner.
#[must_use]
pub fn cube(x: f32, y: f32, z: f32) -> Aabb {
    at([x, y, z], [1.0; 3])
}

/// A box that reaches over an interval on x and over `0..=1` on y and z: most counterexamples need no more.
#[must_use]
pub fn on_x(min: f32, max: f32) -> Aabb {
    Aabb::new([min, 0.0, 0.0], [max, 1.0, 1.0])
}

/// The box shifted.
#[must_use]
pub fn shifted(aabb: &Aabb, by: [f32; 3]) -> Aabb {
    Aabb::new([0, 1, 2].map(|k| aabb.min[k] + by[k]), [0, 1, 2].map(|k| aabb.max[k] + by[k]))
}

/// Edge of the cube of which `count` unit cubes fill a tenth.
#[must_use]
pub fn side(count: usize) -> f32 {
    (count as f32 * 10.0).cbrt().ceil()
}

/// A scene and what it is called in messages.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What is particular about it.
    pub name: &'static str,
    /// Its boxes.
    pub boxes: Vec<Aabb>,
}

/// Every scene of this module, of about `count` boxes, but no more than 600 identical ones: they all overlap.
#[must_use]
pub fn all(count: usize, seed: u64) -> Vec<Scene> {
    let scene = |name, boxes| Scene { name, boxes };
    vec![
        scene("uniform", uniform(count, seed)),
        scene("clustered", clustered(count, seed)),
        scene("flat in x", flat(count, 0, seed)),
        scene("flat in y", flat(count, 1, seed)),
        scene("flat in z", flat(count, 2, seed)),
        scene("line along x", line(count, 0, seed)),
        scene("line along y", line(count, 1, seed)),
        scene("line along z", line(count, 2, seed)),
        scene("voxel grid", voxels((count as f32).cbrt() as usize)),
        scene("identical", identical(count.min(600))),
        scene("one huge box", one_huge(count, seed)),
        scene("sizes over 1e6", sizes(count, seed)),
        scene("points", points(count, seed)),
    ]
}

/// Unit cubes anywhere in a cube of which they fill a tenth.
#[must_use]
pub fn uniform(count: usize, seed: u64) -> Vec<Aabb> {
    let (mut rng, side) = (Rng::new(seed), side(count));
    (0..count).map(|_| at(rng.point(0.0, side), [1.0; 3])).collect()
}

/// Nine in ten boxes in a small part of the space that the rest fills.
#[must_use]
pub fn clustered(count: usize, seed: u64) -> Vec<Aabb> {
    let (mut rng, side) = (Rng::new(seed), side(count));
    let mut place = || {
        let reach = if rng.once_in(10) { side * 8.0 } else { side };
        at(rng.point(0.0, reach), [1.0; 3])
    };
    (0..count).map(|_| place()).collect()
}

/// Unit cubes that all share one interval on `axis`.
#[must_use]
pub fn flat(count: usize, axis: usize, seed: u64) -> Vec<Aabb> {
    let (mut rng, side) = (Rng::new(seed), (count as f32 * 5.0).sqrt());
    let mut place = || {
        let mut corner = rng.point(0.0, side);
        corner[axis] = 0.0;
        at(corner, [1.0; 3])
    };
    (0..count).map(|_| place()).collect()
}

/// Unit cubes that differ on `axis` only.
#[must_use]
pub fn line(count: usize, axis: usize, seed: u64) -> Vec<Aabb> {
    let mut rng = Rng::new(seed);
    let mut place = || {
        let mut corner = [0.0; 3];
        corner[axis] = rng.between(0.0, count as f32);
        at(corner, [1.0; 3])
    };
    (0..count).map(|_| place()).collect()
}

/// A solid block of unit cubes, `edge` in each direction: neighbours touch, and nearly all keys are equal.
#[must_use]
pub fn voxels(edge: usize) -> Vec<Aabb> {
    let mut boxes = Vec::with_capacity(edge * edge * edge);
    for x in 0..edge {
        for y in 0..edge {
            for z in 0..edge {
                boxes.push(cube(x as f32, y as f32, z as f32));
            }
        }
    }
    boxes
}

/// The same box again and again.
#[must_use]
pub fn identical(count: usize) -> Vec<Aabb> {
    vec![cube(-0.5, -0.5, -0.5); count]
}

/// Unit cubes and one box around them all.
#[must_use]
pub fn one_huge(count: usize, seed: u64) -> Vec<Aabb> {
    let mut boxes = uniform(count, seed);
    let reach = side(count) + 2.0;
    if let Some(huge) = boxes.get_mut(count / 2) {
        *huge = at([-1.0; 3], [reach + 1.0; 3]);
    }
    boxes
}

/// Edges from 1/1024 to 1024, all orders of magnitude alike.
#[must_use]
pub fn sizes(count: usize, seed: u64) -> Vec<Aabb> {
    let (mut rng, side) = (Rng::new(seed), 200.0 * side(count));
    let mut place = || {
        let scale = (1_u32 << rng.below(21)) as f32 / 1024.0;
        let edges = rng.point(0.5, 1.0).map(|share| share * scale);
        at(rng.point(0.0, side), edges)
    };
    (0..count).map(|_| place()).collect()
}

/// Boxes without volume on a lattice: points, segments and squares that meet exactly or not at all.
#[must_use]
pub fn points(count: usize, seed: u64) -> Vec<Aabb> {
    let mut rng = Rng::new(seed);
    let reach = side(count) as usize / 2 + 1;
    let mut place = || {
        let corner = [(); 3].map(|()| rng.below(reach) as f32);
        let mut edges = [(); 3].map(|()| rng.below(2) as f32);
        edges[rng.below(3)] = 0.0;
        at(corner, edges)
    };
    (0..count).map(|_| place()).collect()
}

/// Unit cubes that walk at random without leaving their cube: the Brownian scene of the recordings without a
/// physics engine. Fast motion; each frame, one box in a hundred turns.
#[derive(Clone, Debug)]
pub struct Brownian {
    boxes: Vec<Aabb>,
    velocities: Vec<[f32; 3]>,
    side: f32,
    rng: Rng,
}

impl Brownian {
    /// The first frame of a scene of `count` cubes which fill a tenth of their space.
    #[must_use]
    pub fn new(count: usize, seed: u64) -> Self {
        let mut rng = Rng::new(seed ^ 0xb0);
        let side = side(count);
        // 0.75 sides a second at most, 30 frames a second.
        let velocities = (0..count).map(|_| rng.in_ball().map(|v| v * side * (0.75 / 30.0))).collect();
        Self { boxes: uniform(count, seed), velocities, side, rng }
    }

    /// The current frame.
    #[must_use]
    pub fn boxes(&self) -> &[Aabb] {
        &self.boxes
    }

    /// Goes on to the next frame.
    pub fn advance(&mut self) -> &[Aabb] {
        for (aabb, velocity) in self.boxes.iter_mut().zip(&mut self.velocities) {
            if self.rng.once_in(100) {
                *velocity = self.rng.in_ball().map(|v| v * self.side * (0.75 / 30.0));
            }
            for (low, speed) in aabb.min.iter().zip(velocity.iter_mut()) {
                let next = low + *speed;
                if next < 0.0 || next > self.side {
                    *speed = -*speed;
                }
            }
            *aabb = at([0, 1, 2].map(|k| aabb.min[k] + velocity[k]), [1.0; 3]);
        }
        &self.boxes
    }
}

/// Each frame, the given share of the boxes (in thousandths) moves by `length` at most on each axis.
pub fn walk(boxes: &mut [Aabb], thousandths: usize, length: f32, rng: &mut Rng) {
    for aabb in boxes {
        if rng.below(1000) < thousandths {
            *aabb = shifted(aabb, rng.point(-length, length));
        }
    }
}
