//! The KD-tree (paper, section III): a complete binary tree of axis-aligned planes over minimum corners.
//!
//! * An object is at home in the one leaf whose half-open cell holds its minimum corner (errata E9 and E10), and
//!   is stored there once. A box that reaches beyond its cell is also on its leaf's straddlers, where the leaves that
//!   it reaches find it (erratum E7).
//! * Planes stay from step to step, so an object that rests has no reason to change its leaf (erratum E8).
//!   They are medians of existing minima when they are made ([`build`]), and are made anew where leaves have
//!   grown out of balance.
//! * A node that would not gain from a split has a plane that no object reaches: its objects all go to the left
//!   (errata E11 and E14).
//! * Each node down to the leaves of a full step has a box around its members, which movers make larger, and which is made
//!   tight again after a while ([`refit`]): what looks for objects near a box or along a line walks by these boxes, and
//!   planes only tell where an object is at home.
//!
//! Nodes are numbered as in a heap: the root is 1, the children of `i` are `2i` and `2i + 1`; at depth `d` leaf
//! `l` is node `2^d + l`.

pub(crate) mod assign;
pub(crate) mod balance;
pub(crate) mod build;
pub(crate) mod cells;
pub(crate) mod enclose;
pub(crate) mod keep;
pub(crate) mod refit;
pub(crate) mod relocate;
pub(crate) mod sharpen;
pub(crate) mod slack;
pub(crate) mod subdivide;
pub(crate) mod visit;

pub(crate) use crate::geometry::record::{Frame, GRID_MAX, Record};
pub(crate) use crate::memory::leaf::{Cell, ChunksOfEight, Leaf, Straddler, first_of_eight};

use crate::access::Access;
use crate::id::Index;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::state::State;
use crate::simd::EIGHT;

/// The plane that all minima lie below: its node is not split.
pub(crate) const UNSPLIT: i32 = i32::MAX & !AXIS;
/// The low bits of a plane hold its axis. Cutting them off the key moves the plane down by less than an ulp
/// or two, which any plane may do.
const AXIS: i32 = 3;

/// A plane through the minima on `axis`: those at or above it go to the right.
pub(crate) const fn plane(axis: usize, key: i32) -> i32 {
    key & !AXIS | axis as i32
}

/// The axis of a plane.
#[inline(always)]
pub(crate) const fn axis_of(plane: i32) -> usize {
    // The fourth value does not occur; cutting it to the third spares the bounds check.
    let axis = (plane & AXIS) as usize;
    if axis > 2 { 2 } else { axis }
}

/// The key of a plane.
#[inline(always)]
pub(crate) const fn key_of(plane: i32) -> i32 {
    plane & !AXIS
}

/// A corner, to be compared with planes.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    /// The highest keys that no plane tells apart from the corner's: a plane as it is, axis included, compares with them as its
    /// key with the corner. A fourth one spares the look at an axis that does not occur.
    keys: [i32; 4],
}

impl Corner {
    #[inline(always)]
    pub(crate) const fn new([x, y, z]: [i32; 3]) -> Self {
        Self { keys: [x | AXIS, y | AXIS, z | AXIS, i32::MIN] }
    }

    /// Whether it is at a plane or above it.
    #[inline(always)]
    pub(crate) const fn reaches(&self, plane: i32) -> bool {
        self.keys[(plane & AXIS) as usize] >= plane
    }
}

/// The leaf whose cell holds the minimum corner, where some leaves of the last full step may be divided.
#[inline(always)]
pub(crate) fn home_of(planes: &[i32], state: &State, min: &[i32; 3]) -> usize {
    let node = below(planes, 1, state.tree.depth, min);
    let whole = node - (1 << state.tree.depth);
    let part = if state.tree.is_subdivided(whole) { sub_leaf_of(planes, node, min) } else { 0 };
    whole << state.tree.sub_levels() | part
}

/// Which part of a leaf holds the minimum corner; the leaf is given as a node.
#[inline(always)]
fn sub_leaf_of(planes: &[i32], node: usize, min: &[i32; 3]) -> usize {
    below(planes, node, SUB_LEVELS, min) - (node << SUB_LEVELS)
}

/// The leaf at `depth` whose cell holds the minimum corner.
#[inline(always)]
pub(crate) fn leaf_of(planes: &[i32], depth: u32, min: &[i32; 3]) -> usize {
    below(planes, 1, depth, min) - (1 << depth)
}

/// The node so many levels below another whose cell holds the minimum corner.
#[inline(always)]
fn below(planes: &[i32], mut node: usize, levels: u32, min: &[i32; 3]) -> usize {
    let corner = Corner::new(*min);
    let reaches = |node: usize| usize::from(corner.reaches(planes.at(node)));
    // Two levels at a time: the planes of both children are compared before it is known which one it is.
    for _ in 0..levels / 2 {
        let (right, below) = (reaches(node), [reaches(2 * node), reaches(2 * node + 1)]);
        // Cutting it to one bit spares the check of the range.
        node = 4 * node + 2 * right + below[right & 1];
    }
    if levels & 1 == 1 {
        node = 2 * node + reaches(node);
    }
    node
}

/// Leaves that a leaf of a full step may be divided into: as many as are tested at once.
pub(crate) const SUB_LEAVES: usize = 1 << SUB_LEVELS;
const _: () = assert!(SUB_LEAVES == EIGHT);

/// The bounds of the parts of a leaf of the last full step, in its frame; `None` where no leaf is divided.
#[inline(always)]
pub(crate) fn sub_leaves_of(bounds: &[Record], sub_levels: u32, whole: usize) -> Option<&[Record; EIGHT]> {
    if sub_levels == 0 { None } else { bounds.as_chunks().0.get(whole) }
}

/// Whether the leaves at a depth may look at so many large objects each: with more, larger leaves cost less.
fn are_few(large: u64, depth: u32, live: u32) -> bool {
    large << depth <= 8 * u64::from(live)
}

/// Gives the home leaves of objects other numbers, where the leaves of another depth are used. O(slots).
fn renumber<I: Index>(homes: &mut [I], to: impl Fn(u32) -> u32) {
    for home in homes {
        if *home < I::LARGE {
            *home = I::from_slot(to(home.slot()));
        }
    }
}

#[cfg(test)]
mod tests;
