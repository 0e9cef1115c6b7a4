//! Sweeps a small world straight from its sorted list over the boxes themselves: no records, no batches, and nothing
//! between the compares. A small processor has no vectors that would make up for more.

use crate::access::Access;
use crate::id::{Index, Pair, pair};
use crate::key::KeyBox;
use bytemuck::{Pod, Zeroable};

/// What a sweep came to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    /// Overlapping pairs, whether they fitted or not.
    pub(crate) pairs: usize,
    /// Pairs of boxes that overlap along the axis.
    pub(crate) candidates: usize,
}

/// A box that is swept, and whose it is. Its keys stand in the order of the axes: the swept one, the one across which
/// the strips lie, the last one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Member {
    min: [i32; 3],
    max: [i32; 3],
    slot: u32,
}

/// Strips that a world is cut into: along one axis alone, most of what overlaps is far apart.
const STRIPS: usize = 4;
/// Fewer objects are not cut.
const STRIPED_FROM: usize = 48;
/// Minima that are looked at to place the strips.
const SAMPLE: usize = 16;

/// Writes the pairs of overlapping boxes that fit. `order` has the slots by ascending minimum on the first of `axes`;
/// `members` has room for as many, or none.
///
/// O(n + candidates).
pub(crate) fn sweep<I: Index>(
    order: &[I],
    boxes: &[KeyBox],
    axes: [usize; 3],
    members: &mut [Member],
    pairs: &mut [Pair<I>],
) -> Found {
    if members.len() < order.len() {
        return sweep_in_place(order, boxes, axes[0], pairs);
    }
    // A fuller strip takes in all that is left. So there are at most 1.75 times as many tests as without strips: three
    // quarters for three strips of half the objects, and one for a strip of all.
    let most = order.len() / 2;
    let mut found = Found::default();
    let mut from = i32::MIN;
    for until in planes(order, boxes, axes[1]) {
        if until <= from {
            continue;
        }
        let mut strip = Strip { from, until };
        let mut count = strip.gather(order, boxes, axes, members);
        if count > most && until < i32::MAX {
            strip.until = i32::MAX;
            count = strip.gather(order, boxes, axes, members);
        }
        found = strip.sweep(members.span(0, count), found, pairs);
        from = strip.until;
    }
    found
}

/// Where the strips end: at quartiles of some minima, and the last one nowhere.
fn planes<I: Index>(order: &[I], boxes: &[KeyBox], axis: usize) -> [i32; STRIPS] {
    let mut planes = [i32::MAX; STRIPS];
    if order.len() < STRIPED_FROM {
        return planes;
    }
    let mut sample = [i32::MAX; SAMPLE];
    let mut count = 0;
    for slot in order.iter().step_by(order.len().div_ceil(SAMPLE)) {
        let key = KeyBox::of(boxes, slot.at()).min[axis % 3];
        let mut to = count;
        while to > 0 {
            let below = sample.at(to - 1);
            if below <= key {
                break;
            }
            sample.put(to, below);
            to -= 1;
        }
        sample.put(to, key);
        count += 1;
    }
    for (index, plane) in planes.iter_mut().take(STRIPS - 1).enumerate() {
        *plane = sample.at((index + 1) * count / STRIPS);
    }
    planes
}

/// The boxes that reach into the minima from one key on and below another. A pair of boxes is in the strip where the
/// upper of their minima is, and reported there alone.
struct Strip {
    from: i32,
    until: i32,
}

impl Strip {
    /// Copies the boxes of the strip, in their order, and returns how many there are.
    #[inline(never)]
    fn gather<I: Index>(
        &self,
        order: &[I],
        boxes: &[KeyBox],
        axes: [usize; 3],
        members: &mut [Member],
    ) -> usize {
        // Never above 2, but for the compiler, which then checks no index.
        let (u, v, w) = (axes[0].min(2), axes[1].min(2), axes[2].min(2));
        let mut count = 0;
        let mut places = members.iter_mut();
        for slot in order {
            let Some(KeyBox { min, max }) = boxes.get(slot.at()) else { continue };
            if min[v] < self.until && max[v] >= self.from {
                let Some(place) = places.next() else { break };
                *place =
                    Member { min: [min[u], min[v], min[w]], max: [max[u], max[v], max[w]], slot: slot.slot() };
                count += 1;
            }
        }
        count
    }

    /// Adds the strip's pairs. In a function of its own, so that the inner loop keeps to the registers.
    #[inline(never)]
    fn sweep<I: Index>(&self, members: &[Member], found: Found, pairs: &mut [Pair<I>]) -> Found {
        let Found { pairs: mut total, mut candidates } = found;
        let mut members = members;
        while let Some((&a, others)) = members.split_first() {
            let mut rest = others;
            while let Some((b, others)) = rest.split_first() {
                if b.min[0] > a.max[0] {
                    break;
                }
                rest = others;
                let overlap = b.min[2] <= a.max[2]
                    && a.min[2] <= b.max[2]
                    && b.min[1] <= a.max[1]
                    && a.min[1] <= b.max[1];
                if overlap && a.min[1].max(b.min[1]) >= self.from {
                    if let Some(place) = pairs.get_mut(total) {
                        *place = pair(a.slot, b.slot);
                    }
                    total += 1;
                }
            }
            candidates += others.len() - rest.len();
            members = others;
        }
        Found { pairs: total, candidates }
    }
}

/// Without room for members.
fn sweep_in_place<I: Index>(order: &[I], boxes: &[KeyBox], axis: usize, pairs: &mut [Pair<I>]) -> Found {
    match axis {
        0 => sweep_along::<I, 0, 1, 2>(order, boxes, pairs),
        1 => sweep_along::<I, 1, 2, 0>(order, boxes, pairs),
        _ => sweep_along::<I, 2, 0, 1>(order, boxes, pairs),
    }
}

/// With the axes known, and in a function of its own, so that the inner loop keeps to the registers.
#[inline(never)]
fn sweep_along<I: Index, const W: usize, const U: usize, const V: usize>(
    order: &[I],
    boxes: &[KeyBox],
    pairs: &mut [Pair<I>],
) -> Found {
    let mut found = Found::default();
    let mut rest = order;
    while let Some((&slot, others)) = rest.split_first() {
        let KeyBox { min, max } = *KeyBox::of(boxes, slot.at());
        let mut passed = others.len();
        for (index, &other) in others.iter().enumerate() {
            let b = KeyBox::of(boxes, other.at());
            if b.min[W] > max[W] {
                passed = index;
                break;
            }
            if b.min[U] <= max[U] && min[U] <= b.max[U] && b.min[V] <= max[V] && min[V] <= b.max[V] {
                if let Some(place) = pairs.get_mut(found.pairs) {
                    *place = pair(slot.slot(), other.slot());
                }
                found.pairs += 1;
            }
        }
        found.candidates += passed;
        rest = others;
    }
    found
}
