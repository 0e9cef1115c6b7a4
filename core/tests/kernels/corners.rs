//! The rule of the corner: each pair is reported in one cell, whatever the planes are.

use super::shape::{plant, set_leaf};
use super::{Leaf, Split, plane};
use crate::config::{Capacity, Config, FINE_LEAVES, MOVERS_ONLY};
use crate::geometry::aabb::Aabb;
use crate::geometry::boxes::Boxes;
use crate::geometry::key::key;
use crate::id::Index;
use crate::memory::stats::Path;
use crate::simd::kernels::Kernels;
use crate::world::World;
use bytemuck::{Pod, Zeroable};
use std::vec;
use std::vec::Vec;

/// Corners have the coordinates 0 to 3.
const STEPS: usize = 4;
/// All planes between them, and one that parts nothing.
const PLANES: usize = 3 * STEPS + 1;
/// On emulated processors some planes are enough: the machine code differs, not the rule.
const LESS: usize = if cfg!(target_arch = "x86_64") { 1 } else { 7 };
/// Levels of planes: a cell has up to three sides.
const LEVELS: usize = 3;

#[repr(C, align(64))]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Line([u8; 64]);

/// All boxes whose corners are on the lattice, flat ones and points too.
fn boxes() -> Vec<Aabb> {
    let sides: Vec<[f32; 2]> =
        (0..STEPS).flat_map(|low| (low..STEPS).map(move |high| [low as f32, high as f32])).collect();
    let mut boxes = Vec::new();
    for x in &sides {
        for y in &sides {
            boxes.extend(sides.iter().map(|z| Aabb::new([x[0], y[0], z[0]], [x[1], y[1], z[1]])));
        }
    }
    boxes
}

/// The pairs that were reported, each once.
struct Reported {
    words: Vec<u64>,
    count: usize,
}

impl Reported {
    fn note(&mut self, a: usize, b: usize) -> bool {
        let at = b * (b - 1) / 2 + a;
        let (word, bit) = (&mut self.words[at / 64], 1 << (at % 64));
        let is_new = *word & bit == 0;
        *word |= bit;
        self.count += usize::from(is_new);
        is_new
    }
}

/// Makes the next full step use these planes, one for all nodes of a level, however uneven the leaves are.
fn set_planes(world: &mut World<'_, u16>, levels: [usize; LEVELS]) {
    let parts = &mut world.parts;
    let tree = &mut parts.state.tree;
    plant(&mut parts.tree, tree);
    let planes = levels.into_iter().filter(|number| *number > 0);
    for number in planes {
        let cut = plane((number - 1) % 3, key(((number - 1) / 3) as f32));
        let nodes = tree.count;
        for node in nodes..2 * nodes {
            parts.tree.splits[node as usize] = Split { plane: cut, below: 2 * node };
            parts.tree.parents[node as usize] = node;
            for child in [2 * node, 2 * node + 1] {
                let leaf = (child - 2 * nodes) as usize;
                set_leaf(parts.tree.splits, parts.tree.tops, child as usize, leaf);
            }
        }
        tree.count = 2 * nodes;
    }
    parts.tree.leaves.fill(Leaf::default());
    parts.tree.stuck.fill(1 << 30);
    parts.home.fill(u16::NONE);
    (tree.wait, parts.state.step.kept) = (u8::MAX, 0);
}

#[test]
fn each_pair_is_counted_in_one_cell_for_all_planes_on_a_lattice() {
    let boxes = boxes();
    let count = boxes.len() as u32;
    let capacity = Capacity::for_objects(4096).with_leaf_refs(16 * count).with_pairs(count * count / 2);
    let config =
        Config::new(capacity).with_forced(MOVERS_ONLY, Some(false)).with_forced(FINE_LEAVES, Some(false));
    let bytes = crate::layout::<u16>(&config).unwrap().bytes;
    let mut slab = vec![Line::zeroed(); bytes.div_ceil(64)];
    let mut world = World::<u16>::new_in(bytemuck::cast_slice_mut(&mut slab), &config).unwrap();
    assert_eq!(world.insert_many(Boxes::new(&boxes)).unwrap().len() as u32, count);
    world.step().unwrap();
    let overlapping: Vec<Vec<bool>> =
        boxes.iter().map(|a| boxes.iter().map(|b| a.overlaps(b)).collect()).collect();
    let expected = (0..boxes.len()).map(|b| overlapping[b][..b].iter().filter(|it| **it).count()).sum();
    let kernels: Vec<Kernels> = Kernels::all().collect();
    let mut reported = Reported { words: vec![0; boxes.len() * boxes.len() / 128 + 1], count: 0 };
    let mut used = 0;
    // The order of the levels does not matter: the cells are the same.
    for x in 0..PLANES {
        for y in x..PLANES {
            for z in (y..PLANES).step_by(LESS) {
                set_planes(&mut world, [x, y, z]);
                let step = world.set_kernels(kernels[used % kernels.len()]).step().unwrap();
                used += 1;
                assert_eq!(step.stats().path, Path::Full, "no planes of its own");
                reported.words.fill(0);
                reported.count = 0;
                for [a, b] in step.pairs().iter().map(|pair| pair.map(usize::from)) {
                    assert!(a < b && overlapping[b][a], "planes {x} {y} {z}: {a} and {b} do not meet");
                    assert!(reported.note(a, b), "planes {x} {y} {z}: {a} and {b} twice");
                }
                assert_eq!(reported.count, expected, "planes {x} {y} {z}: a pair is missing");
            }
        }
    }
}
