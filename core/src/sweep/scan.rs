//! Compares the records of a sorted bucket with their neighbours, without branches that depend on boxes: the
//! branch predictor would guess them wrong, and a wrong guess costs more than the compares.
//!
//! Each record is compared with the rows of its neighbours, a window of 64 rows at a time, or of half as many
//! where few records have more. A pass compares the first windows of many records, then the second windows of
//! records with more neighbours, and so on. A window gives a mask of candidates.
//!
//! The bits of the masks are taken in rounds, so that no branch depends on how many bits a mask has. First
//! one, two or three bits of each mask go to a list of candidates, so that a multiple of four is left. Then
//! four bits of each mask are tested at once, until no mask has any.

use super::Sink;
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::memory::limits::{MASKS_PER_ROUND, NEIGHBOURS_SAMPLE, ROWS};
use crate::memory::scratch::{CANDIDATES_PER_ROUND, LeafScratch, Lists, Work};
use crate::simd::{Row, Simd, Tested, WINDOW, call};
use crate::tree::Record;
use core::ops::Range;

/// Half a window.
const HALF: usize = WINDOW / 2;

/// Passes on the pairs of the first `count` records of a sorted bucket. `run`: the neighbours of a record.
#[inline(always)]
pub(super) fn sweep<S: Simd, I: Index>(
    simd: S,
    (axis, count, boxes): (usize, usize, &[KeyBox]),
    leaf_scratch: &mut LeafScratch<'_, I>,
    run: impl Fn(usize, &Record) -> (usize, usize),
    sink: &mut Sink<'_, I>,
) {
    let LeafScratch { sorted, rows, lists: [lists], candidates, pairs, work, .. } = leaf_scratch else {
        return;
    };
    let (sorted, rows) = (sorted.span(0, count), rows.span(0, count + WINDOW));
    let mut found = Found { sorted, boxes, candidates, collected: 0, pairs, found: 0, work, sink };
    let found = &mut found;
    let few = have_few_neighbours(sorted, &run);
    if S::MORE_CODE && few {
        call!(simd, compare_all::<HALF, S, I, _>(simd, (rows, axis, HALF), lists, found, run));
    } else {
        // The same windows at all levels, as the order of pairs follows from them.
        let width = if few { HALF } else { WINDOW };
        call!(simd, compare_all::<WINDOW, S, I, _>(simd, (rows, axis, width), lists, found, run));
    }
}

/// Whether half a window holds the neighbours of a record, by the mean of a sample.
#[inline(always)]
fn have_few_neighbours(sorted: &[Record], run: impl Fn(usize, &Record) -> (usize, usize)) -> bool {
    let (mut neighbours, mut sampled) = (0, 0);
    for at in (0..sorted.len()).step_by(sorted.len().div_ceil(NEIGHBOURS_SAMPLE).max(1)) {
        let (first, end) = run(at, &sorted.at(at));
        neighbours += end.saturating_sub(first);
        sampled += 1;
    }
    neighbours <= HALF * sampled
}

/// Compares all records with their neighbours in windows of a width, of at most so many rows, and tests what
/// the masks tell.
#[inline(always)]
fn compare_all<const MOST: usize, S: Simd, I: Index, F: Fn(usize, &Record) -> (usize, usize)>(
    simd: S,
    (rows, axis, width): (&[Row], usize, usize),
    lists: &mut Lists,
    found: &mut Found<'_, '_, I>,
    run: F,
) {
    let (sorted, lanes) = (found.sorted, simd.axis(axis));
    let (mut start, mut masks) = (0, 0);
    while start < sorted.len() {
        let count = ROWS.min(sorted.len() - start);
        masks = make_room(simd, lists, masks, count, found);
        let mut pass = Pass { rows, width, lanes, lists, masks, left: 0 };
        for (at, record) in (start..).zip(sorted.span(start, count)) {
            let (first, end) = run(at, record);
            pass.next::<MOST, S>(simd, record, (at << 16 | first) as u32, end as u32);
        }
        let mut left = pass.left;
        masks = pass.masks;
        while left > 0 {
            masks = make_room(simd, lists, masks, left, found);
            let mut pass = Pass { rows, width, lanes, lists, masks, left: 0 };
            for index in 0..left {
                let (base, end) = (pass.lists.open.at(index % ROWS), pass.lists.ends.at(index % ROWS));
                let Some(record) = sorted.get((base >> 16) as usize) else { continue };
                pass.next::<MOST, S>(simd, record, base, end);
            }
            (left, masks) = (pass.left, pass.masks);
        }
        start += count;
    }
    make_room(simd, lists, masks, ROWS, found);
    call!(simd, {
        found.test(simd);
        found.hand_on();
    });
}

