//! Sweeps copies of the boxes, in stripes. A second axis is cut into stripes, and a box is in the stripe of its
//! minimum. The copies are in order: stripe by stripe, each ascending along the first axis. The list has the same
//! order from step to step. A box meets those behind it in its own stripe, and in each higher stripe that it reaches
//! those that overlap it along the first axis. So no two boxes meet twice.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::memory::stripes::{Member, STRIPES, StripeStarts};
use crate::pairs::pair_filter::PairFilter;
use crate::sort::heapsort;
use crate::sweep::small::Found;

/// The axes of a member: along the sweep, across the stripes, the third one.
const W: usize = 0;
const U: usize = 1;
const V: usize = 2;

/// Bits of the slot in a tag.
const SLOT_BITS: u32 = 16;

impl Member {
    #[inline(always)]
    fn new(bounds: &KeyBox, [w, u, v]: [usize; 3], stripe: usize, slot: u32) -> Self {
        let KeyBox { min, max } = bounds;
        let tag = (stripe as u32) << SLOT_BITS | slot;
        Self { min: [min[w], min[u], min[v]], max: [max[w], max[u], max[v]], tag }
    }

    #[inline(always)]
    fn slot(&self) -> u32 {
        self.tag & ((1 << SLOT_BITS) - 1)
    }

    #[inline(always)]
    fn stripe(&self) -> usize {
        (self.tag >> SLOT_BITS) as usize
    }
}

/// Minima that are sampled to choose where stripes start.
const SAMPLE: usize = 4 * STRIPES;
/// With more samples than this in one stripe, the starts are chosen anew.
const CROWDED: usize = SAMPLE / 4;

/// A world that is swept in stripes.
pub(crate) struct Striped<'m, I> {
    /// The slots of the living objects.
    pub(crate) order: &'m mut [I],
    pub(crate) boxes: &'m [KeyBox],
    /// The axis along which stripes are swept, and the axis that they divide.
    pub(crate) axes: [usize; 2],
    pub(crate) starts: &'m mut StripeStarts,
    /// One for each slot.
    pub(crate) members: &'m mut [Member],
}

/// The stripe of a minimum.
#[inline(always)]
fn stripe_of(starts: &StripeStarts, min: i32) -> usize {
    // By halves, written out: loops are slow if compiled for size.
    let half = usize::from(min >= starts[STRIPES / 2]) * (STRIPES / 2);
    let quarter = half + usize::from(min >= starts.at(half + STRIPES / 4)) * (STRIPES / 4);
    quarter + usize::from(min >= starts.at(quarter + 1))
}
const _: () = assert!(STRIPES == 8);

/// The total order of the list: by stripe, then by minimum, then by slot.
pub(crate) fn place(bounds: &KeyBox, slot: u32, axes: [usize; 2], starts: &StripeStarts) -> u64 {
    let [along, across] = axes.map(|axis| bounds.min.at(axis));
    // With the sign bit flipped, keys have the order of unsigned integers.
    let key = u64::from(along as u32 ^ 1 << 31);
    (stripe_of(starts, across) as u64) << (32 + SLOT_BITS) | key << SLOT_BITS | u64::from(slot)
}

