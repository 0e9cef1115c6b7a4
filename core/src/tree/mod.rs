//! The KD-tree (paper, section III): a complete binary tree of axis-aligned planes over minimum corners.
//!
//! * An object is at home in the one leaf whose half-open cell holds its minimum corner (errata E9 and E10), and
//!   is stored there once. A box that reaches beyond its cell is also on its leaf's front, where the leaves that
//!   it reaches find it (erratum E7).
//! * Planes stay from step to step, so an object that rests has no reason to change its leaf (erratum E8).
//!   They are medians of existing minima when they are made ([`build`]), and are made anew where leaves have
//!   grown out of balance.
//! * A node that would not gain from a split has a plane that nobody reaches: its objects all go to the left
//!   (errata E11 and E14).
//!
//! Nodes are numbered as in a heap: the root is 1, the children of `i` are `2i` and `2i + 1`; at depth `d` leaf
//! `l` is node `2^d + l`.

pub(crate) mod assign;
pub(crate) mod balance;
pub(crate) mod build;
pub(crate) mod cells;
pub(crate) mod relocate;
pub(crate) mod visit;

use crate::access::Access;
use crate::key::{KeyBox, value};
use bytemuck::{Pod, Zeroable};

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

/// The leaf at `depth` whose cell holds the minimum corner.
#[inline(always)]
pub(crate) fn leaf_of(planes: &[i32], depth: u32, min: &[i32; 3]) -> usize {
    let mut node = 1usize;
    for _ in 0..depth {
        let plane = planes.at(node);
        node = 2 * node + usize::from(min[axis_of(plane)] >= key_of(plane));
    }
    node - (1 << depth)
}

/// The half-open box of minimum corners that belong to a leaf; `i32::MIN` and `i32::MAX` where unbounded.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Cell {
    pub(crate) low: [i32; 3],
    pub(crate) high: [i32; 3],
    /// A box of this leaf that reaches this far is a large object: it would be copied into too many leaves.
    pub(crate) far: [i32; 3],
}

impl Cell {
    pub(crate) const ALL: Self = Self { low: [i32::MIN; 3], high: [i32::MAX; 3], far: [i32::MAX; 3] };

    /// Whether a minimum corner is at home here.
    #[inline(always)]
    pub(crate) fn holds(&self, min: &[i32; 3]) -> bool {
        let mut inside = true;
        for k in 0..3 {
            inside &= self.low[k] <= min[k];
            inside &= min[k] < self.high[k];
        }
        inside
    }

    /// Whether a box that is at home here touches other cells.
    #[inline(always)]
    pub(crate) fn is_left_by(&self, bounds: &KeyBox) -> bool {
        let mut leaves = false;
        for k in 0..3 {
            leaves |= bounds.max[k] >= self.high[k];
        }
        leaves
    }

    /// Whether a box that is at home here is a large object.
    #[inline(always)]
    pub(crate) fn is_dwarfed_by(&self, bounds: &KeyBox) -> bool {
        let mut large = false;
        for k in 0..3 {
            large |= bounds.max[k] > self.far[k];
        }
        large
    }

    /// Whether a box from anywhere touches this cell.
    #[inline(always)]
    pub(crate) fn is_entered_by(&self, bounds: &KeyBox) -> bool {
        let mut touches = true;
        for k in 0..3 {
            touches &= bounds.min[k] < self.high[k];
            touches &= bounds.max[k] >= self.low[k];
        }
        touches
    }
}

/// Where a leaf's members stand.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Leaf {
    /// First record.
    pub(crate) start: u32,
    /// Records.
    pub(crate) len: u32,
    /// Records that would fit before the next leaf's.
    pub(crate) room: u32,
    /// First box of the front.
    pub(crate) front_start: u32,
    /// Boxes of the front.
    pub(crate) front_len: u32,
    /// Objects of this leaf that have moved since the last complete step; kept by movers-only steps.
    pub(crate) movers: u32,
    /// The count that the leaf had when its planes were new: what a rebalance can achieve here.
    pub(crate) settled: u32,
    /// The axis that the leaf is swept along.
    pub(crate) axis: u32,
}

/// The grid of a leaf's records: 65,536 steps an axis over the part of the cell where minima are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Frame {
    pub(crate) origin: [f32; 3],
    pub(crate) scale: [f32; 3],
}

/// The last step of a frame's grid.
pub(crate) const GRID_MAX: f32 = 65_535.0;

impl Frame {
    /// The grid over the minima between two corners.
    ///
    /// Any monotone map is conservative: it can make apart boxes touch, which the exact test finds, but never the
    /// other way. Maxima beyond the cell land on the last step, above every minimum, so that no tie comes of it.
    pub(crate) fn over(low: [i32; 3], high: [i32; 3]) -> Self {
        let mut frame = Self::default();
        for k in 0..3 {
            let (low, high) = (value(low[k]), value(high[k]));
            // A flat cell still needs a step above zero for the maxima; the floor also keeps denormals out, so
            // that a flush-to-zero mode of the host changes nothing.
            let floor = (low.abs().max(high.abs()) * 1e-6).max(1e-24);
            let extent = (high - low).max(floor).min(f32::MAX);
            frame.origin[k] = low;
            frame.scale[k] = GRID_MAX / extent;
        }
        frame
    }
}

/// A box in its leaf's frame: 16 bytes, as four fit into a cache line.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Record {
    /// The minimum, then the complemented maximum: with both falling as boxes shrink, one kind of compare
    /// decides all six lanes.
    pub(crate) lanes: [u16; 6],
    /// The slot, and above it marks: two records that share a mark are not reported here.
    pub(crate) tag: u32,
}

impl Record {
    /// The bits of a tag that hold the slot.
    pub(crate) const SLOT: u32 = (1 << 27) - 1;
    /// The lowest of three marks: the minimum lies below the cell's low side on this axis (erratum E9).
    pub(crate) const BELOW: u32 = 1 << 29;
    /// Marks of the two tiles of a leaf that is too large to be swept at once.
    pub(crate) const TILES: [u32; 2] = [1 << 27, 1 << 28];

    #[inline(always)]
    pub(crate) fn slot(&self) -> u32 {
        self.tag & Self::SLOT
    }
}

/// A box that reaches beyond its leaf, or a large object: exact, since every leaf it enters has its own frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Front {
    pub(crate) bounds: KeyBox,
    pub(crate) slot: u32,
    pub(crate) unused: u32,
}
