//! Keeps pairs from one step to the next. Pairs of two resting objects are parked, so that a step with few
//! movers does not touch them (paper, section III.B.1; erratum E6).
//!
//! Parked pairs of the result are at the front of the pair buffer, parked surplus is at its end. Neither object
//! of such a pair is *active*. While only active objects get other boxes, parked pairs stay, and a step deals
//! with the others alone. When another object gets another box, it becomes active, and its parked pairs are
//! unparked. When far fewer objects get other boxes than are active, the others become inactive again.
//!
//! With margins, an object that moves inside its fat box is active too, since its exact pairs change. So no
//! object of a parked surplus pair is active either.

use crate::access::Access;
use crate::config::{EVENTS, TREE};
use crate::id::{Index, Pair};
use crate::memory::slab::Parts;
use crate::memory::state::PairState;
use crate::pairs::partition::Test::{ClearOf, Holds};
use crate::pairs::partition::{is_clear_of, partition};
use crate::parallel::context::StepContext;

/// This many times as many objects may be active as have another box, before the others become inactive.
const ACTIVE_FOR_EACH: u32 = 8;

/// For a step that tests only moved objects: brings the pairs of two resting ones to the front of the buffer,
/// pairs of the result first; returns how many stand there, without the parked surplus. With events, all other
/// pairs are set aside to be compared.
pub(crate) fn persistent<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u64 {
    park(parts, context);
    let Parts { state, moved, output, .. } = parts;
    let (front, result) = (state.pairs.in_front(), state.pairs.reported as usize);
    let (mut kept, mut kept_result, mut gone) = (front, result, 0);
    if moved.count() > 0 {
        let (parked, clear) = (state.pairs.parked as usize, ClearOf(moved.words));
        kept_result = parked + partition(context, output.pairs.span_mut(parked, result - parked), clear);
        gone = result - kept_result;
        output.previous.copy_in(output.pairs.span(kept_result, gone));
        let surplus = partition(context, output.pairs.span_mut(result, front - result), clear);
        exchange(output.pairs.span_mut(kept_result, gone + surplus), gone);
        kept = kept_result + surplus;
    }
    // From now on these are the last complete result.
    state.pairs.complete = 0;
    state.pairs.previous = gone.min(output.previous.len()) as u64;
    (state.pairs.kept, state.pairs.kept_result) = (kept as u32, kept_result as u32);
    kept as u64
}

/// Brings the pairs from position `from` on to the front. The order inside both parts may change.
pub(super) fn exchange<I: Index>(pairs: &mut [Pair<I>], from: usize) {
    let count = pairs.len();
    for at in 0..from.min(count - from) {
        pairs.swap_at(at, count - 1 - at);
    }
}

/// With events: sets aside the kept pairs of the result from a position on, too.
pub(crate) fn set_aside<I: Index>(parts: &mut Parts<'_, I>, from: usize) {
    let PairState { kept_result, previous, .. } = &mut parts.state.pairs;
    let pairs = parts.output.pairs.get(from..*kept_result as usize).unwrap_or_default();
    if let Some(to) = parts.output.previous.get_mut(*previous as usize..) {
        to.copy_in(pairs);
        *previous += pairs.len().min(to.len()) as u64;
    }
    *kept_result = (from as u32).min(*kept_result);
}

/// For a step that finds all pairs anew. With events, the last complete result is kept to be compared: the
/// two buffers change places.
pub(crate) fn start_over<I: Index>(parts: &mut Parts<'_, I>) {
    if EVENTS && TREE && parts.state.pairs.complete == 0 {
        // A step that did not end has set the others aside.
        set_aside(parts, 0);
    }
    let Parts { state, output, .. } = parts;
    if EVENTS && parts.sizes.previous > 0 && state.pairs.complete != 0 {
        core::mem::swap(&mut output.pairs, &mut output.previous);
        state.pairs.swapped ^= 1;
        state.pairs.previous = state.pairs.reported;
    }
    state.pairs.complete = 0;
    (state.pairs.parked, state.pairs.surplus_parked) = (0, 0);
    (state.pairs.kept, state.pairs.kept_result) = (0, 0);
    state.pairs.active = u32::MAX;
}

/// Updates the active objects, and if these are others the parked pairs. O(stirring objects), or O(pairs).
fn park<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let Parts { state, moved, changed, active, output, .. } = parts;
    // Includes boxes that have changed inside their fat boxes: they may overlap others now that they did not
    // before, or no longer.
    let stirring = if changed.words.is_empty() { moved } else { changed };
    let (mut words, mut paired) = (0, 0);
    stirring.for_each_word(|index, word| {
        words += u32::from(word != 0);
        let new = word & !active.at(index);
        active.put(index, active.at(index) | word);
        state.pairs.active = state.pairs.active.saturating_add(new.count_ones());
        // Objects in slots that were never used before have no pairs.
        let known = (1u64 << (state.tree.known as usize).saturating_sub(32 * index).min(32)) - 1;
        paired |= u64::from(new) & known;
    });
    // Each word has at least one object, which is mostly enough to decide.
    let too_many = |count: u32| state.pairs.active > ACTIVE_FOR_EACH.saturating_mul(count);
    let too_many = too_many(words) && too_many(stirring.count());
    if too_many {
        active.copy_in(stirring.words);
        state.pairs.active = stirring.count();
    } else if paired == 0 {
        return;
    }
    let pairs = &mut *output.pairs;
    let (result, swept, front) =
        (state.pairs.reported as usize, state.pairs.swept as usize, state.pairs.in_front());
    state.pairs.parked = partition(context, pairs.span_mut(0, result), ClearOf(active)) as u32;
    // All surplus comes together, then what is parked of it goes to the end.
    let free = pairs.len() - swept;
    exchange(pairs.span_mut(front, swept + free - front), free);
    let stirs = |pair: &Pair<I>| !is_clear_of(active, pair);
    let others = result + partition(context, pairs.span_mut(result, swept - result), Holds(&stirs));
    exchange(pairs.span_mut(others, swept + free - others), swept - others);
    state.pairs.surplus_parked = (swept - others) as u32;
}
