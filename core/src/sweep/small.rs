//! Sweeps a small world straight from its sorted list over the boxes themselves: no records, no batches, and nothing
//! between the compares. A small processor has no vectors that would make up for more. Where there is room, the world is
//! cut into strips across a second axis, and the boxes of a strip stand in the order of the list.

use crate::access::Access;
use crate::filter::Gate;
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

/// A box that is swept, and whose it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Member {
    bounds: KeyBox,
    /// The slot, and above it a mark: the minimum is below the strip. Two marked boxes are in a lower strip together.
    tag: u32,
}

impl Member {
    const BELOW: u32 = 1 << 31;
}

/// Strips that a world is cut into: along one axis alone, most of what overlaps is far apart.
const STRIPS: usize = 4;
/// Fewer objects are not cut.
const STRIPED_FROM: usize = 48;
/// Minima that are looked at to place the strips.
const SAMPLE: usize = 16;

/// Room in which a world is swept in strips, or none.
pub(crate) struct Room<'m, I> {
    /// The boxes of one strip, or of all, in the order of the list.
    pub(crate) members: &'m mut [Member],
    /// The slots of each strip: room for 5/8 of all in each.
    pub(crate) strips: &'m mut [I],
}

/// Slots that the strips have room for, in a world for so many objects.
pub(crate) const fn strip_slots(objects: usize) -> usize {
    STRIPS * (objects * 5 / 8)
}

/// Writes the pairs of overlapping boxes that fit. `order` has the slots by ascending minimum on the first of `axes`; strips lie
/// across the second one.
///
/// O(n + candidates), and at most 0.8 n² tests: strips have at most 5/8 of the objects each, or there are none.
pub(crate) fn sweep<I: Index>(
    order: &[I],
    boxes: &[KeyBox],
    axes: [usize; 2],
    room: Room<'_, I>,
    gate: Option<Gate<'_>>,
    pairs: &mut [Pair<I>],
) -> Found {
    let Room { members, strips } = room;
    if members.len() < order.len() {
        return sweep_in_place(order, boxes, axes[0], gate, pairs);
    }
    let planes = planes(order, boxes, axes[1]);
    let length = strips.len() / STRIPS;
    let mut found = Found::default();
    let Some(counts) = divide(order, boxes, axes[1], &planes, strips) else {
        let members = gather(order, boxes, axes[1], i32::MIN, members);
        return sweep_strip(members, axes[0], gate, found, pairs);
    };
    let mut from = i32::MIN;
    for (index, count) in counts.into_iter().enumerate() {
        let members = gather(strips.span(index * length, count), boxes, axes[1], from, members);
        found = sweep_strip(members, axes[0], gate, found, pairs);
        from = planes.get(index).copied().unwrap_or_default();
    }
    found
}

/// Where strips begin, but for the first: at quartiles of some minima.
fn planes<I: Index>(order: &[I], boxes: &[KeyBox], axis: usize) -> [i32; STRIPS - 1] {
    let mut sample = [i32::MAX; SAMPLE];
    let mut count = 0;
    for slot in order.iter().step_by(order.len().div_ceil(SAMPLE).max(1)) {
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
    [1, 2, 3].map(|quarter| sample.at(quarter * count / STRIPS))
}

/// Writes the slots of each strip, in their order, and returns how many there are. A box is in all strips that it
/// reaches; a strip is where its minimum is, or an upper one. `None` where the strips are no gain: there are few
/// objects, or one strip has more than 5/8 of them.
#[inline(never)]
fn divide<I: Index>(
    order: &[I],
    boxes: &[KeyBox],
    axis: usize,
    planes: &[i32; STRIPS - 1],
    strips: &mut [I],
) -> Option<[usize; STRIPS]> {
    if order.len() < STRIPED_FROM {
        return None;
    }
    let stride = strips.len() / STRIPS;
    let most = (order.len() * 5 / 8).min(stride);
    let mut counts = [0; STRIPS];
    for &slot in order {
        let KeyBox { min, max } = boxes.get(slot.at())?;
        let (min, max) = (min[axis.min(2)], max[axis.min(2)]);
        let [p, q, r] = *planes;
        let home = usize::from(min >= p) + usize::from(min >= q) + usize::from(min >= r);
        let mut strip = home;
        while let Some(count) = counts.get_mut(strip) {
            if *count >= most {
                return None;
            }
            *strips.get_mut(strip * stride + *count)? = slot;
            *count += 1;
            if planes.get(strip).is_none_or(|plane| max < *plane) {
                break;
            }
            strip += 1;
        }
    }
    Some(counts)
}

/// Copies the boxes of a strip that begins at a key.
#[inline(never)]
fn gather<'m, I: Index>(
    slots: &[I],
    boxes: &[KeyBox],
    axis: usize,
    from: i32,
    members: &'m mut [Member],
) -> &'m [Member] {
    for (member, slot) in members.iter_mut().zip(slots) {
        if let Some(bounds) = boxes.get(slot.at()) {
            let below = bounds.min[axis.min(2)] < from;
            *member = Member { bounds: *bounds, tag: slot.slot() | u32::from(below) << 31 };
        }
    }
    members.span(0, slots.len())
}

