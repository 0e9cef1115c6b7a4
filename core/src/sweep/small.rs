//! Sweeps a small world straight from its sorted list over the boxes themselves: no records, no batches, and nothing
//! between the compares. A small processor has no vectors that would make up for more.

use crate::access::Access;
use crate::filter::Gate;
use crate::id::{Index, Pair, pair};
use crate::key::KeyBox;

/// What a sweep came to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    /// Overlapping pairs, whether they fitted or not.
    pub(crate) pairs: usize,
    /// Pairs of boxes that overlap along the axis.
    pub(crate) candidates: usize,
}

/// Writes the pairs of overlapping boxes that fit. `order` has the slots by ascending minimum on `axis`; `sorted` has
/// room for their boxes in that order, or none.
///
/// O(n + candidates), and so at most n (n - 1) / 2 tests.
pub(crate) fn sweep<I: Index>(
    order: &[I],
    boxes: &[KeyBox],
    axis: usize,
    gate: Option<Gate<'_>>,
    sorted: &mut [KeyBox],
    pairs: &mut [Pair<I>],
) -> Found {
    if sorted.len() < order.len() {
        let boxes = order.iter().map(|slot| boxes.get(slot.at()).unwrap_or(&KeyBox::EMPTY));
        return sweep_boxes(order, boxes, axis, gate, pairs);
    }
    for (to, slot) in sorted.iter_mut().zip(order) {
        if let Some(from) = boxes.get(slot.at()) {
            *to = *from;
        }
    }
    sweep_boxes(order, sorted.span(0, order.len()).iter(), axis, gate, pairs)
}

fn sweep_boxes<'b, I: Index>(
    order: &[I],
    boxes: impl Iterator<Item = &'b KeyBox> + Clone,
    axis: usize,
    gate: Option<Gate<'_>>,
    pairs: &mut [Pair<I>],
) -> Found {
    match axis {
        0 => sweep_along::<I, _, 0, 1, 2>(order, boxes, gate, pairs),
        1 => sweep_along::<I, _, 1, 2, 0>(order, boxes, gate, pairs),
        _ => sweep_along::<I, _, 2, 0, 1>(order, boxes, gate, pairs),
    }
}

/// With the axes known, and in a function of its own, so that the inner loop keeps to the registers.
#[inline(never)]
fn sweep_along<'b, I, B, const W: usize, const U: usize, const V: usize>(
    order: &[I],
    mut boxes: B,
    gate: Option<Gate<'_>>,
    pairs: &mut [Pair<I>],
) -> Found
where
    I: Index,
    B: Iterator<Item = &'b KeyBox> + Clone,
{
    let mut found = Found::default();
    for (at, slot) in order.iter().enumerate() {
        let Some(&KeyBox { min, max }) = boxes.next() else { break };
        let mut other = at;
        for b in boxes.clone() {
            if b.min[W] > max[W] {
                break;
            }
            other += 1;
            if b.min[U] <= max[U] && min[U] <= b.max[U] && b.min[V] <= max[V] && min[V] <= b.max[V] {
                let pair = pair(slot.slot(), order.at(other).slot());
                if gate.is_some_and(|gate| !gate.lets_through(&pair)) {
                    continue;
                }
                if let Some(place) = pairs.get_mut(found.pairs) {
                    *place = pair;
                }
                found.pairs += 1;
            }
        }
        found.candidates += other - at;
    }
    found
}
