//! Flat buckets: all boxes are the same point on an axis, as in a game in two dimensions. On such an axis each two records share a
//! step of the grid, so that all candidates would wait for the exact test. Their boxes all touch there, so the records are
//! made to say so.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::tree::Record;

/// Whether it is done: a program for a microcontroller does without.
const DONE: bool = cfg!(feature = "large");

/// Makes the records of a bucket as wide as the grid on each axis, other than the one that is swept along, on which it is flat.
/// O(records) where it is, else a few records are looked at.
#[inline(always)]
pub(super) fn widen(sorted: &mut [Record], swept: usize, boxes: &[KeyBox]) {
    for axis in (0..3).filter(|axis| DONE && *axis != swept) {
        if is_flat(sorted, axis, boxes) {
            for record in &mut *sorted {
                // The minimum, and the complemented maximum.
                record.lanes.put(axis, 0);
                record.lanes.put(axis + 3, 0);
            }
        }
    }
}

/// Whether the boxes of all records are the same point on an axis.
#[inline(always)]
fn is_flat(sorted: &[Record], axis: usize, boxes: &[KeyBox]) -> bool {
    let mut point = None;
    sorted.iter().all(|record| {
        // Most buckets are not, as their first record tells.
        record.lanes.at(axis) == !record.lanes.at(axis + 3) && {
            let bounds = KeyBox::of(boxes, record.slot() as usize);
            let (min, max) = (bounds.min.at(axis), bounds.max.at(axis));
            min == max && *point.get_or_insert(min) == min
        }
    })
}
