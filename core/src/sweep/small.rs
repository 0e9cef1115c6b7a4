//! Finds the pairs of few boxes: no records and no batches (paper, section IV). A small processor has no
//! vectors that would repay them.

use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::memory::state::{ListState, slot};
use crate::pairs::pair_filter::PairFilter;

/// Tests every two boxes and writes the pairs that fit. Returns how many pairs there are, whether they fit or
/// not, and how many were compared. Up to some dozens that takes less than to keep a list in order and to read
/// boxes by way of it. O(slots²).
// Not inline, so that the inner loop stays in registers.
#[inline(never)]
pub(crate) fn test_all<I: Index>(
    boxes: &[KeyBox],
    pair_filter: Option<&PairFilter<'_>>,
    pairs: &mut [Pair<I>],
) -> (usize, usize) {
    let (all, mut places, mut without_room) = (pairs.len(), pairs.iter_mut(), 0);
    let mut rest = boxes;
    while let Some((&KeyBox { min, max }, others)) = rest.split_first() {
        let slot = I::from_slot((boxes.len() - rest.len()) as u32);
        let mut ahead = others;
        while let Some((b, behind)) = ahead.split_first() {
            let meets = |k: usize| b.min[k] <= max[k] && min[k] <= b.max[k];
            // Height last: in most scenes few boxes are apart in it.
            if meets(0) && meets(2) && meets(1) {
                // A number of its own, or the compiler counts the next pair along, box by box.
                let left = core::hint::black_box(ahead.len());
                let pair = [slot, I::from_slot((boxes.len() - left) as u32)];
                if pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(pair)) {
                    match places.next() {
                        Some(place) => *place = pair,
                        None => without_room += 1,
                    }
                }
            }
            ahead = behind;
        }
        rest = others;
    }
    let candidates = boxes.len() * boxes.len().saturating_sub(1) / 2;
    (all - places.len() + without_room, candidates)
}

/// Bits of a side in a word of the list: the distance of the high side from the end of the grid, a free bit, the
/// low side from [`LOW`] on, another free bit.
pub(crate) const BITS: u32 = 11;
const LAST: i32 = (1 << BITS) - 1;
const LOW: u32 = BITS + 1;
const FREE: i32 = 1 << BITS | 1 << (LOW + BITS);

/// The word of a box in the list: its slot, and its sides on the second axis. What is beyond the grid is at its
/// ends: any monotone map is right.
#[inline(always)]
pub(crate) fn word<const U: usize>(bounds: &KeyBox, slot: usize, lists: &ListState) -> i32 {
    // Half a key, so that no difference is too large.
    let least = i32::from(lists.least) << 15;
    let step = |key: i32| (((key >> 1).wrapping_sub(least)) >> (lists.shift & 31)).clamp(0, LAST);
    step(bounds.min[U]) << LOW | !step(bounds.max[U]) & LAST | (slot as i32) << 24
}

/// Sweeps along a list by ascending minimum on an axis, and writes the pairs that fit. Returns how many there
/// are, and how many boxes were compared: at most n²/2. O(n + that).
pub(crate) fn sweep<I: Index>(
    boxes: &[KeyBox],
    list: &[i32],
    axis: u8,
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
) -> (usize, usize) {
    match axis {
        0 => sweep_along::<I, 0, 2, 1>(boxes, list, pair_filter, pairs),
        1 => sweep_along::<I, 1, 0, 2>(boxes, list, pair_filter, pairs),
        _ => sweep_along::<I, 2, 0, 1>(boxes, list, pair_filter, pairs),
    }
}

/// With constant axes, and not inline, so that the inner loop stays in registers.
#[inline(never)]
fn sweep_along<I: Index, const W: usize, const U: usize, const V: usize>(
    boxes: &[KeyBox],
    list: &[i32],
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
) -> (usize, usize) {
    let (all, mut places, mut without_room) = (pairs.len(), pairs.iter_mut(), 0);
    let (mut rest, mut candidates) = (list, 0);
    while let Some((word, ahead)) = rest.split_first() {
        let a = KeyBox::of(boxes, slot(*word));
        let (end, facing) = (a.max[W], *word >> LOW & 0xfff | (*word & 0xfff) << LOW);
        // In parts, as only a box that is near on the second axis tells that those behind it are too far.
        'ahead: for some in ahead.chunks(32) {
            let mut near = some.iter();
            candidates += some.len();
            // A sum that needs a free bit is of sides that are apart.
            while let Some(other) = near.find(|other| other.wrapping_add(facing) & FREE == 0) {
                let b = KeyBox::of(boxes, slot(*other));
                if b.min[W] > end {
                    // Neither this one nor those behind it.
                    candidates -= near.len() + 1;
                    break 'ahead;
                }
                if a.min[V] > b.max[V] || b.min[V] > a.max[V] || a.min[U] > b.max[U] || b.min[U] > a.max[U] {
                    continue;
                }
                let pair = pair(slot(*word) as u32, slot(*other) as u32);
                if pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(pair)) {
                    match places.next() {
                        Some(place) => *place = pair,
                        None => without_room += 1,
                    }
                }
            }
            if some.last().is_none_or(|last| KeyBox::of(boxes, slot(*last)).min[W] > end) {
                break;
            }
        }
        rest = ahead;
    }
    (all - places.len() + without_room, candidates)
}
