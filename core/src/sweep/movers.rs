//! Tests the few objects that moved against everything near them (paper, section III.B: only moving-moving and
//! moving-resting pairs are looked for; resting pairs are carried over, erratum E6).
//!
//! Movers are taken leaf by leaf, so that the leaves around are in the cache for all of them. Every object stands
//! in one place, so every pair is met once from each of its movers; of two movers the lower slot reports.

use super::Sink;
use super::leaves::Grove;
use super::scratch::Scratch;
use crate::access::{Access, bits};
use crate::arch::{Phase, Simd, limit};
use crate::id::{Index, pair};
use crate::key::KeyBox;
use crate::tree::visit::Visit;
use crate::tree::{Frame, Record};

/// Tests the movers of some leaves. The large objects count as one more leaf, the last one.
pub(crate) struct SweepMovers<'p, 's, 'g, I> {
    pub(crate) grove: &'p Grove<'g>,
    /// One bit a slot.
    pub(crate) moved: &'p [u32],
    /// The slots of the movers, leaf by leaf, and where each leaf's end.
    pub(crate) movers: &'p [I],
    pub(crate) ends: &'p [u32],
    pub(crate) leaves: core::ops::Range<usize>,
    pub(crate) scratch: &'p mut Scratch<'s, I>,
    pub(crate) sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for SweepMovers<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { grove, moved, movers, ends, leaves, scratch, sink } = self;
        let mut report = Report { boxes: grove.boxes, moved, pairs: scratch.bench.pairs, found: 0, sink };
        let mut start = leaves.start.checked_sub(1).map_or(0, |before| ends.at(before));
        let mut tested = 0;
        for &end in ends.span(leaves.start, leaves.len()) {
            if end > start {
                let movers = movers.span(start as usize, (end - start) as usize);
                tested += test(simd, grove, movers, &mut report);
            }
            start = end;
        }
        report.flush();
        scratch.bench.tested += tested;
    }
}

/// Tests movers that are near each other against all members of the leaves around. Returns how many boxes it looked at.
#[inline(always)]
fn test<S: Simd, I: Index>(simd: S, grove: &Grove<'_>, movers: &[I], report: &mut Report<'_, '_, I>) -> u64 {
    let mut around = KeyBox::EMPTY;
    for mover in movers {
        let bounds = grove.boxes.at(mover.at());
        for k in 0..3 {
            around.min[k] = around.min[k].min(bounds.min[k]);
            around.max[k] = around.max[k].max(bounds.max[k]);
        }
    }
    let mut tested = 0;
    let mut visit = Visit::new(grove.planes, grove.reach, grove.depth, around.min, around.max);
    while let Some(index) = visit.next() {
        let leaf = grove.leaves.at(index);
        let members = grove.members(&leaf);
        let (cell, frame) = (grove.cells.at(index), grove.frames.at(index));
        let reach = grove.reach.at((1 << grove.depth) + index);
        let region = KeyBox { min: cell.low(), max: reach };
        for mover in movers {
            let bounds = grove.boxes.at(mover.at());
            if region.overlaps(&bounds) {
                tested += members.len();
                scan(simd, members, &frame, mover.slot(), &bounds, report);
            }
        }
    }
    for mover in movers {
        let bounds = grove.boxes.at(mover.at());
        tested += grove.large.len();
        for large in grove.large {
            if large.bounds.overlaps(&bounds) {
                report.pair(mover.slot(), large.slot);
            }
        }
    }
    tested as u64
}

/// Tests one mover against all members of a leaf.
#[inline(always)]
fn scan<S: Simd, I: Index>(
    simd: S,
    members: &[Record],
    frame: &Frame,
    mover: u32,
    bounds: &KeyBox,
    report: &mut Report<'_, '_, I>,
) {
    let record = simd.record(frame, simd.keys(bounds), mover);
    let limit = limit(&record);
    let (quads, rest) = members.as_chunks::<4>();
    for quad in quads {
        let mut mask = simd.touching(quad, limit);
        while mask != 0 {
            let other = quad.at(mask.trailing_zeros() as usize);
            report.contact(simd, &record, bounds, &other);
            mask &= mask - 1;
        }
    }
    for other in rest {
        report.contact(simd, &record, bounds, other);
    }
}

/// Decides about contacts and passes pairs on in batches.
struct Report<'r, 'k, I> {
    boxes: &'r [KeyBox],
    moved: &'r [u32],
    pairs: &'r mut [[I; 2]],
    found: usize,
    sink: &'k mut dyn Sink<I>,
}

impl<I: Index> Report<'_, '_, I> {
    #[inline(always)]
    fn contact<S: Simd>(&mut self, simd: S, mover: &Record, bounds: &KeyBox, other: &Record) {
        let contact = simd.contact(mover, other);
        let overlaps =
            contact.touches && (!contact.tied || bounds.overlaps(&self.boxes.at(other.slot() as usize)));
        if overlaps {
            self.pair(mover.slot(), other.slot());
        }
    }

    #[inline(always)]
    fn pair(&mut self, mover: u32, other: u32) {
        if other == mover || (other < mover && bits::test(self.moved, other as usize)) {
            return;
        }
        self.pairs.put(self.found, pair(mover, other));
        self.found += 1;
        if self.found == self.pairs.len() {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.sink.take(self.pairs.span_mut(0, self.found));
        self.found = 0;
    }
}
