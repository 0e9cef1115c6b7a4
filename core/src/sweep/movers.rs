//! Tests moved objects against everything near them (paper, section III.B.1). Pairs of two resting objects
//! persist (erratum E6).
//!
//! Movers are taken leaf by leaf, so that the leaves around are in the cache. Every object is in one
//! place, so each of two movers meets the other once, and the one with the lower slot reports the pair.

use super::Sink;
use super::leaves::TreeView;
use crate::access::{Access, bits};
use crate::filter::may_meet;
use crate::geometry::key::KeyBox;
use crate::id::{Index, pair};
use crate::memory::scratch::{LeafScratch, Scratch};
use crate::pairs::pair_filter::PairFilter;
use crate::simd::{Simd, limit};
use crate::tree::visit::Visit;
use crate::tree::{Frame, Leaf, Record, first_of_eight, sub_leaves_of};

/// Tests some movers, with their homes. With filters only in leaves where somebody is whom they may meet.
#[inline(always)]
pub(crate) fn sweep_movers<S: Simd, I: Index>(
    simd: S,
    tree_view: &TreeView<'_>,
    moved: &[u32],
    (movers, homes): (&[I], &[I]),
    filters: Option<&PairFilter<'_>>,
    scratch: &mut Scratch<'_, I>,
    sink: &mut Sink<'_, I>,
) {
    let mut near = Near { tree_view, moved, filters, scratch: &mut scratch.leaf_scratch, found: 0, sink };
    let mut start = 0;
    while start < homes.len() {
        let home = homes.at(start);
        let mut end = start + 1;
        // Large objects may be anywhere: each by itself.
        while homes.get(end) == Some(&home) && home != I::LARGE {
            end += 1;
        }
        near.visit(simd, home, movers.span(start, end - start));
        start = end;
    }
    near.hand_on();
}

/// What is near movers.
struct Near<'n, 'g, 's, 'o, I> {
    tree_view: &'n TreeView<'g>,
    moved: &'n [u32],
    filters: Option<&'n PairFilter<'g>>,
    scratch: &'n mut LeafScratch<'s, I>,
    /// Pairs that wait to be passed on.
    found: usize,
    sink: &'n mut Sink<'o, I>,
}

impl<I: Index> Near<'_, '_, '_, '_, I> {
    /// Visits the large objects and the leaves around movers of one leaf.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, home: I, movers: &[I]) {
        let tree_view = self.tree_view;
        let mut around = KeyBox::NOTHING;
        for mover in movers {
            let bounds = tree_view.boxes.at(mover.at());
            around.include(&bounds);
            let is_lone = |demand| !may_meet(demand, u32::MAX);
            if !tree_view.large.list.is_empty() && !self.demand(mover.at()).is_some_and(is_lone) {
                tree_view.large.each(simd, bounds, |large| {
                    self.scratch.work.candidates += 1;
                    if large.bounds.overlaps(&bounds) {
                        self.report(mover.slot(), large.slot);
                    }
                });
            }
        }
        let (tree, sub_levels) = (tree_view.tree, tree_view.state.sub_levels());
        // A large object has no home: the walk starts anywhere.
        let leaf = if home == I::LARGE { 0 } else { home.at() >> sub_levels };
        let mut visit = Visit::new(tree_view.nodes, around);
        visit.start(simd, leaf);
        while let Some(whole) = visit.next(simd) {
            let frame = tree.frames.get(whole).unwrap_or(&Frame::NONE);
            // A leaf that is not divided yet has a box around it, and no bounds.
            let parts = sub_leaves_of(tree.bounds, sub_levels, whole)
                .filter(|_| tree_view.state.is_subdivided(whole));
            for mover in movers {
                let bounds = KeyBox::of(tree_view.boxes, mover.at());
                let record = simd.record(frame, simd.keys(bounds), mover.slot());
                let mask = match parts {
                    Some(parts) => simd.touching(parts, limit(&record)),
                    None => u32::from(simd.overlap(tree_view.nodes.around(whole), bounds)),
                };
                let demand = if mask == 0 { None } else { self.demand(mover.at()) };
                for part in bits::of_word(mask) {
                    let leaf = tree.leaves.at((whole << sub_levels) + part);
                    let offer = parts.map_or(u32::MAX, |parts| parts.at(part).tag);
                    if demand.is_none_or(|demand| may_meet(demand, offer)) {
                        self.test(simd, leaf, &record);
                    } else {
                        self.scratch.work.spared += u64::from(leaf.len);
                    }
                }
            }
        }
    }

    /// What a mover looks for; `None` if all.
    fn demand(&self, mover: usize) -> Option<u32> {
        self.filters.and_then(|filters| filters.demand(mover))
    }

    /// Tests a mover against the members of a leaf or sub-leaf that it touches.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, leaf: Leaf, mover: &Record) {
        let (TreeView { boxes, tree, .. }, limit) = (*self.tree_view, limit(mover));
        self.scratch.work.candidates += u64::from(leaf.len);
        for (eight, left) in leaf.chunks_of_eight(tree.records) {
            let mut mask = simd.touching(eight, limit);
            if mask != 0 {
                mask &= first_of_eight(left);
            }
            for other in bits::of_word(mask).map(|at| eight.at(at)) {
                let contact = simd.contact(mover, &other);
                let bounds = |record: &Record| KeyBox::of(boxes, record.slot() as usize);
                if contact.touches && (!contact.tied || bounds(mover).overlaps(bounds(&other))) {
                    self.report(mover.slot(), other.slot());
                }
            }
        }
    }

    #[inline(always)]
    fn report(&mut self, mover: u32, other: u32) {
        if other == mover || (other < mover && bits::test(self.moved, other as usize)) {
            return;
        }
        self.scratch.pairs.put(self.found, pair(mover, other));
        self.found += 1;
        if self.found == self.scratch.pairs.len() {
            self.hand_on();
        }
    }

    fn hand_on(&mut self) {
        self.sink.take(self.scratch.pairs.span_mut(0, self.found));
        self.found = 0;
    }
}
