//! Finds the pairs of few boxes: no records and no batches (paper, section IV). A small processor has no
//! vectors that would repay them.

use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
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

/// Sweeps the boxes themselves along a list of slots by ascending minimum on an axis, and writes the pairs
/// that fit. Returns how many there are, and how many boxes overlap along the axis: at most n²/2. O(n + that).
pub(crate) fn sweep<I: Index>(
    list: &[I],
    boxes: &[KeyBox],
    axis: u8,
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
) -> (usize, usize) {
    match axis {
        0 => sweep_along::<I, 0, 2, 1>(list, boxes, pair_filter, pairs),
        1 => sweep_along::<I, 1, 0, 2>(list, boxes, pair_filter, pairs),
        _ => sweep_along::<I, 2, 0, 1>(list, boxes, pair_filter, pairs),
    }
}

/// With constant axes, and not inline, so that the inner loop stays in registers.
#[inline(never)]
fn sweep_along<I: Index, const W: usize, const U: usize, const V: usize>(
    list: &[I],
    boxes: &[KeyBox],
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
) -> (usize, usize) {
    let (all, mut places, mut without_room) = (pairs.len(), pairs.iter_mut(), 0);
    let (mut rest, mut candidates) = (list.iter(), 0);
    while let Some(slot) = rest.next() {
        let KeyBox { min, max } = *KeyBox::of(boxes, slot.at());
        let mut ahead = rest.clone();
        candidates += ahead.len();
        for other in ahead.by_ref() {
            let Some(b) = boxes.get(other.at()).filter(|b| b.min[W] <= max[W]) else {
                // Neither this one nor those behind it.
                candidates -= 1;
                break;
            };
            if b.min[U] > max[U] || min[U] > b.max[U] || b.min[V] > max[V] || min[V] > b.max[V] {
                continue;
            }
            let pair = pair(slot.slot(), other.slot());
            if pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(pair)) {
                match places.next() {
                    Some(place) => *place = pair,
                    None => without_room += 1,
                }
            }
        }
        candidates -= ahead.len();
    }
    (all - places.len() + without_room, candidates)
}