impl<I: Index> Striped<'_, I> {
    /// Keeps the starts while they divide the minima well, else puts them at the quantiles of a sample. Takes objects
    /// by slot, since a world that was loaded has no list. O(n).
    #[inline(never)]
    pub(crate) fn divide(&mut self) {
        let mut sample = [i32::MAX; SAMPLE];
        let mut counts = [0usize; STRIPES];
        let mut count = 0;
        let boxes = self.boxes.iter().filter(|bounds| !bounds.is_empty());
        for bounds in boxes.step_by(self.order.len().div_ceil(SAMPLE).max(1)) {
            let key = bounds.min.at(self.axes[1]);
            let stripe = stripe_of(self.starts, key);
            let known = counts.at(stripe);
            counts.put(stripe, known + 1);
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
        if counts.iter().any(|count| *count > CROWDED) {
            for (stripe, start) in self.starts.iter_mut().enumerate() {
                *start = if stripe == 0 { i32::MIN } else { sample.at(stripe * count / STRIPES) };
            }
        }
    }

    /// Copies the boxes in order, and sorts the list in the same way: by insertion while that is cheap, else after a
    /// heap sort. O(n) at best, else O(n log n).
    pub(crate) fn arrange(&mut self) {
        if !self.insert() {
            self.sort();
            self.insert();
        }
    }

    /// As [`arrange`](Self::arrange); `false` if too many objects have overtaken each other.
    #[inline(never)]
    fn insert(&mut self) -> bool {
        let Self { order, boxes, axes, starts, members } = self;
        let (w, u) = (axes[0].min(2), axes[1].min(2));
        let axes = [w, u, (3 - w).saturating_sub(u).min(2)];
        let Some(members) = members.get_mut(..order.len()) else { return true };
        let mut budget = crate::lists::links::INVERSIONS_PER_OBJECT * order.len() + 64;
        // The last member that is in order, and the bounds of its stripe: none yet.
        let (mut last, mut stripe, mut low, mut high) = (i32::MIN, 0, i32::MAX, i32::MIN);
        for at in 0..order.len() {
            let slot = order.at(at);
            let Some(bounds) = boxes.get(slot.at()) else { continue };
            let (key, side) = (bounds.min[w], bounds.min[u]);
            if side >= low && side < high && key > last {
                last = key;
                members.put(at, Member::new(bounds, axes, stripe, slot.slot()));
                continue;
            }
            let own = stripe_of(starts, side);
            let mut to = at;
            while to > 0 {
                let Some([below, above]) =
                    members.get_mut(to - 1..).and_then(|tail| tail.first_chunk_mut::<2>())
                else {
                    break;
                };
                if (below.stripe(), below.min[W], below.slot()) < (own, key, slot.slot()) {
                    break;
                }
                *above = *below;
                order.put(to, I::from_slot(below.slot()));
                to -= 1;
            }
            members.put(to, Member::new(bounds, axes, own, slot.slot()));
            order.put(to, slot);
            if to == at {
                (last, stripe, low) = (key, own, starts.at(own));
                high = starts.get(own + 1).copied().unwrap_or(i32::MAX);
            }
            match budget.checked_sub(at - to) {
                Some(left) => budget = left,
                None => return false,
            }
        }
        true
    }

    /// Sorts the list, in the memory of the members.
    #[inline(never)]
    fn sort(&mut self) {
        let (_, places, _) = bytemuck::pod_align_to_mut::<Member, u64>(self.members);
        let places = places.span_mut(0, self.order.len());
        for (to, slot) in places.iter_mut().zip(&*self.order) {
            *to = place(KeyBox::of(self.boxes, slot.at()), slot.slot(), self.axes, self.starts);
        }
        heapsort(places, |a, b| a < b);
        for (slot, place) in self.order.iter_mut().zip(places) {
            *slot = I::from_slot(*place as u32 & ((1 << SLOT_BITS) - 1));
        }
    }

    /// Writes the pairs of overlapping members that fit. O(n + candidates); candidates are at most n²/2.
    pub(crate) fn sweep(&self, pair_filter: Option<PairFilter<'_>>, pairs: &mut [Pair<I>]) -> Found {
        sweep(self.members.span(0, self.order.len()), self.starts, pair_filter, pairs)
    }
}

