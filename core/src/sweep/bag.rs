//! Sweep-and-prune over one bag of records (paper, section IV): sort along one axis, compare the neighbours that
//! overlap there on the other two, and test what is left on all lanes.
//!
//! The sort is a counting sort on the high byte of the minimum, so a record's run of neighbours ends where the
//! histogram says. The high bytes of the other two axes stand beside as rows of four, and vectors compare many of them
//! at a time.
//! What passes is tested with the whole 16-bit records; only where two coordinates share a step of the grid do
//! the exact boxes decide.

use super::Sink;
use super::scratch::Bench;
use crate::access::Access;
use crate::arch::{Phase, Row, Sifted, Simd, WINDOW};
use crate::id::{Index, Pair, pair};
use crate::key::KeyBox;
use crate::tree::{Frame, Record};

/// The ends of the runs of equal sort bytes, in a sorted bag.
type Ends = [u16; 256];

#[inline(always)]
const fn high(lane: u16) -> u8 {
    (lane >> 8) as u8
}

/// Sweeps records in any order along `axis`.
#[inline(always)]
pub(crate) fn sweep<S: Simd, I: Index>(
    simd: S,
    bags: [&[Record]; 2],
    axis: usize,
    bench: &mut Bench<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let ends = sort(simd, bags, axis, 0, bench);
    let count = bags[0].len() + bags[1].len();
    let mut scan = Scan::new(simd, axis, count, bench, boxes, sink);
    for (at, record) in scan.sorted.iter().enumerate() {
        scan.rows(at, record, at + 1, reach_of(record, axis, &ends));
    }
    scan.test();
}

/// Sweeps two bags against each other along `axis`: each pair has a record of either.
#[inline(always)]
pub(crate) fn sweep_across<S: Simd, I: Index>(
    simd: S,
    bags: [&[Record]; 2],
    axis: usize,
    bench: &mut Bench<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let [left, right] = bags.map(<[Record]>::len);
    let left_ends = sort(simd, [bags[0], &[]], axis, 0, bench);
    let right_ends = sort(simd, [bags[1], &[]], axis, left, bench);
    let mut scan = Scan::new(simd, axis, left + right, bench, boxes, sink);
    // The one whose run of equal sort bytes comes first meets the other; of equal runs the left one does.
    for (at, record) in scan.sorted.iter().enumerate() {
        let run = high(record.lanes[axis]) as usize;
        if at < left {
            let first = if run == 0 { left } else { right_ends[run - 1] as usize };
            scan.rows(at, record, first, reach_of(record, axis, &right_ends));
        } else {
            scan.rows(at, record, left_ends[run] as usize, reach_of(record, axis, &left_ends));
        }
    }
    scan.test();
}

/// Sweeps the objects of a list that is in ascending order of their minimum on `axis`.
#[inline(always)]
pub(crate) fn sweep_listed<S: Simd, I: Index>(
    simd: S,
    order: &[I],
    frame: &Frame,
    axis: usize,
    bench: &mut Bench<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let mut ends: Ends = [0; 256];
    let lanes = simd.axis(axis);
    for (at, slot) in order.iter().enumerate() {
        let record = simd.record(frame, simd.keys(&boxes.at(slot.at())), slot.slot());
        bench.sorted.put(at, record);
        bench.rows.put(at, simd.row(lanes, &record));
        ends[high(record.lanes[axis]) as usize] = at as u16 + 1;
    }
    let mut end = 0;
    for run in &mut ends {
        end = end.max(*run);
        *run = end;
    }
    let mut scan = Scan::new(simd, axis, order.len(), bench, boxes, sink);
    for (at, record) in scan.sorted.iter().enumerate() {
        scan.rows(at, record, at + 1, reach_of(record, axis, &ends));
    }
    scan.test();
}

/// Sorts records into the bench from position `start` on.
#[inline(always)]
fn sort<S: Simd, I>(
    simd: S,
    bags: [&[Record]; 2],
    axis: usize,
    start: usize,
    bench: &mut Bench<'_, I>,
) -> Ends {
    let mut ends: Ends = [0; 256];
    for bag in bags {
        for record in bag {
            ends[high(record.lanes[axis]) as usize] += 1;
        }
    }
    let mut next = start as u16;
    for end in &mut ends {
        next += core::mem::replace(end, next);
    }
    // Each entry now is where its run starts, and after the last record of the run is placed, where it ends.
    let count = start + bags[0].len() + bags[1].len();
    let lanes = simd.axis(axis);
    // Of one length, so that one check of an index serves both.
    if let (Some(sorted), Some(rows)) = (bench.sorted.get_mut(..count), bench.rows.get_mut(..count)) {
        for bag in bags {
            for record in bag {
                let next = &mut ends[high(record.lanes[axis]) as usize];
                let at = *next as usize;
                *next += 1;
                sorted.put(at, *record);
                rows.put(at, simd.row(lanes, record));
            }
        }
    }
    ends
}

