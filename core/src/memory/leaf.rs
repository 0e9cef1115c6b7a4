//! What the slab holds of each leaf: its cell, where its members stand, and the boxes that reach beyond it.

use crate::access::Access;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY};
use crate::geometry::record::Record;
use crate::simd::{EIGHT, MAXIMA, MINIMA, Simd};
use bytemuck::{Pod, Zeroable};

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
    pub(crate) fn classify<S: Simd>(&self, simd: S, keys: S::Keys) -> Classification {
        let (from, until) = (simd.keys(&self.from), simd.keys(&self.until));
        Classification { before: simd.above(from, keys), inside: simd.above(until, keys) }
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
pub(crate) struct Classification {
    /// Those that do not reach the low sides, or the far ones.
    before: u32,
    /// Those that do not reach the high sides.
    inside: u32,
}

impl Classification {
    /// Whether its minimum corner is at home here.
    #[inline(always)]
    pub(crate) const fn is_home(self) -> bool {
        self.inside & !self.before & MINIMA == MINIMA
    }

    /// Whether its minimum corner is at home here, and the box is no large object.
    #[inline(always)]
    pub(crate) const fn is_member(self) -> bool {
        // Both in one comparison.
        (self.before & (MINIMA | MAXIMA)) << 3 | self.inside & MINIMA == MAXIMA << 3 | MINIMA
    }

    /// Whether the box, if it is at home here, touches other cells.
    #[inline(always)]
    pub(crate) const fn leaves(self) -> bool {
        self.inside & MAXIMA != MAXIMA
    }

    /// The mark of its record, if it is at home here.
    #[inline(always)]
    pub(crate) const fn marks(self) -> u32 {
        if self.leaves() { Record::STRADDLES } else { 0 }
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
    /// First box of the straddlers.
    pub(crate) straddler_start: u32,
    /// Boxes of the straddlers.
    pub(crate) straddler_len: u32,
    /// The count that the leaf had when its planes were new: what a rebalance can achieve here.
    pub(crate) baseline: u32,
    /// The axis that the leaf is swept along.
    pub(crate) axis: u32,
    pub(crate) unused: u32,
}

impl Leaf {
    /// The leaf's records, eight at a time, and how many of them there are from each eight on; behind the last one others make up
    /// the eight: room, or records of the next leaf.
    #[inline(always)]
    pub(crate) fn chunks_of_eight<'r>(&self, records: &'r [Record]) -> ChunksOfEight<'r> {
        let records = records.span(self.start as usize, (self.len as usize).next_multiple_of(EIGHT));
        ChunksOfEight { rest: records.as_chunks().0.iter(), left: self.len }
    }
}

/// See [`Leaf::chunks_of_eight`].
pub(crate) struct ChunksOfEight<'r> {
    rest: core::slice::Iter<'r, [Record; EIGHT]>,
    left: u32,
}

impl<'r> Iterator for ChunksOfEight<'r> {
    type Item = (&'r [Record; EIGHT], u32);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let eight = self.rest.next()?;
        let left = self.left;
        // Behind the last eight nothing is left, and the number is not read.
        self.left = left.wrapping_sub(EIGHT as u32);
        Some((eight, left))
    }
}

/// Which of eight records are those of a leaf that has so many left: a bit for each.
#[inline(always)]
pub(crate) const fn first_of_eight(left: u32) -> u32 {
    0xff >> 8u32.saturating_sub(left)
}

/// A box that reaches beyond its leaf, or a large object: exact, since every leaf it enters has its own frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Straddler {
    pub(crate) bounds: KeyBox,
    pub(crate) slot: u32,
    pub(crate) unused: u32,
}
