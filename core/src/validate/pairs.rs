//! Checks the pairs that a snapshot does not have: which are parked or surplus, how they are divided, and
//! that the pairs which the next step would keep are all that there are.

use super::sum;
use crate::access::Access;
use crate::id::{Index, Pair};
use crate::memory::slab::Parts;
use crate::pairs::partition::is_clear_of;
use crate::snapshot::check::{Invalid, check};
use crate::world::World;
use core::ops::ControlFlow;

/// Checks all of it.
#[inline(never)]
pub(super) fn pairs<I: Index>(world: &World<'_, I>) -> Result<(), Invalid> {
    let (parts, state) = (&world.parts, &*world.parts.state);
    let (swept, now, front) = (parts.boxes.swept(), &*parts.boxes.now, state.pairs.in_front());
    for (at, pair) in overlaps(parts).enumerate() {
        let [a, b] = pair.map(Index::at);
        check(a < b && b < state.objects.slots as usize, "a pair is not of two slots in order", at)?;
        let is_parked = at < state.pairs.parked as usize || at >= front;
        let parks = !parts.active.is_empty() && is_clear_of(parts.active, pair);
        let unknown = state.pairs.active == u32::MAX;
        check(parks || !is_parked, "a pair of an active object is parked", at)?;
        check(is_parked || !parks || unknown, "a pair of no active object is not parked", at)?;
        if !is_kept(parts, pair) || state.pairs.unkept != 0 {
            continue;
        }
        check(swept.at(a).overlaps(&swept.at(b)), "a pair does not overlap", at)?;
        let unchanged = parts.changed.words.is_empty() || is_clear_of(parts.changed.words, pair);
        let divided = !unchanged
            || !parts.boxes.are_fat()
            || now.at(a).overlaps(&now.at(b)) == ((at as u64) < state.pairs.reported);
        check(divided, "a pair overlaps and is surplus, or does not and is reported", at)?;
    }
    kept_pairs(world)
}

/// The overlaps of swept boxes, the parked surplus last.
fn overlaps<'p, I: Index>(parts: &'p Parts<'_, I>) -> impl Iterator<Item = &'p Pair<I>> {
    let (pairs, parked) = (&parts.output.pairs, parts.state.pairs.surplus_parked as usize);
    pairs.span(0, parts.state.pairs.in_front()).iter().chain(pairs.span(pairs.len() - parked, parked))
}

/// Whether a step would keep a pair: neither object has moved.
fn is_kept<I: Index>(parts: &Parts<'_, I>, pair: &Pair<I>) -> bool {
    is_clear_of(parts.moved.words, pair) && is_clear_of(parts.settled.words, pair)
}

/// The pairs that the next step would keep are all that there are. Not checked if the step itself looks, or
/// if a rule may have refused pairs.
fn kept_pairs<I: Index>(world: &World<'_, I>) -> Result<(), Invalid> {
    let (parts, state) = (&world.parts, &*world.parts.state);
    let few = state.objects.live as usize <= state.setup.forced.leaf_target()
        && parts.moved.count() + parts.settled.count() == 0;
    if state.pairs.complete == 0
        || state.pairs.unkept != 0
        || !parts.filters.of.is_empty()
        || !world.has_tree() && !few
    {
        return Ok(());
    }
    let number = |[a, b]: [u32; 2]| u64::from(a) << 32 | u64::from(b);
    let kept =
        sum(overlaps(parts).filter(|pair| is_kept(parts, pair)).map(|pair| number(pair.map(Index::slot))));
    let mut all = 0u64;
    for slot in 0..state.objects.slots {
        let bounds = parts.boxes.swept().at(slot as usize);
        if bounds.is_empty() || !is_kept(parts, &[I::from_slot(slot); 2]) {
            continue;
        }
        world.visit_boxes(parts.boxes.swept(), bounds, None, &mut |id| {
            let is_counted = id.slot() > slot && is_kept(parts, &[I::from_slot(id.slot()); 2]);
            all = all.wrapping_add(sum(is_counted.then(|| number([slot, id.slot()])).into_iter()));
            ControlFlow::Continue(())
        });
    }
    check(all == kept, "pairs are missing, or there twice", 0)
}
