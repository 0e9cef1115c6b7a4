//! What is stepped through: recorded frames, and boxes that are made.

use trisap_core::{Aabb, Boxes};

/// The start of a file of the repository.
const fn start<const N: usize>(bytes: &[u8]) -> [u8; N] {
    match bytes.first_chunk() {
        Some(start) => *start,
        None => panic!("too short a file"),
    }
}

/// Before the boxes of a recording.
const HEADER: usize = 304;
/// Two corners of four floats.
const BOX: usize = 32;

const fn length(objects: usize, frames: usize) -> usize {
    HEADER + frames * objects * BOX
}

// As many frames as the ROM has room for.
static FREEFALL: [u8; length(1000, 10)] = start(include_bytes!("../../recordings/freefall_cubes_1000.aabbs"));
static GRAVITY: [u8; length(1000, 5)] = start(include_bytes!("../../recordings/gravity_assorted_1000.aabbs"));
static BROWNIAN: [u8; length(8000, 2)] = start(include_bytes!("../../recordings/brownian_cubes_8000.aabbs"));

/// The recordings: name, number of objects, bytes of the file.
pub(crate) const RECORDINGS: [(&str, usize, &[u8]); 3] = [
    ("freefall_cubes_1000", 1000, &FREEFALL),
    ("gravity_assorted_1000", 1000, &GRAVITY),
    ("brownian_cubes_8000", 8000, &BROWNIAN),
];

/// The frames of a recording.
pub(crate) fn frames(objects: usize, bytes: &[u8]) -> impl Iterator<Item = Boxes<'_>> {
    let frames = bytes.get(HEADER..).unwrap_or_default();
    frames.chunks_exact(objects * BOX).filter_map(|frame| Boxes::strided(frame, BOX, BOX / 2))
}

/// Boxes that are made: a name, how many, and the box of a number.
pub(crate) type Scene = (&'static str, usize, fn(&mut Random, usize) -> Aabb);

/// All of them. Most are hard on some part of the sweep; the first few are large enough for a tree.
pub(crate) const SCENES: [Scene; 12] = [
    ("uniform", 5000, |random, _| cube(random.point(0.0, 36.0))),
    ("clustered", 3000, |random, index| cube(random.point(0.0, if index % 10 == 0 { 240.0 } else { 30.0 }))),
    ("one huge box", 3000, |random, index| {
        if index == 7 { Aabb::new([-1.0; 3], [32.0; 3]) } else { cube(random.point(0.0, 31.0)) }
    }),
    ("sizes over 1e6", 3000, |random, _| {
        let scale = (1 << random.below(21)) as f32 / 1024.0;
        at(random.point(0.0, 6000.0), random.point(0.5, 1.0).map(|share| share * scale))
    }),
    ("flat in z", 2000, |random, _| {
        let [x, y, _] = random.point(0.0, 100.0);
        cube([x, y, 0.0])
    }),
    ("line along y", 2000, |random, _| cube([0.0, random.point(0.0, 2000.0)[1], 0.0])),
    // Neighbours touch, so that the records tie.
    ("solid block", 2744, |_, index| cube([index % 14, index / 14 % 14, index / 196].map(|x| x as f32))),
    ("points on a lattice", 2000, |random, _| {
        let edges = [random.below(2), 0, random.below(2)].map(|edge| edge as f32);
        at([(); 3].map(|()| random.below(12) as f32), edges)
    }),
    // More than one bag, and pairs in every window.
    ("identical", 300, |_, _| cube([-0.5; 3])),
    ("many in one place", 2500, |random, _| at(random.point(0.0, 8.0), [0.2, 7.0, 0.2])),
    ("infinite", 1500, |random, index| {
        let mut aabb = cube(random.point(-20.0, 20.0));
        if index % 50 == 0 {
            aabb.min[index % 3] = f32::NEG_INFINITY;
            aabb.max[index / 50 % 3] = f32::INFINITY;
        }
        aabb
    }),
    ("small world", 200, |random, _| cube(random.point(0.0, 12.0))),
];

fn at(min: [f32; 3], edges: [f32; 3]) -> Aabb {
    Aabb::new(min, [0, 1, 2].map(|k| min[k] + edges[k]))
}

fn cube(min: [f32; 3]) -> Aabb {
    at(min, [1.0; 3])
}

/// Moves boxes from one step to the next: all a little, one in a hundred, one in ten to anywhere, none.
pub(crate) fn advance(boxes: &mut [Aabb], step: usize, random: &mut Random) {
    let (one_in, reach) = [(1, 0.3), (100, 1.0), (100, 0.5), (10, 20.0), (usize::MAX, 0.0)][step % 5];
    for aabb in boxes {
        if random.below(one_in) == 0 {
            let by = random.point(-reach, reach);
            *aabb = Aabb::new([0, 1, 2].map(|k| aabb.min[k] + by[k]), [0, 1, 2].map(|k| aabb.max[k] + by[k]));
        }
    }
}

/// Xorshift.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 16) % end as u64) as usize
    }

    /// A point of the cube of `low..high`.
    pub(crate) fn point(&mut self, low: f32, high: f32) -> [f32; 3] {
        [(); 3].map(|()| low + (high - low) * self.below(1 << 24) as f32 / (1 << 24) as f32)
    }
}
