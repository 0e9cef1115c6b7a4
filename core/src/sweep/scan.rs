//! Finds the pairs of a sorted bag without branches that hang on its boxes: the branch predictor would guess them wrong,
//! and that cost more than the compares.
//!
//! First the windows, in passes: the first window of many rows, then the second window of those whose run of neighbours
//! goes on, and so on. Each gives a mask of the rows that may touch. Then the masks, in rounds: one, two or three bits of
//! each mask, so that a multiple of four is left, go to a list of candidates; four bits of each mask that has some left are
//! tested at once, until none has.

use super::Sink;
use super::scratch::Bench;
use crate::access::Access;
use crate::arch::{HALF, Phase, Row, Sifted, Simd, WINDOW};
use crate::id::{Index, Pair, pair};
use crate::key::KeyBox;
use crate::tree::Record;
use bytemuck::{Pod, Zeroable};

/// What a window found.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Mask {
    /// A bit for each row that may touch.
    bits: u64,
    /// The position whose window it is, and that of the window's first row: `at << 16 | first`. The candidate of bit `k` is
    /// `base + k`.
    base: u64,
}

/// A row whose run of neighbours goes on behind its last window.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Open {
    /// Its position, and that of the next window's first row.
    base: u32,
    /// Where the run ends.
    end: u32,
}

impl Open {
    /// The windows of a record from the first row on.
    #[inline(always)]
    fn new(at: usize, first: usize, end: usize) -> Self {
        Self { base: (at << 16 | first) as u32, end: end as u32 }
    }

    #[inline(always)]
    fn at(self) -> usize {
        (self.base >> 16) as usize
    }
}

/// Masks that are taken bits from before the room for them is looked at again.
const PART: usize = 32;
/// Candidates, or pairs, of so many masks, and what is written behind them.
const ROOM: usize = 4 * PART + 4;
/// Rows whose run of neighbours is looked at to choose the width of the windows.
const SAMPLE: usize = 32;

/// Looks for pairs in a sorted bag.
pub(super) struct Scan<'s, I> {
    pub(super) sorted: &'s [Record],
    rows: &'s [Row],
    axis: usize,
    masks: &'s mut [Mask],
    open: &'s mut [Open],
    held: usize,
    found: Found<'s, I>,
    sink: &'s mut dyn Sink<I>,
}

/// What has been found so far.
struct Found<'s, I> {
    sorted: &'s [Record],
    boxes: &'s [KeyBox],
    candidates: &'s mut [u32],
    collected: usize,
    pairs: &'s mut [Pair<I>],
    found: usize,
    tested: &'s mut u64,
    tied: &'s mut u64,
}

impl<'s, I: Index> Scan<'s, I> {
    #[inline(always)]
    pub(super) fn new(
        axis: usize,
        count: usize,
        bench: &'s mut Bench<'_, I>,
        boxes: &'s [KeyBox],
        sink: &'s mut dyn Sink<I>,
    ) -> Self {
        let Bench { sorted, rows, masks, open, candidates, pairs, tested, tied } = bench;
        let (sorted, rows) = (sorted.span(0, count), rows.span(0, count + WINDOW));
        let found = Found { sorted, boxes, candidates, collected: 0, pairs, found: 0, tested, tied };
        Self { sorted, rows, axis, masks, open, held: 0, found, sink }
    }

    /// Hands on the pairs of all records. `run` has where the neighbours of a record start and end.
    #[inline(always)]
    pub(super) fn run<S: Simd>(mut self, simd: S, run: impl Fn(usize, &Record) -> (usize, usize)) {
        let count = self.sorted.len();
        let (mut reach, mut sampled) = (0, 0);
        for at in (0..count).step_by(count.div_ceil(SAMPLE).max(1)) {
            let (first, end) = run(at, &self.sorted.at(at));
            reach += end - first;
            sampled += 1;
        }
        if reach > HALF * sampled {
            simd.call(Passes::<_, _, WINDOW> { scan: &mut self, run });
        } else {
            simd.call(Passes::<_, _, HALF> { scan: &mut self, run });
        }
        self.drain(simd);
        simd.call(Last { found: &mut self.found, sink: self.sink });
    }

