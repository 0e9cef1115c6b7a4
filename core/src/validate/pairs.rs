//! Checks the pairs that a snapshot does not have: which are parked or surplus, how they are divided, and that those
//! which the next step would keep are all that there are.
//!
//! Whether a pair is missing or double is seen from a sum over all pairs and one over all overlaps, 64 mixed bits each:
//! there is no memory to write them down twice.

use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::limits::LEAF_TARGET;
use crate::memory::slab::Parts;
use crate::pairs::partition::is_clear_of;
use crate::simd::kernels::{Kernels, run};
use crate::simd::{Simd, limit};
use crate::snapshot::check::{Invalid, check};
use crate::tree::first_of_eight;
use crate::tree::large::Large;
use crate::tree::visit::Visit;

/// Checks all of it.
pub(super) fn pairs<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &*parts.state;
    let (swept, now, result) = (parts.boxes.swept(), &*parts.boxes.now, state.pairs.result());
    let keeps_changed = !parts.changed.words.is_empty();
    for (at, pair) in parts.output.pairs.span(0, state.pairs.swept as usize).iter().enumerate() {
        let [a, b] = pair.map(Index::at);
        check(a < b && b < state.objects.slots as usize, "a pair is not of two slots in order", at)?;
        let is_parked = at < state.pairs.parked as usize;
        let parks = !parts.active.is_empty() && is_clear_of(parts.active, pair);
        let unknown = state.pairs.active == u32::MAX;
        check(parks || !is_parked, "a pair of an active object is parked", at)?;
        check(is_parked || !parks || unknown, "a pair of no active object is not parked", at)?;
        if !is_kept(parts, pair) || state.pairs.unkept != 0 {
            continue;
        }
        check(swept.at(a).overlaps(&swept.at(b)), "a pair does not overlap", at)?;
        // Without a move inside a margin the next step divides no pairs, whatever is marked as changed.
        let unchanged =
            state.objects.moved_inside_margin == 0 || keeps_changed && is_clear_of(parts.changed.words, pair);
        let divided =
            !unchanged || !parts.has_surplus() || now.at(a).overlaps(&now.at(b)) == result.contains(&at);
        check(divided, "a pair overlaps and is surplus, or does not and is reported", at)?;
    }
    kept_pairs(parts)
}

/// Whether a step would keep a pair: neither object has moved.
fn is_kept<I: Index>(parts: &Parts<'_, I>, pair: &Pair<I>) -> bool {
    is_clear_of(parts.moved.words, pair) && is_clear_of(parts.settled.words, pair)
}

/// A sum over pairs, the same in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sum {
    count: u64,
    bits: u64,
}

impl Sum {
    /// Adds a pair, the lower slot first.
    fn add(&mut self, [a, b]: [u32; 2]) {
        // SplitMix64: each bit of a number changes each bit of the result for half of all numbers.
        let mut bits = (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.count += 1;
        self.bits = self.bits.wrapping_add(bits ^ bits >> 31);
    }
}

/// The sum over the pairs that a step would keep.
fn kept<I: Index>(parts: &Parts<'_, I>) -> Sum {
    let mut sum = Sum::default();
    let pairs = parts.output.pairs.span(0, parts.state.pairs.swept as usize);
    pairs.iter().filter(|pair| is_kept(parts, pair)).for_each(|pair| sum.add(pair.map(Index::slot)));
    sum
}

/// The pairs that the next step would keep are all that there are. Not checked if the step itself looks, or if a rule
/// may have refused pairs.
fn kept_pairs<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &*parts.state;
    let known = state.pairs.complete != 0 && state.pairs.unkept == 0;
    let filled = !parts.sizes.is_small() && state.tree.filled != 0;
    let few = state.objects.live as usize <= LEAF_TARGET && parts.moved.count() + parts.settled.count() == 0;
    if !known || !parts.filters.of.is_empty() || !filled && !few {
        return Ok(());
    }
    let all = if filled { run!(Kernels::detect(), |simd| in_tree(simd, parts)) } else { one_by_one(parts) };
    check(all == kept(parts), "pairs are missing, or there twice", 0)
}

/// Whether an object lives and has not moved.
fn stays<I: Index>(parts: &Parts<'_, I>, slot: usize) -> bool {
    let moved = bits::test(parts.moved.words, slot) || bits::test(parts.settled.words, slot);
    !KeyBox::of(parts.boxes.now, slot).is_empty() && !moved
}

/// The sum over all overlaps of objects that have not moved.
fn one_by_one<I: Index>(parts: &Parts<'_, I>) -> Sum {
    let (boxes, mut all) = (parts.boxes.swept(), Sum::default());
    let slots = 0..parts.state.objects.slots as usize;
    for a in slots.clone().filter(|slot| stays(parts, *slot)) {
        for b in a + 1..slots.end {
            if stays(parts, b) && KeyBox::of(boxes, a).overlaps(KeyBox::of(boxes, b)) {
                all.add([a as u32, b as u32]);
            }
        }
    }
    all
}

/// As [`one_by_one`], in a tree.
#[inline(always)]
fn in_tree<S: Simd, I: Index>(simd: S, parts: &Parts<'_, I>) -> Sum {
    let (state, tree, boxes) = (&*parts.state, &parts.tree, parts.boxes.swept());
    let (mut all, sub_levels) = (Sum::default(), state.tree.sub_levels());
    for slot in (0..state.objects.slots as usize).filter(|slot| stays(parts, *slot)) {
        let bounds = KeyBox::of(boxes, slot);
        // No vectors: a closure does not have the instruction set of its function.
        let mut meet = |other: usize| {
            if other > slot && stays(parts, other) && KeyBox::of(boxes, other).overlaps(bounds) {
                all.add([slot as u32, other as u32]);
            }
        };
        let mut visit = Visit::new(simd, tree.nodes(), 0, *bounds);
        while let Some(whole) = visit.next(simd) {
            let record = simd.record(&tree.frames.at(whole), simd.keys(bounds), 0);
            for part in whole << sub_levels..(whole + 1) << sub_levels {
                for (eight, left) in tree.leaves.at(part).chunks_of_eight(tree.records) {
                    let mut mask = simd.touching(eight, limit(&record)) & first_of_eight(left);
                    while mask != 0 {
                        meet(eight.at(mask.trailing_zeros() as usize).slot() as usize);
                        mask &= mask - 1;
                    }
                }
            }
        }
        let large = Large::new(&state.tree, tree.straddlers);
        large.each(simd, *bounds, |straddler| meet(straddler.slot as usize));
    }
    all
}