/// Adds the pairs of a strip, or of all.
fn sweep_strip<I: Index>(
    members: &[Member],
    axis: usize,
    gate: Option<Gate<'_>>,
    found: Found,
    pairs: &mut [Pair<I>],
) -> Found {
    match axis {
        0 => sweep_members::<I, 0, 1, 2>(members, gate, found, pairs),
        1 => sweep_members::<I, 1, 2, 0>(members, gate, found, pairs),
        _ => sweep_members::<I, 2, 0, 1>(members, gate, found, pairs),
    }
}

/// With the axes known, and in a function of its own, so that the inner loop keeps to the registers.
#[inline(never)]
fn sweep_members<I: Index, const W: usize, const U: usize, const V: usize>(
    members: &[Member],
    gate: Option<Gate<'_>>,
    found: Found,
    pairs: &mut [Pair<I>],
) -> Found {
    let Found { pairs: mut total, mut candidates } = found;
    let mut members = members;
    while let Some((&a, others)) = members.split_first() {
        let KeyBox { min, max } = a.bounds;
        let mut rest = others;
        while let Some((b, others)) = rest.split_first() {
            let Member { bounds: other, tag } = b;
            if other.min[W] > max[W] {
                break;
            }
            rest = others;
            let apart = other.min[V] > max[V]
                || min[V] > other.max[V]
                || other.min[U] > max[U]
                || min[U] > other.max[U];
            if !apart && a.tag & tag & Member::BELOW == 0 {
                let pair = pair(a.tag & !Member::BELOW, tag & !Member::BELOW);
                if gate.is_none_or(|gate| gate.lets_through(&pair)) {
                    if let Some(place) = pairs.get_mut(total) {
                        *place = pair;
                    }
                    total += 1;
                }
            }
        }
        candidates += others.len() - rest.len();
        members = others;
    }
    Found { pairs: total, candidates }
}

/// Without room for members.
fn sweep_in_place<I: Index>(
    order: &[I],
    boxes: &[KeyBox],
    axis: usize,
    gate: Option<Gate<'_>>,
    pairs: &mut [Pair<I>],
) -> Found {
    match axis {
        0 => sweep_along::<I, 0, 1, 2>(order, boxes, gate, pairs),
        1 => sweep_along::<I, 1, 2, 0>(order, boxes, gate, pairs),
        _ => sweep_along::<I, 2, 0, 1>(order, boxes, gate, pairs),
    }
}

/// With the axes known, and in a function of its own, so that the inner loop keeps to the registers.
#[inline(never)]
fn sweep_along<I: Index, const W: usize, const U: usize, const V: usize>(
    order: &[I],
    boxes: &[KeyBox],
    gate: Option<Gate<'_>>,
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
                let pair = pair(slot.slot(), other.slot());
                if gate.is_none_or(|gate| gate.lets_through(&pair)) {
                    if let Some(place) = pairs.get_mut(found.pairs) {
                        *place = pair;
                    }
                    found.pairs += 1;
                }
            }
        }
        found.candidates += passed;
        rest = others;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::links::repair;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    /// Boxes of one size or of many, spread or on a heap, with equal sides among them.
    fn boxes() -> impl Strategy<Value = Vec<KeyBox>> {
        let low = prop_oneof![-40i32..40, -4000i32..4000];
        let one = ([low.clone(), low.clone(), low], [0i32..60, 0i32..60, 0i32..60], 0i32..40);
        (prop::collection::vec(one, 0..256), 0u32..8).prop_map(|(boxes, shift)| {
            let bounds = |(min, size, large): ([i32; 3], [i32; 3], i32)| {
                let stretch = if large == 0 { 100 } else { 1 };
                let min = min.map(|low| low >> shift);
                KeyBox { min, max: [0, 1, 2].map(|k| min[k] + size[k] * stretch) }
            };
            boxes.into_iter().map(bounds).collect()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn strips_find_each_pair_once(boxes in boxes(), axis in 0usize..3, other in 1usize..3, full in any::<bool>()) {
            let n = boxes.len();
            let axes = [axis, (axis + other) % 3];
            let mut order: Vec<u16> = (0..n as u16).collect();
            repair(&mut order, &boxes, axis, &mut []);
            let mut expected = Vec::new();
            for a in 0..n {
                expected.extend((a + 1..n).filter(|&b| boxes[a].overlaps(&boxes[b])).map(|b| [a as u16, b as u16]));
            }
            let fitting = if full { expected.len() / 2 } else { expected.len() };
            let (mut members, mut strips) = (vec![Member::default(); 256], vec![0u16; strip_slots(256)]);
            let in_strips = Room { members: &mut members, strips: &mut strips };
            for room in [in_strips, Room { members: &mut [], strips: &mut [] }] {
                let mut pairs = vec![[0; 2]; fitting];
                let found = sweep(&order, &boxes, axes, room, None, &mut pairs);
                prop_assert_eq!(found.pairs, expected.len());
                prop_assert!(found.candidates >= found.pairs && 5 * found.candidates <= 4 * n * n);
                pairs.sort_unstable();
                if full {
                    prop_assert!(pairs.windows(2).all(|two| two[0] < two[1]));
                    prop_assert!(pairs.iter().all(|pair| expected.binary_search(pair).is_ok()));
                } else {
                    prop_assert_eq!(&pairs, &expected);
                }
            }
        }
    }
}
