//! Tests the few objects that moved against everything near them (paper, section III.B: only moving-moving and
//! moving-resting pairs are looked for; resting pairs are carried over, erratum E6).
//!
//! Movers are taken leaf by leaf, so that the leaves around are in the cache for all of them. Every object stands
//! in one place, so every pair is met once from each of its movers; of two movers the lower slot reports.

use super::Sink;
use super::leaves::Grove;
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::{Index, pair};
use crate::memory::scratch::Scratch;
use crate::simd::{Phase, Simd, limit};
use crate::tree::visit::Visit;
use crate::tree::{Eights, Frame, PARTS, Record, first_of_eight, parts_of};

/// Tests some movers.
pub(crate) struct SweepMovers<'p, 's, 'g, I> {
    pub(crate) grove: &'p Grove<'g>,
    /// One bit a slot.
    pub(crate) moved: &'p [u32],
    /// The slots of the movers, leaf by leaf, and their leaves.
    pub(crate) movers: &'p [I],
    pub(crate) homes: &'p [I],
    pub(crate) scratch: &'p mut Scratch<'s, I>,
    pub(crate) sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for SweepMovers<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { grove, moved, movers, homes, scratch, sink } = self;
        let mut report = Report { boxes: grove.boxes, moved, pairs: scratch.bench.pairs, found: 0, sink };
        let visits = [(0, 0, 0); TOGETHER];
        let (leaves, records) = ([0; TOGETHER], [Record::NOTHING; TOGETHER]);
        let mut near =
            Near { grove, movers, visits, visit_count: 0, leaves, records, test_count: 0, tested: 0 };
        let mut start = 0;
        while start < homes.len() {
            let home = homes.at(start);
            let mut end = start + 1;
            while homes.get(end) == Some(&home) {
                end += 1;
            }
            near.visit(simd, home, start as u32, end as u32, &mut report);
            start = end;
        }
        near.divide(simd, &mut report);
        near.test(simd, &mut report);
        report.flush();
        scratch.bench.tested += near.tested as u64;
    }
}

/// Leaves that are asked for before the first of them is looked at: they are anywhere in memory.
const TOGETHER: usize = 16;
/// Records that are asked for; the processor sees for itself that the others follow.
const RECORDS: usize = 48;
/// How many movers ahead boxes are asked for.
const AHEAD: usize = 8;

/// Leaves, and the movers that are near them.
struct Near<'n, 'g, I> {
    grove: &'n Grove<'g>,
    movers: &'n [I],
    /// A leaf of the last full step, and where its movers start and end.
    visits: [(usize, u32, u32); TOGETHER],
    visit_count: usize,
    /// Leaves, and for each a mover's record in its frame. Two arrays, as pairs would have gaps.
    leaves: [u32; TOGETHER],
    records: [Record; TOGETHER],
    test_count: usize,
    /// How many boxes were looked at.
    tested: usize,
}

impl<I: Index> Near<'_, '_, I> {
    /// Collects the leaves around movers that are near each other, to be looked at a little later.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, home: I, start: u32, end: u32, report: &mut Report<'_, '_, I>) {
        let grove = self.grove;
        let movers = self.movers.span(start as usize, (end - start) as usize);
        for ahead in self.movers.iter().skip(start as usize + AHEAD).take(movers.len()) {
            simd.prefetch(grove.boxes, ahead.at());
        }
        let mut around = KeyBox::NOTHING;
        for mover in movers {
            let bounds = grove.boxes.at(mover.at());
            around.include(&bounds);
            self.tested += grove.large.len();
            for large in grove.large {
                if large.bounds.overlaps(&bounds) {
                    report.pair(mover.slot(), large.slot);
                }
            }
        }
        // A large object has no home.
        let leaf = if home == I::LARGE { 0 } else { home.at() >> grove.finer };
        let mut visit = Visit::new(simd, grove.nodes, grove.depth, leaf, around);
        while let Some(whole) = visit.next(simd) {
            simd.prefetch(grove.frames, whole);
            simd.prefetch_from::<PARTS, _>(grove.bounds, whole << grove.finer);
            self.visits.put(self.visit_count, (whole, start, end));
            self.visit_count += 1;
            if self.visit_count == TOGETHER {
                self.divide(simd, report);
            }
        }
    }

    /// Finds which of the leaves that are collected movers touch; where they are divided, which parts.
    #[inline(always)]
    fn divide<S: Simd>(&mut self, simd: S, report: &mut Report<'_, '_, I>) {
        let grove = self.grove;
        for index in 0..self.visit_count {
            let (whole, start, end) = self.visits.at(index);
            let first = whole << grove.finer;
            let frame = grove.frames.get(whole).unwrap_or(&Frame::NONE);
            for mover in self.movers.span(start as usize, (end - start) as usize) {
                let bounds = KeyBox::of(grove.boxes, mover.at());
                let record = simd.record(frame, simd.keys(bounds), mover.slot());
                let mut mask = match parts_of(grove.bounds, grove.finer, whole) {
                    Some(parts) => simd.touching(parts, limit(&record)),
                    None => {
                        u32::from(simd.overlap(KeyBox::of(grove.nodes, (1 << grove.depth) + whole), bounds))
                    }
                };
                while mask != 0 {
                    let leaf = first + mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    simd.prefetch(grove.leaves, leaf);
                    self.leaves.put(self.test_count, leaf as u32);
                    self.records.put(self.test_count, record);
                    self.test_count += 1;
                    if self.test_count == TOGETHER {
                        self.test(simd, report);
                    }
                }
            }
        }
        self.visit_count = 0;
    }

    /// Tests movers against the members of the leaves that they touch.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, report: &mut Report<'_, '_, I>) {
        let grove = self.grove;
        let leaves = self.leaves.span(0, self.test_count);
        for leaf in leaves {
            simd.prefetch_from::<RECORDS, _>(grove.records, grove.leaves.at(*leaf as usize).start as usize);
        }
        for (leaf, mover) in leaves.iter().zip(&self.records) {
            let leaf = grove.leaves.at(*leaf as usize);
            self.tested += leaf.len as usize;
            scan(simd, leaf.eights(grove.records), mover, report);
        }
        self.test_count = 0;
    }
}

/// Tests one mover against all members of a leaf.
#[inline(always)]
fn scan<S: Simd, I: Index>(simd: S, members: Eights<'_>, mover: &Record, report: &mut Report<'_, '_, I>) {
    let limit = limit(mover);
    for (eight, left) in members {
        let mut mask = simd.touching(eight, limit);
        if mask != 0 {
            mask &= first_of_eight(left);
        }
        while mask != 0 {
            let other = eight.at(mask.trailing_zeros() as usize);
            report.contact(simd, mover, &other);
            mask &= mask - 1;
        }
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
    fn contact<S: Simd>(&mut self, simd: S, mover: &Record, other: &Record) {
        let contact = simd.contact(mover, other);
        let bounds = |record: &Record| KeyBox::of(self.boxes, record.slot() as usize);
        if contact.touches && (!contact.tied || bounds(mover).overlaps(bounds(other))) {
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