/// Makes room for so many more masks, at most `ROWS`. Returns how many there are then.
#[inline(always)]
fn make_room<S: Simd, I: Index>(
    simd: S,
    lists: &mut Lists,
    masks: usize,
    more: usize,
    found: &mut Found<'_, '_, I>,
) -> usize {
    if masks + more <= ROWS {
        return masks;
    }
    call!(simd, drain(simd, lists, masks, found));
    0
}

/// One window of many rows.
struct Pass<'l, A> {
    rows: &'l [Row],
    width: usize,
    lanes: A,
    lists: &'l mut Lists,
    /// Masks in the lists.
    masks: usize,
    /// Rows so far that have further windows.
    left: usize,
}

impl<A: Copy> Pass<'_, A> {
    /// Compares a record with its next window.
    #[inline(always)]
    fn next<const MOST: usize, S: Simd<Axis = A>>(&mut self, simd: S, record: &Record, base: u32, end: u32) {
        let first = base & 0xffff;
        let count = end.wrapping_sub(first);
        let rows = self.rows.get(first as usize..).unwrap_or_default();
        let Some(rows) = rows.first_chunk::<MOST>() else { return };
        let bits = simd.window(rows, (count as usize).min(self.width), simd.query(self.lanes, record));
        // Both lists are always written, used or not.
        self.lists.put_mask(self.masks, bits, base);
        self.masks += usize::from(bits != 0);
        self.lists.open.put(self.left % ROWS, base.wrapping_add(self.width as u32));
        self.lists.ends.put(self.left % ROWS, end);
        self.left += usize::from(count > self.width as u32);
    }
}

/// Takes all bits of the masks.
#[inline(always)]
fn drain<S: Simd, I: Index>(simd: S, lists: &mut Lists, masks: usize, found: &mut Found<'_, '_, I>) {
    let mut left = 0;
    for start in (0..masks).step_by(MASKS_PER_ROUND) {
        found.make_room(simd);
        left = found.odd_ones(lists, start..masks.min(start + MASKS_PER_ROUND), left);
    }
    while left > 0 {
        let mut again = 0;
        for start in (0..left).step_by(MASKS_PER_ROUND) {
            found.make_room(simd);
            again = found.fours(simd, lists, start..left.min(start + MASKS_PER_ROUND), again);
        }
        left = again;
    }
}

/// Candidates and pairs so far.
struct Found<'s, 'o, I> {
    sorted: &'s [Record],
    boxes: &'s [KeyBox],
    candidates: &'s mut [u32],
    /// Candidates that wait to be tested.
    collected: usize,
    pairs: &'s mut [Pair<I>],
    /// Pairs that wait to be passed on.
    found: usize,
    work: &'s mut Work,
    sink: &'s mut Sink<'o, I>,
}

impl<I: Index> Found<'_, '_, I> {
    /// Makes room for the candidates and the pairs of `MASKS_PER_ROUND` masks.
    #[inline(always)]
    fn make_room<S: Simd>(&mut self, simd: S) {
        if self.collected + CANDIDATES_PER_ROUND > self.candidates.len() {
            self.test(simd);
        }
        if self.found + CANDIDATES_PER_ROUND > self.pairs.len() {
            self.hand_on();
        }
    }

    fn hand_on(&mut self) {
        self.sink.take(self.pairs.span_mut(0, self.found));
        self.found = 0;
    }

