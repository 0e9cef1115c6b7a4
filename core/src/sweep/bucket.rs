//! Sweep-and-prune over one bucket of records (paper, section IV): sort along one axis, compare the neighbours that
//! overlap there on the other two, and test what is left on all lanes.
//!
//! The sort is a counting sort on the high byte of the minimum, so a record's run of neighbours ends where the
//! histogram says. The high bytes of the other two axes stand beside as rows of four, and vectors compare many of them
//! at a time.
//! What passes is tested with the whole 16-bit records; only where two coordinates share a step of the grid do
//! the exact boxes decide.

use super::Sink;
use super::scan::Scan;
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::LeafScratch;
use crate::simd::Simd;
use crate::tree::Record;

/// The ends of the runs of equal sort bytes, in a sorted bucket.
type Ends = [u16; 256];

#[inline(always)]
const fn high(lane: u16) -> u8 {
    (lane >> 8) as u8
}

/// Sweeps records in any order along `axis`.
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
    let ends = sort(simd, buckets, axis, 0, leaf_scratch);
    let count = buckets[0].len() + buckets[1].len();
    let scan = Scan::new(axis, count, leaf_scratch, boxes, sink);
    let ends = &ends;
    scan.run(simd, move |at, record| (at + 1, reach_of(record, axis, ends)));
}

/// Sweeps two buckets against each other along `axis`: each pair has a record of either.
#[inline(always)]
pub(crate) fn sweep_across<S: Simd, I: Index>(
    simd: S,
    buckets: [&[Record]; 2],
    axis: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
    boxes: &[KeyBox],
    sink: &mut dyn Sink<I>,
) {
    let axis = axis.min(2);
    let [left, right] = buckets.map(<[Record]>::len);
    let left_ends = sort(simd, [buckets[0], &[]], axis, 0, leaf_scratch);
    let right_ends = sort(simd, [buckets[1], &[]], axis, left, leaf_scratch);
    let scan = Scan::new(axis, left + right, leaf_scratch, boxes, sink);
    // The one whose run of equal sort bytes comes first meets the other; of equal runs the left one does.
    let (left_ends, right_ends) = (&left_ends, &right_ends);
    scan.run(simd, move |at, record| {
        let run = high(record.lanes.at(axis)) as usize;
        if at < left {
            let first = if run == 0 { left } else { right_ends[run - 1] as usize };
            (first, reach_of(record, axis, right_ends))
        } else {
            (left_ends[run] as usize, reach_of(record, axis, left_ends))
        }
    });
}

/// Sorts records into the scratch of the leaf, from position `start` on.
#[inline(always)]
fn sort<S: Simd, I>(
    simd: S,
    buckets: [&[Record]; 2],
    axis: usize,
    start: usize,
    leaf_scratch: &mut LeafScratch<'_, I>,
) -> Ends {
    let mut ends: Ends = [0; 256];
    for bucket in buckets {
        for record in bucket {
            ends[high(record.lanes[axis]) as usize] += 1;
        }
    }
    let mut next = start as u16;
    for end in &mut ends {
        next += core::mem::replace(end, next);
    }
    // Each entry now is where its run starts, and after the last record of the run is placed, where it ends.
    let count = start + buckets[0].len() + buckets[1].len();
    let lanes = simd.axis(axis);
    // Of one length, so that one check of an index serves both.
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

/// The end of the last run that a record reaches.
#[inline(always)]
fn reach_of(record: &Record, axis: usize, ends: &Ends) -> usize {
    // The record's bytes as lanes, so that the index needs no check.
    let lanes: &[u16; 8] = bytemuck::cast_ref(record);
    ends[high(!lanes[(3 + axis) % 8]) as usize] as usize
}
