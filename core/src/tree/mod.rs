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
//! * Each node down to the leaves of a full step has a box around its members, which movers make larger, and which is made
//!   tight again after a while ([`tighten`]): what looks for objects near a box or along a line walks by these boxes, and
//!   planes only tell where an object is at home.
//!
//! Nodes are numbered as in a heap: the root is 1, the children of `i` are `2i` and `2i + 1`; at depth `d` leaf
//! `l` is node `2^d + l`.

pub(crate) mod assign;
pub(crate) mod balance;
pub(crate) mod build;
pub(crate) mod cells;
pub(crate) mod lend;
pub(crate) mod refine;
pub(crate) mod relocate;
pub(crate) mod sharpen;
pub(crate) mod tighten;
pub(crate) mod visit;

use crate::access::Access;
use crate::arch::{EIGHT, MAXIMA, MINIMA, Simd};
use crate::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, value};
use crate::layout::FINER;
use crate::state::State;
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
    let node = below(planes, 1, state.depth, min);
    let whole = node - (1 << state.depth);
    let part = if state.is_refined(whole) { part_of(planes, node, min) } else { 0 };
    whole << state.finer() | part
}

/// Which part of a leaf holds the minimum corner; the leaf is given as a node.
#[inline(always)]
fn part_of(planes: &[i32], node: usize, min: &[i32; 3]) -> usize {
    below(planes, node, FINER, min) - (node << FINER)
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

/// The half-open box of minimum corners that belong to a leaf; `i32::MIN` and `i32::MAX` where unbounded.
///
/// Its numbers stand as the two boxes that one comparison each takes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Cell {
    /// The low sides, and from where on a box of this leaf is a large object: it would be copied into too many leaves.
    from: KeyBox,
    /// The high sides, for minima and for maxima.
    until: KeyBox,
}

impl Cell {
    pub(crate) const ALL: Self = Self::new([i32::MIN; 3], [i32::MAX; 3], [i32::MAX; 3]);

    /// Holds nothing.
    pub(crate) const NOWHERE: Self = Self::new([i32::MAX; 3], [i32::MIN; 3], [i32::MAX; 3]);

    pub(crate) const fn new(low: [i32; 3], high: [i32; 3], far: [i32; 3]) -> Self {
        Self { from: KeyBox { min: low, max: far }, until: KeyBox { min: high, max: high } }
    }

    pub(crate) const fn low(&self) -> [i32; 3] {
        self.from.min
    }

    pub(crate) const fn high(&self) -> [i32; 3] {
        self.until.min
    }

    /// From where on a box is a large object.
    pub(crate) const fn far(&self) -> [i32; 3] {
        self.from.max
    }

    /// Where members are that touch no other cell: at the rim to infinity, beyond which keys are not numbers.
    pub(crate) fn inside(&self) -> KeyBox {
        KeyBox {
            min: self.low().map(|low| low.max(NEGATIVE_INFINITY)),
            max: self.high().map(|high| high.saturating_sub(1).min(POSITIVE_INFINITY)),
        }
    }

    /// Whether a minimum corner is at home here.
    pub(crate) fn holds(&self, min: &[i32; 3]) -> bool {
        (0..3).all(|k| self.low()[k] <= min[k] && min[k] < self.high()[k])
    }

    /// Where a box stands.
    #[inline(always)]
    pub(crate) fn standing<S: Simd>(&self, simd: S, keys: S::Keys) -> Standing {
        let (from, until) = (simd.keys(&self.from), simd.keys(&self.until));
        Standing { before: simd.above(from, keys), inside: simd.above(until, keys) }
    }

    /// The low sides, ready to be compared with boxes.
    #[inline(always)]
    pub(crate) fn low_keys<S: Simd>(&self, simd: S) -> S::Keys {
        simd.keys(&self.from)
    }

    /// The sides that a box from elsewhere must pass to touch this cell.
    #[inline(always)]
    pub(crate) fn entrance<S: Simd>(&self, simd: S) -> S::Keys {
        simd.keys(&KeyBox { min: self.until.min, max: self.from.min })
    }
}

/// Where a box stands in regard to a cell: bits of its keys, as [`Simd::above`] has them.
#[derive(Clone, Copy)]
pub(crate) struct Standing {
    /// Those that do not reach the low sides, or the far ones.
    before: u32,
    /// Those that do not reach the high sides.
    inside: u32,
}

impl Standing {
    /// Whether its minimum corner is at home here.
    #[inline(always)]
    pub(crate) const fn is_home(self) -> bool {
        self.inside & !self.before & MINIMA == MINIMA
    }

    /// Whether the box, if it is at home here, touches other cells.
    #[inline(always)]
    pub(crate) const fn leaves(self) -> bool {
        self.inside & MAXIMA != MAXIMA
    }

