//! Finds the pairs of a sorted bucket without branches that depend on its boxes. The branch predictor would guess them wrong, and
//! a wrong guess costs more than the compares.
//!
//! Each record is compared with the rows of its neighbours, a window at a time, in passes: the first window of many rows, then
//! the second window of those whose run of neighbours goes on, and so on. What a window finds is a mask; `rounds` takes the
//! bits.

use super::Sink;
use super::rounds::{Drain, Found, Last};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::LeafScratch;
use crate::memory::scratch::{Lists, ROWS};
use crate::simd::{HALF, Phase, Row, Simd, WINDOW};
use crate::tree::Record;

/// Rows whose run of neighbours is looked at to choose the width of the windows.
const SAMPLE: usize = 32;

/// Looks for pairs in a sorted bucket.
pub(super) struct Scan<'s, I> {
    sorted: &'s [Record],
    rows: &'s [Row],
    axis: usize,
    lists: &'s mut [Lists],
    /// Masks in the lists.
    contained: usize,
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
        Self { sorted, rows, axis, lists, contained: 0, found, sink }
    }

    /// Hands on the pairs of all records. `run` has where the neighbours of a record start and end.
    #[inline(always)]
    pub(super) fn run<S: Simd>(mut self, simd: S, run: impl Fn(usize, &Record) -> (usize, usize)) {
        let count = self.sorted.len();
        let (mut reach, mut sampled) = (0, 0);
        for at in (0..count).step_by(count.div_ceil(SAMPLE).max(1)) {
            let (first, end) = run(at, &self.sorted.at(at));
            reach += end.saturating_sub(first);
            sampled += 1;
        }
        // Short runs need no second half.
        if reach > HALF * sampled {
            simd.call(Passes::<_, _, WINDOW> { scan: &mut self, run });
        } else {
            simd.call(Passes::<_, _, HALF> { scan: &mut self, run });
        }
        self.drain(simd);
        simd.call(Last { found: &mut self.found, sink: self.sink });
    }

    /// Makes room for so many masks, at most `ROWS`.
    #[inline(always)]
    fn make_room<S: Simd>(&mut self, simd: S, more: usize) {
        if self.contained + more > ROWS {
            self.drain(simd);
        }
    }

    #[inline(always)]
    fn drain<S: Simd>(&mut self, simd: S) {
        let [lists] = &mut *self.lists else { return };
        simd.call(Drain { lists, contained: self.contained, found: &mut self.found, sink: self.sink });
        self.contained = 0;
    }
}

/// Compares all records with the rows of their neighbours, in windows of this width.
struct Passes<'p, 's, I, F, const WIDTH: usize> {
    scan: &'p mut Scan<'s, I>,
    run: F,
}

impl<I: Index, F: Fn(usize, &Record) -> (usize, usize), const WIDTH: usize> Phase
    for Passes<'_, '_, I, F, WIDTH>
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { scan, run } = self;
        let (sorted, rows, lanes) = (scan.sorted, scan.rows, simd.axis(scan.axis));
        let mut start = 0;
        while start < sorted.len() {
            let count = ROWS.min(sorted.len() - start);
            scan.make_room(simd, count);
            let [lists] = &mut *scan.lists else { return };
            let mut pass = Pass { rows, lanes, lists, contained: scan.contained, left: 0 };
            for (at, record) in (start..).zip(sorted.span(start, count)) {
                let (first, end) = run(at, record);
                pass.next::<S, WIDTH>(simd, record, (at << 16 | first) as u32, end as u32);
            }
            let mut left = pass.left;
            scan.contained = pass.contained;
            while left > 0 {
                scan.make_room(simd, left);
                let [lists] = &mut *scan.lists else { return };
                let mut pass = Pass { rows, lanes, lists, contained: scan.contained, left: 0 };
                for index in 0..left {
                    let (base, end) = (pass.lists.open.at(index % ROWS), pass.lists.ends.at(index % ROWS));
                    let Some(record) = sorted.get((base >> 16) as usize) else { continue };
                    pass.next::<S, WIDTH>(simd, record, base, end);
                }
                left = pass.left;
                scan.contained = pass.contained;
            }
            start += count;
        }
    }
}

/// One window of many rows.
struct Pass<'l, A> {
    rows: &'l [Row],
    lanes: A,
    lists: &'l mut Lists,
    /// Masks so far.
    contained: usize,
    /// Rows so far that have further windows.
    left: usize,
}

impl<A: Copy> Pass<'_, A> {
    /// Compares a record with the rows of its next window.
    #[inline(always)]
    fn next<S: Simd<Axis = A>, const WIDTH: usize>(&mut self, simd: S, record: &Record, base: u32, end: u32) {
        let first = base & 0xffff;
        let count = end.wrapping_sub(first);
        let rows = self.rows.get(first as usize..first as usize + WIDTH).unwrap_or_default();
        let query = simd.query(self.lanes, record);
        // No closures: they would not share the instruction set of their function.
        let bits = if WIDTH == WINDOW {
            let Some(rows) = rows.first_chunk() else { return };
            simd.window(rows, count as usize, query)
        } else {
            let Some(rows) = rows.first_chunk() else { return };
            simd.half_window(rows, count as usize, query).into()
        };
        // Both lists are written always, used or not.
        self.lists.put_mask(self.contained, bits, base);
        self.contained += usize::from(bits != 0);
        self.lists.open.put(self.left % ROWS, base.wrapping_add(WIDTH as u32));
        self.lists.ends.put(self.left % ROWS, end);
        self.left += usize::from(count > WIDTH as u32);
    }
}
