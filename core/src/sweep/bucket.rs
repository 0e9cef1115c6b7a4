//! Sweeps one bucket of records (paper, section IV): sorts it along one axis, compares the neighbours that overlap
//! there on the other two, and tests what is left on all lanes.
//!
//! The sort is a counting sort on the high byte of the minimum, so the histogram tells where the neighbours of a
//! record end. Beside each record is a row of four bytes, the high bytes on the other two axes; vectors compare many
//! rows at a time. What passes is tested with whole records. Only where two sides share a step of the grid do the
//! exact boxes decide.

use super::scan::Scan;
use super::{Sink, flat};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::LeafScratch;
use crate::simd::Simd;
use crate::tree::Record;

/// Where the runs of equal sort bytes end, in a sorted bucket.
type Ends = [u16; 256];

/// Where the neighbours of a record start and end.
type Run = (usize, usize);

#[inline(always)]
const fn high(lane: u16) -> u8 {
    (lane >> 8) as u8
}

/// Sweeps records along `axis`. They may be in any order.
#[inline(always)]
pub(crate) fn sweep<S: Simd, I: Index>(
    simd: S,
    buckets: [&[Record]; 2],
    axis: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let ends = sort(simd, buckets, axis, leaf_scratch);
    let count = buckets[0].len() + buckets[1].len();
    flat::widen(leaf_scratch.sorted.span_mut(0, count), axis, boxes);
    Scan::new(axis, count, leaf_scratch, boxes, sink).run(simd, within(axis, &ends));
}

/// Sweeps two parts of some records against each other along `axis`; and the first one alone, if `within`. `part` tells the part of
/// a record, 0 or 1, or 2 if it has none.
#[inline(always)]
pub(crate) fn sweep_parts<S: Simd, I: Index>(
    simd: S,
    buckets: [&[Record]; 2],
    (part, within_first): (impl Fn(usize, &Record) -> usize, bool),
    axis: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let (ends, first, count) = sort_apart(simd, buckets, axis, leaf_scratch, part);
    if first == 0 {
        return;
    }
    flat::widen(leaf_scratch.sorted.span_mut(0, count), axis, boxes);
    if within_first {
        Scan::new(axis, first, leaf_scratch, boxes, sink).run(simd, within(axis, &ends[0]));
    }
    if count > first {
        Scan::new(axis, count, leaf_scratch, boxes, sink).run(simd, across(axis, first, &ends));
    }
}

/// The neighbours of each record of a bucket: those behind it.
#[inline(always)]
fn within(axis: usize, ends: &Ends) -> impl Fn(usize, &Record) -> Run {
    move |at, record| (at + 1, reach_of(record, axis, ends))
}

/// The neighbours of each record of a bucket in two parts, of which the first one has `left` records: those of the
/// other part.
#[inline(always)]
fn across(axis: usize, left: usize, ends: &[Ends; 2]) -> impl Fn(usize, &Record) -> Run {
    let [left_ends, right_ends] = ends;
    // The record whose run of equal sort bytes comes first meets the other; of equal runs the left one does.
    move |at, record| {
        let run = high(record.lanes.at(axis)) as usize;
        if at < left {
            let first = if run == 0 { left } else { right_ends[run - 1] as usize };
            (first, reach_of(record, axis, right_ends))
        } else {
            (left_ends[run] as usize, reach_of(record, axis, left_ends))
        }
    }
}

/// Sorts records into the scratch memory.
#[inline(always)]
fn sort<S: Simd, I>(
    simd: S,
    buckets: [&[Record]; 2],
    axis: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
) -> Ends {
    let mut ends: Ends = [0; 256];
    for bucket in buckets {
        for record in bucket {
            ends[high(record.lanes[axis]) as usize] += 1;
        }
    }
    let mut next = 0;
    for end in &mut ends {
        next += core::mem::replace(end, next);
    }
    // Each entry is now where its run starts, and will be where it ends.
    let count = buckets[0].len() + buckets[1].len();
    let lanes = simd.axis(axis);
    // Of one length, so that one check of an index is enough.
    if let (Some(sorted), Some(rows)) =
        (leaf_scratch.sorted.get_mut(..count), leaf_scratch.rows.get_mut(..count))
    {
        for bucket in buckets {
            for record in bucket {
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

/// The same in two parts, one behind the other, and those of no part behind both in any order. Also returns where the parts end.
#[inline(always)]
fn sort_apart<S: Simd, I>(
    simd: S,
    buckets: [&[Record]; 2],
    axis: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
    part: impl Fn(usize, &Record) -> usize,
) -> ([Ends; 2], usize, usize) {
    // The runs of the parts, and one of all others.
    let mut runs = [0u16; 2 * 256 + 1];
    let run = |number: usize, record: &Record| {
        (part(number, record) << 8 | high(record.lanes.at(axis)) as usize).min(2 * 256)
    };
    for (number, bucket) in buckets.into_iter().enumerate() {
        for record in bucket {
            if let Some(end) = runs.get_mut(run(number, record)) {
                *end += 1;
            }
        }
    }
    let mut next = 0u16;
    for end in &mut runs {
        next += core::mem::replace(end, next);
    }
    let [first, both] = [256, 2 * 256].map(|run| runs.at(run) as usize);
    let count = buckets[0].len() + buckets[1].len();
    let lanes = simd.axis(axis);
    if let (Some(sorted), Some(rows)) =
        (leaf_scratch.sorted.get_mut(..count), leaf_scratch.rows.get_mut(..count))
    {
        for (number, bucket) in buckets.into_iter().enumerate() {
            for record in bucket {
                let Some(next) = runs.get_mut(run(number, record)) else { continue };
                let at = *next as usize;
                *next += 1;
                sorted.put(at, *record);
                rows.put(at, simd.row(lanes, record));
            }
        }
    }
    let ends = |part: usize| core::array::from_fn(|run| runs.at(256 * part + run));
    ([ends(0), ends(1)], first, both)
}

/// The end of the last run that a record reaches.
#[inline(always)]
fn reach_of(record: &Record, axis: usize, ends: &Ends) -> usize {
    // All bytes of the record as lanes, so that the index needs no check.
    let lanes: &[u16; 8] = bytemuck::cast_ref(record);
    ends[high(!lanes[(3 + axis) % 8]) as usize] as usize
}
