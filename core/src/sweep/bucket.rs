//! Sweeps one bucket of records (paper, section IV): sorts it along one axis, compares the neighbours that
//! overlap there on the other two, and tests what is left on all lanes.
//!
//! The sort is a counting sort on the high byte of the minimum, so the histogram tells where the neighbours
//! of a record end. Beside each record is a row of four bytes, the high bytes on the other two axes; vectors
//! compare many rows at a time. What passes is tested with whole records. Only where two sides share a step
//! of the grid do the exact boxes decide.

use super::{Sink, scan};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::LeafScratch;
use crate::simd::{Simd, call};
use crate::tree::Record;

/// The runs of a bucket in one part, and in two, with one run of all records of neither.
pub(super) const WHOLE: usize = 256;
pub(super) const PARTS: usize = 2 * 256 + 1;

const fn high(lane: u16) -> u8 {
    (lane >> 8) as u8
}

/// Sweeps two parts of some records against each other along an axis; and the first alone, if `within_first`.
/// `part` tells the part of a record, 0 or 1, or 2 if it has none; it is 0 if the runs are of one part.
#[inline(always)]
pub(super) fn sweep<const RUNS: usize, S: Simd, I: Index>(
    simd: S,
    buckets: [&[Record]; 2],
    (part, within_first): (impl Fn(usize, &Record) -> usize, bool),
    (axis, boxes): (usize, &[KeyBox]),
    leaf_scratch: &mut LeafScratch<'_, I>,
    sink: &mut Sink<'_, I>,
) {
    let axis = axis.min(2);
    let mut runs = [0u16; RUNS];
    sort(simd, buckets, axis, leaf_scratch, part, &mut runs);
    let ([ends, rest @ ..], _) = runs.as_chunks() else { return };
    let first = ends[255] as usize;
    let both = rest.first().map_or(first, |ends| ends[255] as usize);
    let LeafScratch { sorted, common_axes, .. } = leaf_scratch;
    widen(simd, sorted.span_mut(0, both), axis, (boxes, common_axes));
    if within_first {
        // The neighbours behind each record.
        let run = move |at: usize, record: &Record| (at + 1, reach_of(record, axis, ends));
        scan::sweep(simd, (axis, first, boxes), leaf_scratch, run, sink);
    }
    let Some(others) = rest.first().filter(|_| both > first && first > 0) else { return };
    // The record whose run of equal sort bytes comes first meets the other; the first part's, if both do.
    let run = move |at: usize, record: &Record| {
        let run = high(record.lanes.at(axis)) as usize;
        if at < first {
            let start = if run == 0 { first } else { others[run - 1] as usize };
            (start, reach_of(record, axis, others))
        } else {
            (ends[run] as usize, reach_of(record, axis, ends))
        }
    };
    scan::sweep(simd, (axis, both, boxes), leaf_scratch, run, sink);
}

/// Sorts records into the scratch memory, the parts one behind the other, and records of no part behind both
/// in any order. Then `runs`, which are zero before, tell where the runs of equal sort bytes end.
#[inline(always)]
fn sort<const RUNS: usize, S: Simd, I>(
    simd: S,
    buckets: [&[Record]; 2],
    axis: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
    part: impl Fn(usize, &Record) -> usize,
    runs: &mut [u16; RUNS],
) {
    let run = |bucket: usize, record: &Record| {
        (part(bucket, record) << 8 | high(record.lanes[axis]) as usize).min(RUNS - 1)
    };
    for (number, bucket) in buckets.into_iter().enumerate() {
        for record in bucket {
            runs[run(number, record)] += 1;
        }
    }
    let mut next = 0;
    for end in &mut *runs {
        next += core::mem::replace(end, next);
    }
    // Each entry is now where its run starts, and will be where it ends.
    let count = buckets[0].len() + buckets[1].len();
    let lanes = simd.axis(axis);
    // Of one length, so that one check of an index is enough.
    if let (Some(sorted), Some(rows)) =
        (leaf_scratch.sorted.get_mut(..count), leaf_scratch.rows.get_mut(..count))
    {
        for (number, bucket) in buckets.into_iter().enumerate() {
            for record in bucket {
                let next = &mut runs[run(number, record)];
                let at = *next as usize;
                *next += 1;
                sorted.put(at, *record);
                rows.put(at, simd.row(lanes, record));
            }
        }
    }
}