    /// Moves bits of masks to the candidates, so that a multiple of four is left. Masks with bits left are
    /// put to `to` and on; returns where they end.
    #[inline(always)]
    fn odd_ones(&mut self, lists: &mut Lists, which: Range<usize>, mut to: usize) -> usize {
        let room = self.candidates.get_mut(self.collected..).and_then(<[_]>::first_chunk_mut);
        let Some(room): Option<&mut [u32; CANDIDATES_PER_ROUND]> = room else { return to };
        let mut count = 0;
        for index in which {
            let (bits, base) = lists.mask(index);
            let (one, two, _) = without(bits);
            let odd = bits.count_ones() as usize % 4;
            // Always written, used or not.
            let at = count % (4 * MASKS_PER_ROUND);
            for (offset, bits) in [bits, one, two].into_iter().enumerate() {
                room.put(at + offset, candidate(base, bits));
            }
            count += odd;
            let even = if odd & 2 == 0 { bits } else { two };
            let rest = if odd & 1 == 0 { even } else { even & even.wrapping_sub(1) };
            lists.put_mask(to, rest, base);
            to += usize::from(rest != 0);
        }
        self.collected += count;
        to
    }

    /// Tests four bits of each mask. Masks with bits left are put to `to` and on; returns where they end.
    #[inline(always)]
    fn fours<S: Simd>(&mut self, simd: S, lists: &mut Lists, which: Range<usize>, mut to: usize) -> usize {
        let pairs = self.pairs.get_mut(self.found..).and_then(<[_]>::first_chunk_mut);
        let Some(pairs): Option<&mut [Pair<I>; CANDIDATES_PER_ROUND]> = pairs else { return to };
        let candidates = self.candidates.get_mut(self.collected..).and_then(<[_]>::first_chunk_mut);
        let Some(candidates): Option<&mut [u32; CANDIDATES_PER_ROUND]> = candidates else { return to };
        let (mut found, mut untested) = (0, 0);
        let count = which.len();
        for index in which {
            let (bits, base) = lists.mask(index);
            let (one, two, three) = without(bits);
            let rest = three & three.wrapping_sub(1);
            lists.put_mask(to, rest, base);
            to += usize::from(rest != 0);
            // No closure: it would not have the instruction set of its function.
            if let Some(room) =
                pairs.get_mut(found % (4 * MASKS_PER_ROUND)..).and_then(<[_]>::first_chunk_mut::<4>)
                && let Some(four) = simd.four(self.sorted, base, bits, room)
            {
                found += four;
                continue;
            }
            // Rare, except where boxes share sides.
            for bits in [bits, one, two, three] {
                candidates.put(untested, candidate(base, bits));
                untested += 1;
            }
        }
        self.found += found;
        self.collected += untested;
        self.work.candidates += (4 * count - untested) as u64;
        to
    }

    /// Tests the candidates on all lanes.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S) {
        if self.found + self.collected > self.pairs.len() {
            self.hand_on();
        }
        let (sorted, boxes) = (self.sorted, self.boxes);
        let candidates = self.candidates.span_mut(0, self.collected);
        let pairs = self.pairs.span_mut(self.found, self.collected);
        let Tested { found, tied } = call!(simd, test_candidates(simd, sorted, candidates, pairs, boxes));
        self.work.candidates += self.collected as u64;
        self.work.tied += tied as u64;
        self.found += found;
        self.collected = 0;
    }
}

/// A mask without its lowest bit, its two lowest, and its three lowest.
const fn without(bits: u64) -> (u64, u64, u64) {
    let one = bits & bits.wrapping_sub(1);
    let two = one & one.wrapping_sub(1);
    (one, two, two & two.wrapping_sub(1))
}

/// The candidate of the lowest bit of a mask.
const fn candidate(base: u32, bits: u64) -> u32 {
    base.wrapping_add(bits.trailing_zeros())
}

/// Tests candidates: see [`Simd::test_candidates`]. Pairs go to the front of `pairs`, which has a place for
/// each candidate.
#[inline(always)]
fn test_candidates<S: Simd, I: Index>(
    simd: S,
    sorted: &[Record],
    candidates: &mut [u32],
    pairs: &mut [Pair<I>],
    boxes: &[KeyBox],
) -> Tested {
    let Tested { mut found, tied } = simd.test_candidates(sorted, candidates, pairs);
    // Where boxes share a step of the grid, the keys decide.
    for &candidate in candidates.span(0, tied) {
        let a = sorted.at((candidate >> 16) as usize).slot();
        let b = sorted.at((candidate & 0xffff) as usize).slot();
        pairs.put(found, pair::<I>(a, b));
        found += usize::from(simd.overlap(KeyBox::of(boxes, a as usize), KeyBox::of(boxes, b as usize)));
    }
    Tested { found, tied }
}
