//! The KD-tree (paper, section III): a complete binary tree of axis-aligned planes between minimum corners.
//!
//! * An object is at home in the one leaf whose half-open cell holds its minimum corner (errata E9, E10). Its
//!   record is there, once. A box that reaches beyond the cell is also a straddler there; the leaves that it
//!   reaches find it there (erratum E7).
//! * Planes stay from step to step: what rests never changes its leaf (erratum E8). They are medians of
//!   minima when they are made ([`build`]). Full leaves get new ones, empty ones lose theirs ([`balance`]).
//! * A leaf that would gain nothing from a plane gets none, however full it is (errata E11 and E14).
//! * Each node down to the leaves of a full step has a box around its members. Movers enlarge it; it becomes
//!   tight again after a while ([`refit`]). A look for objects near a box or along a line walks by these
//!   boxes ([`visit`]). Planes only tell where an object is at home.
//!
//! Two children have an even number and the next one; the root is 1. When the whole tree is made, nodes are
//! numbered as in a heap. Later leaves are divided and joined where they stand ([`shape`]).

pub(crate) mod assign;
pub(crate) mod balance;
pub(crate) mod build;
pub(crate) mod cells;
pub(crate) mod enclose;
pub(crate) mod keep;
pub(crate) mod large;
pub(crate) mod limits;
pub(crate) mod refit;
pub(crate) mod relocate;
pub(crate) mod shape;
pub(crate) mod sharpen;
pub(crate) mod subdivide;
pub(crate) mod visit;

pub(crate) use crate::geometry::record::{Frame, Record};
pub(crate) use crate::memory::leaf::{Cell, Leaf, Nodes, Split, Straddler, Straddling, first_of_eight};

use crate::access::Access;
use crate::id::Index;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::slab::TreeParts;
use crate::memory::state::State;
use crate::simd::EIGHT;

/// A plane above all minima: its node is not divided.
pub(crate) const UNSPLIT: i32 = i32::MAX & !AXIS;
/// The low bits of a plane, its axis. Cutting them off the key moves the plane down by an ulp or two, which is
/// right for any plane.
const AXIS: i32 = Split::AXIS;

/// A plane on `axis`: minima at or above it go to the right.
pub(crate) const fn plane(axis: usize, key: i32) -> i32 {
    key & !AXIS | axis as i32
}

pub(crate) const fn axis_of(plane: i32) -> usize {
    // No plane has the fourth value. Cut to the third, it needs no check of the range.
    let axis = (plane & AXIS) as usize;
    if axis > 2 { 2 } else { axis }
}

pub(crate) const fn key_of(plane: i32) -> i32 {
    plane & !AXIS
}

/// A corner, to be compared with planes.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    /// The highest keys that no plane tells apart from the corner's: a whole plane, axis included, compares
    /// with them as its key does with the corner. A fourth key is below what stands for a leaf.
    keys: [i32; 4],
}

impl Corner {
    pub(crate) const fn new([x, y, z]: [i32; 3]) -> Self {
        Self { keys: [x | AXIS, y | AXIS, z | AXIS, i32::MIN] }
    }

    /// Whether the corner is at a plane or above it.
    pub(crate) const fn reaches(&self, plane: i32) -> bool {
        self.keys[(plane & AXIS) as usize] >= plane
    }
}

/// The leaf or sub-leaf that holds a minimum corner.
pub(crate) fn home_of(tree: &TreeParts<'_>, state: &State, min: &[i32; 3]) -> usize {
    home_within(tree, state, leaf_of((tree.splits, state.tree.height), min), min)
}

/// The same where the leaf of a full step is known.
fn home_within(tree: &TreeParts<'_>, state: &State, whole: usize, min: &[i32; 3]) -> usize {
    let part = if state.tree.is_subdivided(whole) { sub_leaf_of(tree.planes, whole, min) } else { 0 };
    whole << state.tree.sub_levels() | part
}

/// The number of the sub-leaf of a whole leaf that holds a minimum corner.
fn sub_leaf_of(planes: &[i32], whole: usize, min: &[i32; 3]) -> usize {
    let planes = planes.span(whole * SUB_LEAVES, SUB_LEAVES);
    let corner = Corner::new(*min);
    (0..SUB_LEVELS).fold(1, |node, _| 2 * node + usize::from(corner.reaches(planes.at(node)))) % SUB_LEAVES
}

/// Planes, and the most of them above a leaf.
pub(crate) type Planes<'p> = (&'p [Split], u16);

/// The leaf of a full step whose cell holds a minimum corner.
#[inline(always)]
pub(crate) fn leaf_of(planes: Planes<'_>, min: &[i32; 3]) -> usize {
    leaves_of(planes, [min])[0]
}

/// The same of some corners. Walks do not wait for each other, and go on in a leaf, since their ends are hard
/// to predict.
#[inline(always)]
pub(crate) fn leaves_of<const N: usize>((splits, height): Planes<'_>, mins: [&[i32; 3]; N]) -> [usize; N] {
    let corners = mins.map(|min| Corner::new(*min));
    let mut here = [splits.at(1); N];
    for _ in 0..height {
        for (split, corner) in here.iter_mut().zip(&corners) {
            *split = splits.at(split.below as usize + usize::from(corner.reaches(split.plane)));
        }
    }
    here.map(|split| split.as_leaf().unwrap_or_default())
}

/// The sub-leaves of a whole leaf: as many as are tested at once.
pub(crate) const SUB_LEAVES: usize = 1 << SUB_LEVELS;
const _: () = assert!(SUB_LEAVES == EIGHT);

/// The bounds of the sub-leaves of a whole leaf, in its frame; `None` while no leaf is divided.
pub(crate) fn sub_leaves_of(bounds: &[Record], sub_levels: u32, whole: usize) -> Option<&[Record; EIGHT]> {
    if sub_levels == 0 { None } else { bounds.as_chunks().0.get(whole) }
}

/// The members of a leaf of new planes, about; twice as many each time that there were too many ghosts.
fn planned(state: &State) -> u64 {
    u64::from(state.objects.live >> state.tree.depth).max(state.setup.forced.leaf_target() as u64 / 2)
        << state.tree.coarser
}

/// The most members of a leaf that is not to be divided.
pub(crate) fn most(state: &State) -> u64 {
    planned(state) * 3 / 2
}

/// Gives the homes of objects other numbers, when leaves of another depth are used. O(slots).
fn renumber<I: Index>(homes: &mut [I], to: impl Fn(u32) -> u32) {
    for home in homes {
        if *home < I::LARGE {
            *home = I::from_slot(to(home.slot()));
        }
    }
}

#[cfg(test)]
#[path = "../../tests/kernels/corners.rs"]
mod tests;