    /// Makes room for so many masks, of which there are at most as many as the list is long.
    #[inline(always)]
    fn make_room<S: Simd>(&mut self, simd: S, more: usize) {
        if self.held + more > self.masks.len() {
            self.drain(simd);
        }
    }

    #[inline(always)]
    fn drain<S: Simd>(&mut self, simd: S) {
        let masks = self.masks.span_mut(0, self.held);
        simd.call(Drain { masks, found: &mut self.found, sink: self.sink });
        self.held = 0;
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
        let most = scan.open.len().min(scan.masks.len()).max(1);
        let mut start = 0;
        while start < sorted.len() {
            let count = most.min(sorted.len() - start);
            scan.make_room(simd, count);
            let mut lists = Lists::new(scan);
            for (at, record) in (start..).zip(sorted.span(start, count)) {
                let (first, end) = run(at, record);
                lists.next::<S, WIDTH>(simd, lanes, rows, record, Open::new(at, first, end));
            }
            let mut left = lists.finish();
            while left > 0 {
                scan.make_room(simd, left);
                let mut lists = Lists::new(scan);
                for index in 0..left {
                    let open = lists.open.at(index);
                    lists.next::<S, WIDTH>(simd, lanes, rows, &sorted.at(open.at()), open);
                }
                left = lists.finish();
            }
            start += count;
        }
    }
}

/// The lists that a pass adds to.
struct Lists<'l> {
    masks: &'l mut [Mask],
    open: &'l mut [Open],
    held: &'l mut usize,
    more: usize,
    left: usize,
}

impl<'l> Lists<'l> {
    #[inline(always)]
    fn new<I>(scan: &'l mut Scan<'_, I>) -> Self {
        let masks = scan.masks.get_mut(scan.held..).unwrap_or_default();
        Self { masks, open: scan.open, held: &mut scan.held, more: 0, left: 0 }
    }

    /// Compares a record with the rows of its next window. Both lists are written always, used or not.
    #[inline(always)]
    fn next<S: Simd, const WIDTH: usize>(
        &mut self,
        simd: S,
        lanes: S::Axis,
        rows: &[Row],
        record: &Record,
        open: Open,
    ) {
        let Open { base, end } = open;
        let first = base as usize & 0xffff;
        let count = (end as usize).wrapping_sub(first);
        // No closures: they would not share the instruction set of their function.
        let Some(rows) = rows.get(first..first + WIDTH) else { return };
        let query = simd.query(lanes, record);
        let bits = if WIDTH == WINDOW {
            let Some(rows) = rows.first_chunk() else { return };
            simd.window(rows, count, query)
        } else {
            let Some(rows) = rows.first_chunk() else { return };
            simd.half_window(rows, count, query).into()
        };
        self.masks.put(self.more, Mask { bits, base: base.into() });
        self.more += usize::from(bits != 0);
        self.open.put(self.left, Open { base: base.wrapping_add(WIDTH as u32), end });
        self.left += usize::from(count > WIDTH);
    }

    /// Returns how many rows have further windows.
    #[inline(always)]
    fn finish(self) -> usize {
        *self.held += self.more;
        self.left
    }
}

/// Takes all bits of some masks.
struct Drain<'d, 's, I> {
    masks: &'d mut [Mask],
    found: &'d mut Found<'s, I>,
    sink: &'d mut dyn Sink<I>,
}

impl<I: Index> Phase for Drain<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { masks, found, sink } = self;
        let mut left = 0;
        for start in (0..masks.len()).step_by(PART) {
            found.make_room(simd, sink);
            let stop = masks.len().min(start + PART);
            left = found.odd_ones(masks, start..stop, left);
        }
        while left > 0 {
            let mut again = 0;
            for start in (0..left).step_by(PART) {
                found.make_room(simd, sink);
                let stop = left.min(start + PART);
                again = found.fours(simd, masks, start..stop, again);
            }
            left = again;
        }
    }
}

/// Tests the last candidates and hands on the last pairs.
struct Last<'d, 's, I> {
    found: &'d mut Found<'s, I>,
    sink: &'d mut dyn Sink<I>,
}

