//! Sweeps all leaves: each its own members, and the visitors that it finds on other leaves' fronts.
//!
//! This is how cross-leaf pairs are found (erratum E7): every box that touches a leaf's cell takes part in the
//! leaf's sweep, wherever it is at home, moved or resting. A pair is reported in the one cell that holds the
//! component-wise maximum of its two minimum corners (erratum E9): with a box that is at home here that is this
//! cell by itself, and of two visitors neither axis may have both minima below the cell.

use super::{Sink, bag};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::Scratch;
use crate::memory::slab::TreeParts;
use crate::memory::state::State;
use crate::simd::{MINIMA, Phase, Simd};
use crate::tree::visit::Visit;
use crate::tree::{Cell, Frame, Front, Leaf, Record};

/// What the sweeps of all leaves read.
#[derive(Clone, Copy)]
pub(crate) struct Grove<'g> {
    pub(crate) boxes: &'g [KeyBox],
    /// By node.
    pub(crate) nodes: &'g [KeyBox],
    pub(crate) depth: u32,
    /// How many levels below `depth` leaves stand.
    pub(crate) finer: u32,
    pub(crate) cells: &'g [Cell],
    pub(crate) frames: &'g [Frame],
    pub(crate) leaves: &'g [Leaf],
    pub(crate) bounds: &'g [Record],
    pub(crate) records: &'g [Record],
    pub(crate) fronts: &'g [Front],
    /// The large-object list.
    pub(crate) large: &'g [Front],
}

impl<'g> Grove<'g> {
    pub(crate) fn new(state: &State, boxes: &'g [KeyBox], tree: &'g TreeParts<'_>) -> Self {
        Self {
            boxes,
            nodes: tree.nodes,
            depth: state.depth,
            finer: state.finer(),
            cells: tree.cells,
            frames: tree.frames,
            leaves: tree.leaves,
            bounds: tree.bounds,
            records: tree.records,
            fronts: tree.fronts,
            large: tree.fronts.span(state.large_start as usize, state.large as usize),
        }
    }

    /// The records of a leaf.
    #[inline(always)]
    pub(crate) fn members(&self, leaf: &Leaf) -> &'g [Record] {
        self.records.span(leaf.start as usize, leaf.len as usize)
    }

    /// Writes the records of the boxes that touch a leaf's cell and are not its members to `visitors`, but for the
    /// first `skip` of them, as many as fit. Returns how many there are in all.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, index: usize, skip: usize, visitors: &mut [Record]) -> usize {
        let cell = self.cells.at(index);
        let (low, entrance) = (cell.low_keys(simd), cell.entrance(simd));
        let mut gathered =
            Gathered { simd, low, entrance, frame: self.frames.at(index), skip, count: 0, visitors };
        // The cell is half-open: minima at its high side are in the next one.
        let mut visit = Visit::new(simd, self.nodes, self.depth, index, cell.inside());
        while let Some(other) = visit.next(simd) {
            if other != index {
                let leaf = self.leaves.at(other);
                gathered.enter(self.fronts.span(leaf.front_start as usize, leaf.front_len as usize));
            }
        }
        gathered.enter(self.large);
        gathered.count
    }
}

/// The visitors of a leaf so far.
struct Gathered<'v, S: Simd> {
    simd: S,
    low: S::Keys,
    entrance: S::Keys,
    frame: Frame,
    skip: usize,
    count: usize,
    visitors: &'v mut [Record],
}

impl<S: Simd> Gathered<'_, S> {
    /// Adds those of some boxes that touch the cell.
    #[inline(always)]
    fn enter(&mut self, fronts: &[Front]) {
        let simd = self.simd;
        for fronts in fronts.chunks(64) {
            // Noted for all of them first: which ones touch the cell is hard to predict.
            let mut touching = 0u64;
            for (bit, front) in fronts.iter().enumerate() {
                // Minima below the high sides, maxima not below the low sides.
                let touches = simd.above(self.entrance, simd.keys(&front.bounds)) == MINIMA;
                touching |= u64::from(touches) << bit;
            }
            while touching != 0 {
                let front = fronts.at(touching.trailing_zeros() as usize);
                touching &= touching - 1;
                let place = self.count.checked_sub(self.skip).and_then(|at| self.visitors.get_mut(at));
                if let Some(place) = place {
                    let keys = simd.keys(&front.bounds);
                    let marks = Record::BELOW * (simd.above(self.low, keys) & MINIMA);
                    *place = simd.record(&self.frame, keys, front.slot | marks);
                }
                self.count += 1;
            }
        }
    }
}

/// Sweeps some leaves.
pub(crate) struct SweepLeaves<'p, 's, 'g, I> {
    pub(crate) grove: &'p Grove<'g>,
    pub(crate) leaves: core::ops::Range<usize>,
    pub(crate) scratch: &'p mut Scratch<'s, I>,
    pub(crate) sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for SweepLeaves<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for index in self.leaves {
            sweep_leaf(simd, self.grove, index, self.scratch, self.sink);
        }
    }
}

#[inline(always)]
fn sweep_leaf<S: Simd, I: Index>(
    simd: S,
    grove: &Grove<'_>,
    index: usize,
    scratch: &mut Scratch<'_, I>,
    sink: &mut dyn Sink<I>,
) {
    let leaf = grove.leaves.at(index);
    let members = grove.members(&leaf);
    let count = grove.gather(simd, index, 0, scratch.visitors);
    scratch.copies += count as u64;
    if members.len() + count <= scratch.bench.sorted.len() {
        let visitors = scratch.visitors.span(0, count);
        bag::sweep(simd, [members, visitors], leaf.axis as usize, &mut scratch.bench, grove.boxes, sink);
    } else {
        sweep_tiles(simd, grove, index, members.len() + count, scratch, sink);
    }
}

/// Sweeps a leaf that is too large for the bag: tiles of half a bag, each alone and each two against each other.
#[inline(always)]
fn sweep_tiles<S: Simd, I: Index>(
    simd: S,
    grove: &Grove<'_>,
    index: usize,
    count: usize,
    scratch: &mut Scratch<'_, I>,
    sink: &mut dyn Sink<I>,
) {
    let axis = grove.leaves.at(index).axis as usize;
    let half = (scratch.visitors.len() / 2).max(1);
    let (left, right) = scratch.visitors.split_at_mut(half.min(scratch.visitors.len()));
    for a in (0..count).step_by(half) {
        let left = left.span_mut(0, half.min(count - a));
        fill_tile(simd, grove, index, a, left);
        bag::sweep(simd, [left, &[]], axis, &mut scratch.bench, grove.boxes, sink);
        for b in (a + half..count).step_by(half) {
            let right = right.span_mut(0, half.min(count - b));
            fill_tile(simd, grove, index, b, right);
            bag::sweep_across(simd, [left, right], axis, &mut scratch.bench, grove.boxes, sink);
        }
    }
}

/// Fills a tile with the members and visitors of a leaf from number `from` on.
#[inline(always)]
fn fill_tile<S: Simd>(simd: S, grove: &Grove<'_>, index: usize, from: usize, tile: &mut [Record]) {
    let members = grove.members(&grove.leaves.at(index));
    let own = members.get(from..).unwrap_or_default();
    let (inside, outside) = tile.split_at_mut(own.len().min(tile.len()));
    inside.copy_in(own);
    if !outside.is_empty() {
        grove.gather(simd, index, from.saturating_sub(members.len()), outside);
    }
}
