//! The items of a leaf in the slab: its cell, where its records are, and its straddlers.

use super::limits::LEVELS;
use crate::access::Access;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY};
use crate::geometry::record::Record;
use crate::simd::{EIGHT, MAXIMA, MINIMA, Simd};
use bytemuck::{Pod, Zeroable};

/// The cell of a leaf: the half-open box of the minimum corners that are at home there. Sides without bounds
/// are `i32::MIN` and [`Cell::RIM`].
///
/// Its numbers are stored as two boxes, since two comparisons of six keys each tell all about a box.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Cell {
    /// The low sides; and for maxima, from where on a box of this leaf is a large object.
    from: KeyBox,
    /// The high sides, for minima and for maxima alike.
    until: KeyBox,
}

impl Cell {
    /// Beyond all boxes, but not beyond empty ones, which are at home in no cell.
    pub(crate) const RIM: i32 = POSITIVE_INFINITY + 1;

    pub(crate) const ALL: Self = Self::new([i32::MIN; 3], [Self::RIM; 3], [Self::RIM; 3]);

    pub(crate) const fn new(low: [i32; 3], high: [i32; 3], far: [i32; 3]) -> Self {
        Self { from: KeyBox { min: low, max: far }, until: KeyBox { min: high, max: high } }
    }

    pub(crate) const fn low(&self) -> [i32; 3] {
        self.from.min
    }

    pub(crate) const fn high(&self) -> [i32; 3] {
        self.until.min
    }

    /// A box whose maximum is at or beyond this on any axis is a large object.
    pub(crate) const fn far(&self) -> [i32; 3] {
        self.from.max
    }

    /// Where members lie that touch no other cell. Infinite at the rim, since keys beyond are not numbers.
    pub(crate) fn inside(&self) -> KeyBox {
        KeyBox {
            min: self.low().map(|low| low.max(NEGATIVE_INFINITY)),
            max: self.high().map(|high| high.saturating_sub(1).min(POSITIVE_INFINITY)),
        }
    }

    #[inline(always)]
    pub(crate) fn classify<S: Simd>(&self, simd: S, keys: S::Keys) -> Classification {
        let (from, until) = (simd.keys(&self.from), simd.keys(&self.until));
        Classification { before: simd.above(from, keys), inside: simd.above(until, keys) }
    }

    /// The low sides, to be compared with boxes, and those that decide whether a box from another leaf touches
    /// this cell.
    #[inline(always)]
    pub(crate) fn entrance<S: Simd>(&self, simd: S) -> [S::Keys; 2] {
        [self.from, KeyBox { min: self.until.min, max: self.from.min }].map(|sides| simd.keys(&sides))
    }
}

/// How a box lies to a cell: bits of its keys, as in [`Simd::above`].
#[derive(Clone, Copy)]
pub(crate) struct Classification {
    /// Minima below the low sides, and maxima that do not reach the far ones.
    before: u32,
    /// Minima and maxima below the high sides.
    inside: u32,
}

impl Classification {
    /// Whether its minimum corner is at home here, and the box is no large object.
    pub(crate) const fn is_member(self) -> bool {
        // Both in one comparison.
        self.before << 3 | self.inside & MINIMA == MAXIMA << 3 | MINIMA
    }

    /// Whether the box, if it is at home here, reaches beyond the cell.
    pub(crate) const fn straddles(self) -> bool {
        self.inside & MAXIMA != MAXIMA
    }

    /// The marks of its record, if it is at home here.
    pub(crate) const fn marks(self) -> u32 {
        if self.straddles() { Record::STRADDLES } else { 0 }
    }

    /// Whether the box, if it is at home here, is a large object.
    pub(crate) const fn is_large(self) -> bool {
        self.before & MAXIMA != MAXIMA
    }
}

/// Where the records of a leaf are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Leaf {
    /// First record.
    pub(crate) start: u32,
    /// Records.
    pub(crate) len: u32,
    /// Records that fit before the next leaf's.
    pub(crate) room: u32,
}

/// Where the straddlers of a leaf are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Straddling {
    pub(crate) start: u32,
    pub(crate) len: u32,
}

/// A node of the tree: its plane, and what is below it. A leaf is below itself, so a walk of fixed length ends
/// in one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Split {
    /// The plane; or the number of a leaf, above an [axis](Self::AXIS) that does not occur.
    pub(crate) plane: i32,
    /// The left one of its two children, an even number; or the leaf's own node.
    pub(crate) below: u32,
}

impl Split {
    /// The low bits of a plane hold its axis.
    pub(crate) const AXIS: i32 = 3;

    /// A leaf at a node.
    pub(crate) const fn leaf(leaf: usize, node: usize) -> Self {
        Self { plane: (leaf as i32) << 2 | Self::AXIS, below: node as u32 }
    }

    /// Its number, if it is a leaf.
    pub(crate) const fn as_leaf(self) -> Option<usize> {
        if self.plane & Self::AXIS == Self::AXIS { Some((self.plane >> 2) as usize) } else { None }
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Nodes<'n> {
    /// A box around the members of each node. There is no node zero.
    pub(crate) boxes: &'n [KeyBox],
    pub(crate) splits: &'n [Split],
    /// The node above two children, by half of their number.
    pub(crate) parents: &'n [u32],
    /// The node of each leaf of a full step.
    pub(crate) tops: &'n [u32],
}

impl<'n> Nodes<'n> {
    /// The box around the members of a leaf of a full step.
    pub(crate) fn around(&self, leaf: usize) -> &'n KeyBox {
        KeyBox::of(self.boxes, self.tops.at(leaf) as usize)
    }

    pub(crate) fn above(&self, node: usize) -> usize {
        self.parents.at(node / 2) as usize
    }

    /// How many nodes are above a node.
    pub(crate) fn depth(&self, mut node: usize) -> u32 {
        let mut depth = 0;
        while node > 1 && depth < LEVELS as u32 {
            node = self.above(node);
            depth += 1;
        }
        depth
    }
}

impl Leaf {
    pub(crate) fn members<'r>(&self, records: &'r [Record]) -> &'r [Record] {
        records.span(self.start as usize, self.len as usize)
    }

    /// The records of the leaf, eight at a time; and with each eight how many records are left from its first
    /// one on. The last eight are filled up with what stands behind: free room, or records of the next leaf.
    pub(crate) fn chunks_of_eight<'r>(
        &self,
        records: &'r [Record],
    ) -> impl Iterator<Item = (&'r [Record; EIGHT], u32)> + use<'r> {
        let records = records.span(self.start as usize, (self.len as usize).next_multiple_of(EIGHT));
        records.as_chunks().0.iter().scan(self.len, |left, eight| {
            // After the last eight this wraps, and nobody reads it.
            Some((eight, core::mem::replace(left, left.wrapping_sub(EIGHT as u32))))
        })
    }
}

/// Which of eight records belong to a leaf with so many left: a bit for each.
pub(crate) const fn first_of_eight(left: u32) -> u32 {
    0xff >> 8u32.saturating_sub(left)
}

/// A box that reaches beyond its leaf, or a large object. Stored as keys, since each leaf that it reaches has
/// its own frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Straddler {
    pub(crate) bounds: KeyBox,
    pub(crate) slot: u32,
    /// Of a large object: the axes that it is long on, a bit each.
    pub(crate) long: u32,
}