    /// Whether the box, if it is at home here, is a large object.
    #[inline(always)]
    pub(crate) const fn is_large(self) -> bool {
        self.before & MAXIMA != MAXIMA
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
    /// The count that the leaf had when its planes were new: what a rebalance can achieve here.
    pub(crate) settled: u32,
    /// The axis that the leaf is swept along.
    pub(crate) axis: u32,
    pub(crate) unused: u32,
}

impl Leaf {
    /// The leaf's records, eight at a time, and how many of them there are from each eight on; behind the last one others make up
    /// the eight: room, or records of the next leaf.
    #[inline(always)]
    pub(crate) fn eights<'r>(&self, records: &'r [Record]) -> Eights<'r> {
        let records = records.span(self.start as usize, (self.len as usize).next_multiple_of(EIGHT));
        Eights { rest: records.as_chunks().0.iter(), left: self.len }
    }
}

/// Leaves that a leaf of a full step may be divided into: as many as are tested at once.
pub(crate) const PARTS: usize = 1 << FINER;
const _: () = assert!(PARTS == EIGHT);

/// The bounds of the parts of a leaf of the last full step, in its frame; `None` where no leaf is divided.
#[inline(always)]
pub(crate) fn parts_of(bounds: &[Record], finer: u32, whole: usize) -> Option<&[Record; EIGHT]> {
    if finer == 0 { None } else { bounds.as_chunks().0.get(whole) }
}

/// See [`Leaf::eights`].
pub(crate) struct Eights<'r> {
    rest: core::slice::Iter<'r, [Record; EIGHT]>,
    left: u32,
}

impl<'r> Iterator for Eights<'r> {
    type Item = (&'r [Record; EIGHT], u32);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let eight = self.rest.next()?;
        let left = self.left;
        // Of the last eight nothing is left, and nobody asks.
        self.left = left.wrapping_sub(EIGHT as u32);
        Some((eight, left))
    }
}

/// Which of eight records are those of a leaf that has so many left: a bit for each.
#[inline(always)]
pub(crate) const fn first_of_eight(left: u32) -> u32 {
    0xff >> 8u32.saturating_sub(left)
}

/// The grid of a leaf's records: 65,536 steps an axis over the part of the cell where minima are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Frame {
    /// Twice the corner, as a box has two corners.
    pub(crate) origin: [f32; 8],
    /// Steps a unit of length, twice as well.
    pub(crate) scale: [f32; 8],
}

/// The last step of a frame's grid.
pub(crate) const GRID_MAX: f32 = 65_535.0;

impl Frame {
    /// Of no leaf.
    pub(crate) const NONE: Self = Self { origin: [0.0; 8], scale: [0.0; 8] };

    /// A frame of an origin and of steps a unit of length.
    pub(crate) const fn new(origin: [f32; 3], scale: [f32; 3]) -> Self {
        const fn twice([x, y, z]: [f32; 3]) -> [f32; 8] {
            [x, y, z, x, y, z, 0.0, 0.0]
        }
        Self { origin: twice(origin), scale: twice(scale) }
    }

    /// What [`new`](Self::new) makes it of.
    pub(crate) const fn parts(&self) -> [[f32; 3]; 2] {
        let ([a, b, c, ..], [d, e, f, ..]) = (self.origin, self.scale);
        [[a, b, c], [d, e, f]]
    }

    /// Whether it maps coordinates to steps in their order, as sweeps need it: wherever its grid lies then, no pair is lost.
    pub(crate) fn is_sound(&self) -> bool {
        let whole = |numbers: &[f32; 8]| numbers[..3] == numbers[3..6] && numbers[6..] == [0.0; 2];
        let finite = |x: &f32| x.abs() <= f32::MAX;
        whole(&self.origin)
            && whole(&self.scale)
            && self.origin.iter().all(finite)
            && self.scale.iter().all(|x| *x >= 0.0 && finite(x))
    }

    /// The grid over the minima between two corners.
    ///
    /// Any monotone map is conservative: it can make apart boxes touch, which the exact test finds, but never the
    /// other way. Maxima beyond the cell land on the last step, above every minimum, so that no tie comes of it.
    pub(crate) fn over(low: [i32; 3], high: [i32; 3]) -> Self {
        let origin = low.map(value);
        let scale = |k: usize| {
            let (low, high) = (origin[k], value(high[k]));
            // A flat cell still needs a step above zero for the maxima; the floor also keeps denormals out, so
            // that a flush-to-zero mode of the host changes nothing.
            let floor = (low.abs().max(high.abs()) * 1e-6).max(1e-24);
            GRID_MAX / (high - low).max(floor).min(f32::MAX)
        };
        Self::new(origin, [scale(0), scale(1), scale(2)])
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

    /// Bounds that everything touches.
    pub(crate) const EVERYTHING: Self = Self { lanes: [0; 6], tag: 0 };
    /// Bounds of nothing.
    pub(crate) const NOTHING: Self = Self { lanes: [u16::MAX; 6], tag: 0 };

    #[inline(always)]
    pub(crate) fn slot(&self) -> u32 {
        self.tag & Self::SLOT
    }

    /// Grows bounds so that they hold another record of the same frame. What touches that, or crosses it, does so with the
    /// bounds: the lower a lane, the more it lets pass.
    #[inline(always)]
    pub(crate) fn include(&mut self, other: &Self) {
        for k in 0..6 {
            self.lanes[k] = self.lanes[k].min(other.lanes[k]);
        }
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
