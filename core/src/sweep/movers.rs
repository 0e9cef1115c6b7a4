//! Tests moved objects against everything near them (paper, section III.B.1). Pairs of two resting objects persist
//! (erratum E6).
//!
//! Movers are taken leaf by leaf, so that the leaves around are in the cache for all of them. Every object is in one
//! place, so each of two movers meets the other once, and the one with the lower slot reports the pair.

use super::Sink;
use super::leaves::TreeView;
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::memory::prefetch::{LEAVES_TOGETHER, MOVERS_AHEAD, RECORDS_AHEAD};
use crate::memory::scratch::Scratch;
use crate::simd::{Simd, limit};
use crate::tree::visit::Visit;
use crate::tree::{Frame, Record, SUB_LEAVES, first_of_eight, sub_leaves_of};

/// Tests some movers.
#[inline(always)]
pub(crate) fn sweep_movers<S: Simd, I: Index>(
    simd: S,
    tree_view: &TreeView<'_>,
    moved: &[u32],
    movers: &[I],
    homes: &[I],
    scratch: &mut Scratch<'_, I>,
    sink: &mut Sink<'_, I>,
) {
    let mut near = Near {
        tree_view,
        moved,
        movers,
        visits: [(0, 0, 0); LEAVES_TOGETHER],
        visit_count: 0,
        leaves: [0; LEAVES_TOGETHER],
        records: [Record::NOTHING; LEAVES_TOGETHER],
        test_count: 0,
        tested: 0,
        pairs: scratch.leaf_scratch.pairs,
        found: 0,
        sink,
    };
    let mut start = 0;
    while start < homes.len() {
        let home = homes.at(start);
        let mut end = start + 1;
        // Large objects may be anywhere: each by itself.
        while homes.get(end) == Some(&home) && home != I::LARGE {
            end += 1;
        }
        near.visit(simd, home, start as u32, end as u32);
        start = end;
    }
    near.divide(simd);
    near.test(simd);
    near.hand_on();
    scratch.leaf_scratch.tested += near.tested;
}

/// Leaves near movers, collected so that they can be prefetched together.
struct Near<'n, 'g, 'o, I> {
    tree_view: &'n TreeView<'g>,
    moved: &'n [u32],
    movers: &'n [I],
    /// A whole leaf, and where the movers near it start and end.
    visits: [(usize, u32, u32); LEAVES_TOGETHER],
    visit_count: usize,
    /// Leaves or sub-leaves, and for each the record of a mover in its frame. Two arrays, since an array of both
    /// would have gaps.
    leaves: [u32; LEAVES_TOGETHER],
    records: [Record; LEAVES_TOGETHER],
    test_count: usize,
    /// How many boxes were looked at.
    tested: u64,
    pairs: &'n mut [Pair<I>],
    /// Pairs that wait to be passed on.
    found: usize,
    sink: &'n mut Sink<'o, I>,
}

impl<I: Index> Near<'_, '_, '_, I> {
    /// Collects the leaves around movers of one leaf.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, home: I, start: u32, end: u32) {
        let tree_view = self.tree_view;
        let movers = self.movers.span(start as usize, (end - start) as usize);
        for ahead in self.movers.iter().skip(start as usize + MOVERS_AHEAD).take(movers.len()) {
            simd.prefetch(tree_view.boxes, ahead.at());
        }
        let mut around = KeyBox::NOTHING;
        for mover in movers {
            let bounds = tree_view.boxes.at(mover.at());
            around.include(&bounds);
            if !tree_view.large.is_empty() {
                tree_view.large.each(simd, bounds, |large| {
                    self.tested += 1;
                    if large.bounds.overlaps(&bounds) {
                        self.report(mover.slot(), large.slot);
                    }
                });
            }
        }
        // A large object has no home: the walk starts anywhere.
        let leaf = if home == I::LARGE { 0 } else { home.at() >> tree_view.sub_levels };
        let mut visit = Visit::new(simd, tree_view.nodes, leaf, around);
        while let Some(whole) = visit.next(simd) {
            simd.prefetch(tree_view.frames, whole);
            simd.prefetch_from::<SUB_LEAVES, _>(tree_view.bounds, whole << tree_view.sub_levels);
            self.visits.put(self.visit_count, (whole, start, end));
            self.visit_count += 1;
            if self.visit_count == LEAVES_TOGETHER {
                self.divide(simd);
            }
        }
    }

    /// Finds which of the collected leaves each mover touches, and which of their sub-leaves.
    #[inline(always)]
    fn divide<S: Simd>(&mut self, simd: S) {
        let tree_view = self.tree_view;
        for index in 0..self.visit_count {
            let (whole, start, end) = self.visits.at(index);
            let first = whole << tree_view.sub_levels;
            let frame = tree_view.frames.get(whole).unwrap_or(&Frame::NONE);
            for mover in self.movers.span(start as usize, (end - start) as usize) {
                let bounds = KeyBox::of(tree_view.boxes, mover.at());
                let record = simd.record(frame, simd.keys(bounds), mover.slot());
                let mut mask = match sub_leaves_of(tree_view.bounds, tree_view.sub_levels, whole) {
                    Some(parts) => simd.touching(parts, limit(&record)),
                    None => u32::from(simd.overlap(tree_view.nodes.around(whole), bounds)),
                };
                while mask != 0 {
                    let leaf = first + mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    simd.prefetch(tree_view.leaves, leaf);
                    self.leaves.put(self.test_count, leaf as u32);
                    self.records.put(self.test_count, record);
                    self.test_count += 1;
                    if self.test_count == LEAVES_TOGETHER {
                        self.test(simd);
                    }
                }
            }
        }
        self.visit_count = 0;
    }

    /// Tests movers against the members of leaves that they touch.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S) {
        let TreeView { boxes, leaves, records, .. } = *self.tree_view;
        for leaf in self.leaves.span(0, self.test_count) {
            simd.prefetch_from::<RECORDS_AHEAD, _>(records, leaves.at(*leaf as usize).start as usize);
        }
        for index in 0..self.test_count {
            let (leaf, mover) = (leaves.at(self.leaves.at(index) as usize), self.records.at(index));
            self.tested += u64::from(leaf.len);
            let limit = limit(&mover);
            for (eight, left) in leaf.chunks_of_eight(records) {
                let mut mask = simd.touching(eight, limit);
                if mask != 0 {
                    mask &= first_of_eight(left);
                }
                while mask != 0 {
                    let other = eight.at(mask.trailing_zeros() as usize);
                    mask &= mask - 1;
                    let contact = simd.contact(&mover, &other);
                    let bounds = |record: &Record| KeyBox::of(boxes, record.slot() as usize);
                    if contact.touches && (!contact.tied || bounds(&mover).overlaps(bounds(&other))) {
                        self.report(mover.slot(), other.slot());
                    }
                }
            }
        }
        self.test_count = 0;
    }

    #[inline(always)]
    fn report(&mut self, mover: u32, other: u32) {
        if other == mover || (other < mover && bits::test(self.moved, other as usize)) {
            return;
        }
        self.pairs.put(self.found, pair(mover, other));
        self.found += 1;
        if self.found == self.pairs.len() {
            self.hand_on();
        }
    }

    fn hand_on(&mut self) {
        self.sink.take(self.pairs.span_mut(0, self.found));
        self.found = 0;
    }
}