/// The end of the last run that a record reaches.
#[inline(always)]
fn reach_of(record: &Record, axis: usize, ends: &Ends) -> usize {
    ends[high(!record.lanes[3 + axis]) as usize] as usize
}

/// Looks for pairs in a sorted bag.
struct Scan<'s, S: Simd, I> {
    simd: S,
    lanes: S::Axis,
    sorted: &'s [Record],
    rows: &'s [Row],
    candidates: &'s mut [u32],
    collected: u32,
    /// As many as leave room for a window.
    most: u32,
    pairs: &'s mut [Pair<I>],
    tested: &'s mut u64,
    tied: &'s mut u64,
    boxes: &'s [KeyBox],
    sink: &'s mut dyn Sink<I>,
}

impl<'s, S: Simd, I: Index> Scan<'s, S, I> {
    #[inline(always)]
    fn new(
        simd: S,
        axis: usize,
        count: usize,
        bench: &'s mut Bench<'_, I>,
        boxes: &'s [KeyBox],
        sink: &'s mut dyn Sink<I>,
    ) -> Self {
        let Bench { sorted, rows, candidates, pairs, tested, tied } = bench;
        let (sorted, rows) = (sorted.span(0, count), rows.span(0, count + WINDOW));
        let (lanes, most) = (simd.axis(axis), candidates.len().saturating_sub(WINDOW) as u32);
        Self { simd, lanes, sorted, rows, candidates, collected: 0, most, pairs, tested, tied, boxes, sink }
    }

    /// Collects the candidates among the rows from `first` to `end` for the record at `at`.
    #[inline(always)]
    fn rows(&mut self, at: usize, record: &Record, mut first: usize, end: usize) {
        while first < end {
            // Made anew after a test, since registers do not outlast that call.
            let query = self.simd.query(self.lanes, record);
            while first < end && self.collected <= self.most {
                let collected = self.collected as usize;
                let rows = self.rows.get(first..first + WINDOW);
                let room = self.candidates.get_mut(collected..collected + WINDOW);
                if let (Some(Ok(rows)), Some(Ok(room))) =
                    (rows.map(TryFrom::try_from), room.map(TryFrom::try_from))
                {
                    let mask = self.simd.window(rows, end - first, query);
                    self.collected += unpack(mask, ((at << 16) | first) as u32, room);
                }
                first += WINDOW;
            }
            if self.collected > self.most {
                self.test();
            }
        }
    }

    /// Tests the candidates on all lanes and hands the pairs on.
    #[inline(always)]
    fn test(&mut self) {
        *self.tested += u64::from(self.collected);
        let candidates = self.candidates.span_mut(0, self.collected as usize);
        let pairs = self.pairs.span_mut(0, self.collected as usize);
        let (sorted, boxes) = (self.sorted, self.boxes);
        let Sifted { found, tied } = self.simd.call(Test { sorted, candidates, pairs, boxes });
        *self.tied += tied as u64;
        self.sink.take(self.pairs.span_mut(0, found));
        self.collected = 0;
    }
}

/// Writes a candidate for each set bit and returns how many there are.
#[inline(always)]
fn unpack(mask: u64, base: u32, room: &mut [u32; WINDOW]) -> u32 {
    let count = mask.count_ones();
    let mut rest = mask;
    // Most masks have few bits, and how many is hard to predict: four are written always.
    for four in room.as_chunks_mut::<4>().0 {
        for candidate in four {
            *candidate = base + rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
        }
        if rest == 0 {
            break;
        }
    }
    count
}

/// Tests candidates: see [`Simd::sift`]. Their pairs come to the front of `pairs`, which has a place for each.
struct Test<'t, I> {
    sorted: &'t [Record],
    candidates: &'t mut [u32],
    pairs: &'t mut [Pair<I>],
    boxes: &'t [KeyBox],
}

impl<I: Index> Phase for Test<'_, I> {
    type Output = Sifted;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Sifted {
        let Self { sorted, candidates, pairs, boxes } = self;
        let Sifted { mut found, tied } = simd.sift(sorted, candidates, pairs);
        // Of boxes that share a step of the grid only the keys can tell.
        for &candidate in candidates.span(0, tied) {
            let a = sorted.at((candidate >> 16) as usize).slot();
            let b = sorted.at((candidate & 0xffff) as usize).slot();
            pairs.put(found, pair::<I>(a, b));
            found += usize::from(simd.overlap(KeyBox::of(boxes, a as usize), KeyBox::of(boxes, b as usize)));
        }
        Sifted { found, tied }
    }
}