/// Not inline, so that the inner loop stays in registers.
#[inline(never)]
fn sweep<I: Index>(
    members: &[Member],
    starts: &StripeStarts,
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
) -> Found {
    let mut found = Found::default();
    let mut stripes: [&[Member]; STRIPES] = [&[]; STRIPES];
    let mut rest = members;
    for (index, stripe) in stripes.iter_mut().enumerate() {
        (*stripe, rest) = rest.split_at(rest.partition_point(|member| member.stripe() <= index));
    }
    for index in 0..STRIPES {
        // The members of higher stripes that later members may still meet.
        let mut ahead = stripes;
        let mut own = stripes[index];
        while let Some((a, others)) = own.split_first() {
            own = others;
            let Member { min, max, .. } = *a;
            let mut met = others;
            let mut upper = index;
            loop {
                let mut rest = met;
                while let Some((b, others)) = rest.split_first() {
                    let Member { min: low, max: high, .. } = b;
                    if low[W] > max[W] {
                        break;
                    }
                    rest = others;
                    let apart = low[U] > max[U]
                        || low[V] > max[V]
                        || min[V] > high[V]
                        || min[U] > high[U]
                        || min[W] > high[W];
                    if !apart {
                        let pair = pair(a.slot(), b.slot());
                        if pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(&pair)) {
                            if let Some(place) = pairs.get_mut(found.pairs) {
                                *place = pair;
                            }
                            found.pairs += 1;
                        }
                    }
                }
                found.candidates += met.len() - rest.len();
                upper += 1;
                let Some(stripe) = ahead.get_mut(upper) else { break };
                if max[U] < starts.at(upper) {
                    break;
                }
                while let Some((first, others)) = stripe.split_first() {
                    if first.max[W] >= min[W] {
                        break;
                    }
                    *stripe = others;
                }
                met = stripe;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::small::tests::{boxes, check};
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn each_pair_is_found_once(
            frames in prop::collection::vec(boxes(), 1..4),
            few in 0usize..8,
            axes in (0usize..3, 1usize..3, any::<bool>()),
            full in any::<bool>(),
        ) {
            let axes = [axes.0, (axes.0 + axes.1) % 3];
            let n = frames.iter().map(Vec::len).min().unwrap_or_default();
            let mut order: Vec<u16> = (0..n as u16).collect();
            let mut starts = [0; STRIPES];
            let mut members = vec![Member::default(); 256];
            let mut boxes = frames[0][..n].to_vec();
            for (index, frame) in frames.iter().enumerate() {
                // All boxes change, or some.
                for slot in (0..n).step_by(few + 1) {
                    boxes[slot] = frame[slot];
                }
                let mut striped =
                    Striped { order: &mut order, boxes: &boxes, axes, starts: &mut starts, members: &mut members };
                if index != 1 {
                    striped.divide();
                }
                striped.arrange();
                prop_assert!(striped.starts.is_sorted());
                check(&boxes, full, |pairs| striped.sweep(None, pairs));
                let places = order.iter().map(|&slot| place(&boxes[slot as usize], slot.into(), axes, &starts));
                prop_assert!(places.is_sorted_by(|a, b| a < b));
            }
        }
    }

    #[test]
    fn planes_divide_boxes_evenly_and_stay() {
        let n = 200i32;
        let scattered = |index: i32| index.wrapping_mul(0x9e37_79b1_u32 as i32);
        let boxes: Vec<_> = (0..n).map(|index| KeyBox::at([index, scattered(index), 0])).collect();
        let mut order: Vec<u16> = (0..n as u16).collect();
        let mut starts = [0; STRIPES];
        let mut members = vec![Member::default(); boxes.len()];
        let mut striped = Striped {
            order: &mut order,
            boxes: &boxes,
            axes: [0, 1],
            starts: &mut starts,
            members: &mut members,
        };
        striped.divide();
        striped.arrange();
        let chosen = *striped.starts;
        for stripe in 0..STRIPES {
            let count = striped.members.iter().filter(|member| member.stripe() == stripe).count();
            assert!(count > 0 && count < boxes.len() / 3, "{count} of {} in a stripe", boxes.len());
        }
        striped.divide();
        assert_eq!(*striped.starts, chosen);
    }
}