/// The end of the last run that a record reaches, by where the runs of equal sort bytes end.
fn reach_of(record: &Record, axis: usize, ends: &[u16; 256]) -> usize {
    // All bytes of the record as lanes, so that the index needs no check.
    let lanes: &[u16; 8] = bytemuck::cast_ref(record);
    ends[high(!lanes[(3 + axis) % 8]) as usize] as usize
}

/// Makes the records of a bucket as wide as the grid on each axis, but the swept one, where all their boxes
/// have a point in common, at which some begin or end: as in a game in two dimensions. All touch there, but
/// would wait for the exact test where they share that step of the grid. O(records) where it is so, and O(boxes)
/// once for all leaves of one worker.
#[inline(always)]
fn widen<S: Simd>(
    simd: S,
    sorted: &mut [Record],
    swept: usize,
    (boxes, common_axes): (&[KeyBox], &mut Option<u32>),
) {
    // Where the last of some begins and, complemented, where the first one ends, by all bytes of a record.
    let mut steps = [0u16; 8];
    for record in sorted.iter().take(16) {
        let lanes: &[u16; 8] = bytemuck::cast_ref(record);
        (0..8).for_each(|k| steps[k] = steps[k].max(lanes[k]));
    }
    for axis in (0..3).filter(|axis| *axis != swept && steps[*axis] == !steps[*axis + 3]) {
        let mut of_all = 0;
        if S::MORE_CODE {
            // Asked before those of the leaf, which are anywhere in memory: all boxes stand in a row.
            of_all = *common_axes.get_or_insert_with(|| call!(simd, common(boxes)));
        }
        let (mut last, mut first) = (i32::MIN, i32::MAX);
        if of_all >> axis & 1 == 0 {
            for bounds in sorted.iter().map(|record| KeyBox::of(boxes, record.slot() as usize)) {
                (last, first) = (last.max(bounds.min.at(axis)), first.min(bounds.max.at(axis)));
            }
        }
        for record in sorted.iter_mut().filter(|_| last <= first) {
            record.lanes.put(axis, 0);
            record.lanes.put(axis + 3, 0);
        }
    }
}

/// The axes on which all boxes have a point in common, a bit each. O(n); the first few hundred boxes tell it in
/// most worlds, where there are none.
#[inline(always)]
fn common(boxes: &[KeyBox]) -> u32 {
    // The last minima and the first maxima, of four boxes at once, for vectors.
    let (mut last, mut first, mut axes) = ([i32::MIN; 24], [i32::MAX; 24], 0);
    for part in boxes.chunks(256) {
        let (fours, rest) = part.as_chunks::<4>();
        let mut filled = [KeyBox::ALL; 4];
        filled.iter_mut().zip(rest).for_each(|(to, bounds)| *to = *bounds);
        for four in fours.iter().chain([&filled]) {
            // Slots without an object do not count: a box that holds all others says nothing.
            let objects;
            let mut four = four;
            if four.iter().any(KeyBox::is_empty) {
                objects = four.map(|bounds| if bounds.is_empty() { KeyBox::ALL } else { bounds });
                four = &objects;
            }
            let sides: &[i32; 24] = bytemuck::cast_ref(four);
            for k in 0..24 {
                (last[k], first[k]) = (last[k].max(sides[k]), first[k].min(sides[k]));
            }
        }
        let at = [0, 6, 12, 18];
        let touch = |a: usize, b: usize| last.at(a) <= first.at(b + 3);
        let all_touch = |axis: usize| at.iter().all(|a| at.iter().all(|b| touch(a + axis, b + axis)));
        axes = (0..3).map(|axis| u32::from(all_touch(axis)) << axis).sum();
        if axes == 0 {
            break;
        }
    }
    axes
}
