//! Sweeps the boxes themselves along a sorted list (paper, section IV): no records and no batches. A small
//! processor has no vectors that would repay them.

use crate::config::{FILTERS, TREE};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::pairs::pair_filter::PairFilter;

/// The result of a sweep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    /// Overlapping pairs, whether there was room or not.
    pub(crate) pairs: usize,
    /// Pairs of boxes that overlap along the axis.
    pub(crate) candidates: usize,
}

/// Writes the pairs of overlapping boxes that fit, behind the pairs `found` before: of a list, or of two
/// lists if the second one has objects. Lists have slots by ascending minimum on the first of two axes; the
/// second one is tested first. O(n + candidates); candidates are at most n²/2.
pub(crate) fn sweep<I: Index>(
    lists: [&[I]; 2],
    boxes: &[KeyBox],
    axes: [usize; 2],
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
    found: &mut Found,
) {
    // A small build has three copies, not six. They test y last: in most scenes few boxes are apart in
    // height.
    match axes {
        [0, 1] if TREE => sweep_along::<I, 0, 1, 2>(lists, boxes, pair_filter, pairs, found),
        [0, _] => sweep_along::<I, 0, 2, 1>(lists, boxes, pair_filter, pairs, found),
        [1, 2] if TREE => sweep_along::<I, 1, 2, 0>(lists, boxes, pair_filter, pairs, found),
        [1, _] => sweep_along::<I, 1, 0, 2>(lists, boxes, pair_filter, pairs, found),
        [_, 1] if TREE => sweep_along::<I, 2, 1, 0>(lists, boxes, pair_filter, pairs, found),
        _ => sweep_along::<I, 2, 0, 1>(lists, boxes, pair_filter, pairs, found),
    }
}

/// With constant axes, and not inline, so that the inner loop stays in registers.
#[inline(never)]
fn sweep_along<I: Index, const W: usize, const U: usize, const V: usize>(
    [mut rest, mut other]: [&[I]; 2],
    boxes: &[KeyBox],
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
    found: &mut Found,
) {
    let across = FILTERS && TREE && !other.is_empty();
    let (mut written, mut candidates) = (found.pairs, 0);
    let mut room = pairs.get_mut(written..).unwrap_or_default().iter_mut();
    while let Some((&slot, behind)) = rest.split_first() {
        let KeyBox { min, max } = *KeyBox::of(boxes, slot.at());
        let mut others = behind;
        if across {
            // The lower one of the first two meets the other list.
            match other.first() {
                None => break,
                Some(next) if KeyBox::of(boxes, next.at()).min[W] < min[W] => {
                    core::mem::swap(&mut rest, &mut other);
                    continue;
                }
                Some(_) => others = other,
            }
        }
        rest = behind;
        let mut ahead = others;
        while let Some((&other, behind)) = ahead.split_first() {
            let Some(b) = boxes.get(other.at()) else { break };
            if b.min[W] > max[W] {
                break;
            }
            ahead = behind;
            if b.min[U] <= max[U] && min[U] <= b.max[U] && b.min[V] <= max[V] && min[V] <= b.max[V] {
                let pair = pair(slot.slot(), other.slot());
                if pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(&pair)) {
                    if let Some(place) = room.next() {
                        *place = pair;
                    }
                    written += 1;
                }
            }
        }
        candidates += others.len() - ahead.len();
    }
    *found = Found { pairs: written, candidates: found.candidates + candidates };
}
