//! Compares the records of a sorted bucket with their neighbours, without branches that depend on boxes: the branch
//! predictor would guess them wrong, and a wrong guess costs more than the compares.
//!
//! Each record is compared with the rows of its neighbours, a window of 64 rows at a time. A pass compares the
//! first windows of many records, then the second windows of those with more neighbours, and so on. A window gives a
//! mask; `rounds` takes its bits.

use super::Sink;
use super::rounds::{Found, drain, drain_last};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::ROWS;
use crate::memory::scratch::{LeafScratch, Lists};
use crate::simd::{Row, Simd, WINDOW, call};
use crate::tree::Record;

/// Looks for pairs in a sorted bucket.
pub(super) struct Scan<'s, I> {
    sorted: &'s [Record],
    rows: &'s [Row],
    axis: usize,
    lists: &'s mut [Lists],
    /// Masks in the lists.
    mask_count: usize,
    found: Found<'s, I>,
    sink: &'s mut dyn Sink<I>,
}

impl<'s, I: Index> Scan<'s, I> {
    #[inline(always)]
    pub(super) fn new(
        axis: usize,
        count: usize,
        leaf_scratch: &'s mut LeafScratch<'_, I>,
        boxes: &'s [KeyBox],
        sink: &'s mut dyn Sink<I>,
    ) -> Self {
        let LeafScratch { sorted, rows, lists, candidates, pairs, tested, tied } = leaf_scratch;
        let (sorted, rows) = (sorted.span(0, count), rows.span(0, count + WINDOW));
        let found = Found { sorted, boxes, candidates, collected: 0, pairs, found: 0, tested, tied };
        Self { sorted, rows, axis, lists, mask_count: 0, found, sink }
    }

    /// Passes on the pairs of all records. `run` tells where the neighbours of a record start and end.
    #[inline(always)]
    pub(super) fn run<S: Simd>(mut self, simd: S, run: impl Fn(usize, &Record) -> (usize, usize)) {
        let scan = &mut self;
        call!(simd, compare_all(simd, scan, run));
        self.drain(simd);
        let (found, sink) = (&mut self.found, self.sink);
        call!(simd, drain_last(simd, found, sink));
    }

    /// Makes room for so many masks, at most `ROWS`.
    #[inline(always)]
    fn make_room<S: Simd>(&mut self, simd: S, more: usize) {
        if self.mask_count + more > ROWS {
            self.drain(simd);
        }
    }

    #[inline(always)]
    fn drain<S: Simd>(&mut self, simd: S) {
        let Self { lists: [lists], mask_count, found, sink, .. } = self else { return };
        let (mask_count, sink) = (core::mem::take(mask_count), &mut **sink);
        call!(simd, drain(simd, lists, mask_count, found, sink));
    }
}

/// Compares all records with their neighbours.
#[inline(always)]
fn compare_all<S: Simd, I: Index, F: Fn(usize, &Record) -> (usize, usize)>(
    simd: S,
    scan: &mut Scan<'_, I>,
    run: F,
) {
    let (sorted, rows, lanes) = (scan.sorted, scan.rows, simd.axis(scan.axis));
    let mut start = 0;
    while start < sorted.len() {
        let count = ROWS.min(sorted.len() - start);
        scan.make_room(simd, count);
        let [lists] = &mut *scan.lists else { return };
        let mut pass = Pass { rows, lanes, lists, mask_count: scan.mask_count, left: 0 };
        for (at, record) in (start..).zip(sorted.span(start, count)) {
            let (first, end) = run(at, record);
            pass.next(simd, record, (at << 16 | first) as u32, end as u32);
        }
        let mut left = pass.left;
        scan.mask_count = pass.mask_count;
        while left > 0 {
            scan.make_room(simd, left);
            let [lists] = &mut *scan.lists else { return };
            let mut pass = Pass { rows, lanes, lists, mask_count: scan.mask_count, left: 0 };
            for index in 0..left {
                let (base, end) = (pass.lists.open.at(index % ROWS), pass.lists.ends.at(index % ROWS));
                let Some(record) = sorted.get((base >> 16) as usize) else { continue };
                pass.next(simd, record, base, end);
            }
            left = pass.left;
            scan.mask_count = pass.mask_count;
        }
        start += count;
    }
}

/// One window of many rows.
struct Pass<'l, A> {
    rows: &'l [Row],
    lanes: A,
    lists: &'l mut Lists,
    /// Masks so far.
    mask_count: usize,
    /// Rows so far that have further windows.
    left: usize,
}

impl<A: Copy> Pass<'_, A> {
    /// Compares a record with its next window.
    #[inline(always)]
    fn next<S: Simd<Axis = A>>(&mut self, simd: S, record: &Record, base: u32, end: u32) {
        let first = base & 0xffff;
        let count = end.wrapping_sub(first);
        let rows = self.rows.get(first as usize..).unwrap_or_default();
        let Some(rows) = rows.first_chunk() else { return };
        let bits = simd.window(rows, count as usize, simd.query(self.lanes, record));
        // Both lists are always written, used or not.
        self.lists.put_mask(self.mask_count, bits, base);
        self.mask_count += usize::from(bits != 0);
        self.lists.open.put(self.left % ROWS, base.wrapping_add(WINDOW as u32));
        self.lists.ends.put(self.left % ROWS, end);
        self.left += usize::from(count > WINDOW as u32);
    }
}
