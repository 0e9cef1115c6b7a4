//! Sweep-and-prune over one bag of records (paper, section IV): sort along one axis, compare the neighbours that
//! overlap there on the other two, and test what is left on all lanes.
//!
//! The sort is a counting sort on the high byte of the minimum, so a record's run of neighbours ends where the
//! histogram says. The other two axes stand beside as byte columns, which a vector compares many rows at a time.
//! What passes is tested with the whole 16-bit records; only where two coordinates share a step of the grid do
//! the exact boxes decide.

use super::Sink;
use super::scratch::{Bench, OVERRUN};
use crate::access::Access;
use crate::arch::Simd;
use crate::id::{Index, pair};
use crate::key::KeyBox;
use crate::tree::Record;

/// The other two axes.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

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
    for bag in bags {
        for record in bag {
            let next = &mut ends[high(record.lanes[axis]) as usize];
            place::<S, I>(bench, *next as usize, record, axis);
            *next += 1;
        }
    }
    sweep_sorted(simd, count, axis, &ends, bench, boxes, sink);
}

/// Sweeps records that come in ascending order of their minimum on `axis`.
#[inline(always)]
pub(crate) fn sweep_listed<S: Simd, I: Index>(
    simd: S,
    records: impl Iterator<Item = Record>,
    axis: usize,
    bench: &mut Bench<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let mut ends: Ends = [0; 256];
    let mut count = 0;
    for record in records {
        place::<S, I>(bench, count, &record, axis);
        count += 1;
        ends[high(record.lanes[axis]) as usize] = count as u16;
    }
    let mut end = 0;
    for run in &mut ends {
        end = end.max(*run);
        *run = end;
    }
    sweep_sorted(simd, count, axis, &ends, bench, boxes, sink);
}

/// Puts a record to its place in the sorted bag, and its bytes into the columns.
#[inline(always)]
fn place<S: Simd, I: Index>(bench: &mut Bench<'_, I>, at: usize, record: &Record, axis: usize) {
    bench.sorted.put(at, *record);
    let [u, v] = OTHERS[axis];
    let row = at / S::ROWS * (4 * S::ROWS) + at % S::ROWS;
    // One check for the four columns.
    if let Some(block) = bench.columns.get_mut(row..row + 3 * S::ROWS + 1) {
        block[0] = high(record.lanes[u]);
        block[S::ROWS] = high(record.lanes[3 + u]);
        block[2 * S::ROWS] = high(record.lanes[v]);
        block[3 * S::ROWS] = high(record.lanes[3 + v]);
    }
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
    let [u, v] = OTHERS[axis];
    let full = bench.candidates.len().saturating_sub(OVERRUN);
    let mut collected = 0;
    for at in 0..count {
        let record = bench.sorted.at(at);
        let end = ends[high(!record.lanes[3 + axis]) as usize] as usize;
        let first = at + 1;
        if end <= first {
            continue;
        }
        // A row's minimum against this maximum; a row's complemented maximum against this complemented minimum.
        let query = simd.query([
            high(!record.lanes[3 + u]),
            high(!record.lanes[u]),
            high(!record.lanes[3 + v]),
            high(!record.lanes[v]),
        ]);
        let last_block = (end - 1) / S::ROWS;
        let mut block = first / S::ROWS;
        let mut window = u64::MAX << (first % S::ROWS);
        while block <= last_block {
            if block == last_block {
                window &= u64::MAX >> (63 - (end - 1) % S::ROWS);
            }
            let rows = bench.columns.span(block * 4 * S::ROWS, 4 * S::ROWS);
            let mask = simd.rows_at_most(rows, query) & window;
            collected += unpack(mask, ((at << 16) | (block * S::ROWS)) as u32, bench.candidates, collected);
            if collected >= full {
                test(simd, collected, bench, boxes, sink);
                collected = 0;
            }
            window = u64::MAX;
            block += 1;
        }
    }
    test(simd, collected, bench, boxes, sink);
}

/// Writes a candidate for each set bit and returns how many there are.
#[inline(always)]
fn unpack(mask: u64, base: u32, candidates: &mut [u32], from: usize) -> usize {
    let count = mask.count_ones() as usize;
    let mut rest = mask;
    // Most masks have few bits, and how many is hard to predict: write four always, more in a loop.
    if let Some(first) = candidates.get_mut(from..).and_then(|tail| tail.first_chunk_mut::<4>()) {
        for candidate in first {
            *candidate = base + rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
        }
    }
    if count > 4 {
        for candidate in candidates.span_mut(from + 4, count - 4) {
            *candidate = base + rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
        }
    }
    count
}

/// Tests candidates on all lanes and hands the pairs on.
#[inline(always)]
fn test<S: Simd, I: Index>(
    simd: S,
    collected: usize,
    bench: &mut Bench<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    bench.tested += collected as u64;
    let mut found = 0;
    for &candidate in bench.candidates.span(0, collected) {
        let a = bench.sorted.at((candidate >> 16) as usize);
        let b = bench.sorted.at((candidate & 0xffff) as usize);
        let contact = simd.contact(&a, &b);
        // Records that share a mark belong to another leaf's report (erratum E9), or to another tile's.
        let ours = a.tag & b.tag & !Record::SLOT == 0;
        bench.pairs.put(found, pair::<I>(a.slot(), b.slot()));
        found += usize::from(contact.touches & !contact.tied & ours);
        if contact.touches & contact.tied & ours {
            found += usize::from(overlap(boxes, a.slot(), b.slot()));
        }
    }
    sink.take(bench.pairs.span(0, found));
}

/// The exact test, for boxes that share a step of the grid.
#[cold]
fn overlap(boxes: &[KeyBox], a: u32, b: u32) -> bool {
    boxes.at(a as usize).overlaps(&boxes.at(b as usize))
}
