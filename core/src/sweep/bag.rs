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
use crate::arch::{Simd, WINDOW};
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
    let count = bags[0].len() + bags[1].len();
    let mut ends: Ends = [0; 256];
    for bag in bags {
        for record in bag {
            ends[high(record.lanes[axis]) as usize] += 1;
        }
    }
    let mut start = 0;
    for end in &mut ends {
        start += core::mem::replace(end, start);
    }
    // Each entry now is where its run starts, and after the last record of the run is placed, where it ends.
    let (sorted, rows) = (bench.sorted.span_mut(0, count), bench.rows.span_mut(0, count));
    let lanes = simd.axis(axis);
    for bag in bags {
        for record in bag {
            let next = &mut ends[high(record.lanes[axis]) as usize];
            sorted.put(*next as usize, *record);
            rows.put(*next as usize, simd.row(lanes, record));
            *next += 1;
        }
    }
    sweep_sorted(simd, count, axis, &ends, bench, boxes, sink);
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
    sweep_sorted(simd, order.len(), axis, &ends, bench, boxes, sink);
}

#[inline(always)]
fn sweep_sorted<S: Simd, I: Index>(
    simd: S,
    count: usize,
    axis: usize,
    ends: &Ends,
    bench: &mut Bench<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let Bench { sorted, rows, candidates, pairs, tested } = bench;
    let sorted = sorted.span(0, count);
    let rows = rows.span(0, count + WINDOW);
    let full = candidates.len().saturating_sub(WINDOW);
    let mut collected = 0;
    for (at, record) in sorted.iter().enumerate() {
        let end = ends[high(!record.lanes[3 + axis]) as usize] as usize;
        let mut first = at + 1;
        if first >= end {
            continue;
        }
        let query = simd.query(rows.at(at));
        while first < end {
            let mask = simd.window(rows, first, end - first, query);
            collected += unpack(mask, ((at << 16) | first) as u32, candidates, collected);
            if collected >= full {
                *tested += collected as u64;
                test(simd, sorted, candidates.span_mut(0, collected), pairs, boxes, sink);
                collected = 0;
            }
            first += WINDOW;
        }
    }
    *tested += collected as u64;
    test(simd, sorted, candidates.span_mut(0, collected), pairs, boxes, sink);
}

/// Writes a candidate for each set bit and returns how many there are.
#[inline(always)]
fn unpack(mask: u64, base: u32, candidates: &mut [u32], from: usize) -> usize {
    let count = mask.count_ones() as usize;
    let mut rest = mask;
    let mut written = 0;
    // Most masks have few bits, and how many is hard to predict: four are written always.
    loop {
        if let Some(four) = candidates.get_mut(from + written..).and_then(|tail| tail.first_chunk_mut::<4>())
        {
            for candidate in four {
                *candidate = base + rest.trailing_zeros();
                rest &= rest.wrapping_sub(1);
            }
        }
        written += 4;
        if written >= count {
            return count;
        }
    }
}

/// Tests candidates on all lanes and hands the pairs on.
#[inline(always)]
fn test<S: Simd, I: Index>(
    simd: S,
    sorted: &[Record],
    candidates: &mut [u32],
    pairs: &mut [Pair<I>],
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let pairs = pairs.span_mut(0, candidates.len());
    let (mut found, mut tied) = (0, 0);
    for index in 0..candidates.len() {
        let candidate = candidates.at(index);
        let a = sorted.at((candidate >> 16) as usize);
        let b = sorted.at((candidate & 0xffff) as usize);
        let contact = simd.contact(&a, &b);
        // Records that share a mark belong to another leaf's report (erratum E9), or to another tile's.
        let ours = contact.touches & (a.tag & b.tag & !Record::SLOT == 0);
        // Written always, kept or not, so that nothing depends on a guess of the branch predictor.
        pairs.put(found, pair::<I>(a.slot(), b.slot()));
        found += usize::from(ours & !contact.tied);
        candidates.put(tied, candidate);
        tied += usize::from(ours & contact.tied);
    }
    // Of boxes that share a step of the grid only the keys can tell.
    for &candidate in candidates.span(0, tied) {
        let a = sorted.at((candidate >> 16) as usize).slot();
        let b = sorted.at((candidate & 0xffff) as usize).slot();
        pairs.put(found, pair::<I>(a, b));
        found += usize::from(boxes.at(a as usize).overlaps(&boxes.at(b as usize)));
    }
    sink.take(pairs.span(0, found));
}