impl<I: Index> Phase for Last<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.found.test(simd, self.sink);
        self.found.hand_on(self.sink);
    }
}

impl<I: Index> Found<'_, I> {
    /// Makes room for the candidates and the pairs of `PART` masks.
    #[inline(always)]
    fn make_room<S: Simd>(&mut self, simd: S, sink: &mut dyn Sink<I>) {
        if self.collected + ROOM > self.candidates.len() {
            self.test(simd, sink);
        }
        if self.found + ROOM > self.pairs.len() {
            self.hand_on(sink);
        }
    }

    /// Hands the pairs on.
    #[inline(always)]
    fn hand_on(&mut self, sink: &mut dyn Sink<I>) {
        sink.take(self.pairs.span_mut(0, self.found));
        self.found = 0;
    }

    /// Moves bits of masks to the candidates, so that a multiple of four is left. Masks with bits left come to `to` on;
    /// returns where they end.
    #[inline(always)]
    fn odd_ones(&mut self, masks: &mut [Mask], which: core::ops::Range<usize>, mut to: usize) -> usize {
        let Some(room) = self.candidates.get_mut(self.collected..).and_then(<[_]>::first_chunk_mut::<ROOM>)
        else {
            return to;
        };
        let mut count = 0;
        for index in which {
            let Mask { bits, base } = masks.at(index);
            let (one, two, _) = without(bits);
            let odd = bits.count_ones() as usize % 4;
            // Written always.
            let at = count % (4 * PART);
            for (offset, bits) in [bits, one, two].into_iter().enumerate() {
                room.put(at + offset, candidate(base, bits));
            }
            count += odd;
            let even = if odd & 2 == 0 { bits } else { two };
            let rest = if odd & 1 == 0 { even } else { even & even.wrapping_sub(1) };
            masks.put(to, Mask { bits: rest, base });
            to += usize::from(rest != 0);
        }
        self.collected += count;
        to
    }

    /// Tests four bits of each of some masks. Masks with bits left come to `to` on; returns where they end.
    #[inline(always)]
    fn fours<S: Simd>(
        &mut self,
        simd: S,
        masks: &mut [Mask],
        which: core::ops::Range<usize>,
        mut to: usize,
    ) -> usize {
        let sorted = self.sorted;
        let mut found = self.found;
        let mut tested = 4 * which.len();
        for index in which {
            let Mask { bits, base } = masks.at(index);
            let (one, two, three) = without(bits);
            let rest = three & three.wrapping_sub(1);
            masks.put(to, Mask { bits: rest, base });
            to += usize::from(rest != 0);
            if let Some(room) = self.pairs.get_mut(found..).and_then(<[_]>::first_chunk_mut::<4>)
                && let Some(four) = simd.four(sorted, base as u32, bits, room)
            {
                found += four;
                continue;
            }
            for bits in [bits, one, two, three] {
                self.candidates.put(self.collected, candidate(base, bits));
                self.collected += 1;
            }
            tested -= 4;
        }
        self.found = found;
        *self.tested += tested as u64;
        to
    }

    /// Tests the candidates on all lanes and hands the pairs on.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, sink: &mut dyn Sink<I>) {
        if self.found + self.collected > self.pairs.len() {
            self.hand_on(sink);
        }
        let (sorted, boxes) = (self.sorted, self.boxes);
        let candidates = self.candidates.span_mut(0, self.collected);
        let pairs = self.pairs.span_mut(self.found, self.collected);
        let Sifted { found, tied } = simd.call(Test { sorted, candidates, pairs, boxes });
        *self.tested += self.collected as u64;
        *self.tied += tied as u64;
        self.found += found;
        self.collected = 0;
    }
}

/// A mask without its lowest bit, its two lowest, and its three lowest.
#[inline(always)]
const fn without(bits: u64) -> (u64, u64, u64) {
    let one = bits & bits.wrapping_sub(1);
    let two = one & one.wrapping_sub(1);
    (one, two, two & two.wrapping_sub(1))
}

/// The candidate of the lowest bit of a mask.
#[inline(always)]
const fn candidate(base: u64, bits: u64) -> u32 {
    (base as u32).wrapping_add(bits.trailing_zeros())
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
