//! Turns overlaps of swept boxes into the result: the exact test, found and lost pairs, their order.
//!
//! A pair is found exactly if its boxes did not overlap at the last complete step. It is lost exactly if that
//! step's result had it and its boxes do not overlap now. That needs no search: the boxes of that step are
//! kept, and an object that is new or gone has the empty box. So a reused slot needs no rule of its own. Where
//! few pairs are new, that step's result tells it instead, and a world without a tree keeps a bit for each two
//! slots: see [`met`].

use crate::access::{Access, bits};
use crate::config::{EVENTS, FILTERS, TREE};
use crate::id::{Index, Pair};
use crate::memory::slab::{BoxParts, Parts};
use crate::memory::state::PairState;
use crate::pairs::met;
use crate::pairs::partition::Test::{ClearOf, Ended, Holds, Overlap};
use crate::pairs::partition::{is_clear_of, partition};
use crate::pairs::persistent::{exchange, set_aside};
use crate::parallel::context::StepContext;
use crate::sort::heapsort;

/// Orders the pairs of the buffer, of which there are so many if they fit, parked ones aside: persisting, found,
/// surplus. Finds the lost ones. Kept pairs are looked at only if a box has moved inside its fat box: where such
/// a pair stands tells whether it overlapped before. Events need complete pairs: a part does not tell what is
/// lost.
pub(crate) fn sort_out<I: Index>(parts: &mut Parts<'_, I>, pairs: u64, context: StepContext<'_>) {
    let (room, complete) = (parts.output.pairs.len(), pairs <= parts.output.pairs.len() as u64);
    let swept = (pairs as usize).min(room);
    parts.state.pairs.swept = swept as u64;
    if parts.sizes.is_small() {
        return sort_out_small(parts, swept, complete);
    }
    let events = EVENTS && parts.sizes.previous > 0;
    let PairState { parked, kept, kept_result, before_unknown, .. } = parts.state.pairs;
    let (parked, kept, kept_result) = (parked as usize, kept as usize, kept_result as usize);
    let front = parts.state.pairs.in_front();
    let (mut staying, mut coming, by_pairs) = (kept_result, 0, before_unknown != 0);
    if parts.any_stays() {
        let now = &*parts.boxes.now;
        let pairs = &mut *parts.output.pairs;
        staying = parked + partition(context, pairs.span_mut(parked, kept_result - parked), Overlap(now));
        coming = partition(context, pairs.span_mut(kept_result, kept - kept_result), Overlap(now));
    }
    // What was set aside of pairs that were not kept; of others, those that are no more come behind.
    let mut asked = parts.state.pairs.previous as usize;
    if events {
        // If a step has no room for all its pairs, the next one needs all of the last complete result.
        set_aside(parts, if complete { staying } else { 0 });
    }
    let pairs = parts.output.pairs.span_mut(parked, front - parked);
    let new = pairs.span_mut(kept - parked, front - kept);
    let BoxParts { now, before, .. } = &parts.boxes;
    // Overlaps of fat boxes alone are surplus.
    let result = if parts.boxes.are_fat() { partition(context, new, Overlap(now)) } else { new.len() };
    let mut persisting = result;
    (parts.state.pairs.found, parts.state.pairs.lost) = (0, 0);
    if events && complete {
        let previous = parts.output.previous.span_mut(0, parts.state.pairs.previous as usize);
        let new = new.span_mut(0, result);
        let test = if by_pairs { ClearOf(parts.former.reused.words) } else { Overlap(before) };
        persisting = partition(context, new, test);
        // If slots may have new objects, the pair may not have overlapped before.
        let before: &[_] = if parts.state.objects.has_inserted != 0 { before } else { &[] };
        let mut lost = if by_pairs { 0 } else { partition(context, previous, Ended { now, before }) };
        let previous = previous.span_mut(lost, previous.len() - lost);
        if by_pairs || FILTERS && parts.filters.changed.count() > 0 {
            // Or if the filters no longer let it through.
            let filters = &*parts.filters.changed.words;
            let is_asked = |pair: &Pair<I>| by_pairs || !is_clear_of(filters, pair);
            asked = if by_pairs { asked } else { previous.len() };
            let known = previous.span_mut(0, asked);
            let (stay, dropped) = tell_by_pairs(context, new.span_mut(0, persisting), known, &is_asked);
            let gone = previous.len() - asked + dropped;
            exchange(previous.span_mut(dropped, previous.len() - dropped), asked - dropped);
            (persisting, lost) = (stay, lost + gone);
        }
        parts.state.pairs.lost = lost as u64;
        parts.state.pairs.found = (coming + result - persisting) as u64;
    }
    parts.state.pairs.reported = (staying + coming + result) as u64;
    if kept == parked {
        return;
    }
    // Staying, gone, coming and other kept pairs; persisting, found and other new ones. Now: staying,
    // persisting, coming, found, all others.
    let pairs = pairs.span_mut(staying - parked, kept + result - staying);
    let (gone, others) = (kept_result - staying, kept - staying - coming);
    exchange(pairs.span_mut(0, gone + coming), gone);
    exchange(pairs.span_mut(coming, others + persisting), others);
    exchange(pairs.span_mut(0, coming + persisting), coming);
    exchange(pairs.span_mut(coming + persisting, others + result - persisting), others);
}

/// The same for a world without a tree, which keeps no pairs and has no surplus.
fn sort_out_small<I: Index>(parts: &mut Parts<'_, I>, swept: usize, complete: bool) {
    let Parts { state, output, met, former, .. } = parts;
    let (mut persisting, mut lost) = (swept, 0);
    if EVENTS && !met.is_empty() && complete {
        let last = output.previous.span_mut(0, state.pairs.previous as usize);
        let result = output.pairs.span_mut(0, swept);
        let reused = if state.objects.has_inserted != 0 { &*former.reused.words } else { &[] };
        (persisting, lost) = if !TREE && met.len() <= 32 {
            met::compare::<I, true>(met, result, last, reused)
        } else {
            met::compare::<I, false>(met, result, last, reused)
        };
    }
    let found = swept - persisting;
    (state.pairs.reported, state.pairs.found, state.pairs.lost) = (swept as u64, found as u64, lost as u64);
}

/// Before pairs are looked for: forgets who came in the step before, and brings `before` up to date for
/// objects that have not changed since the last complete step. Changed objects have kept their boxes.
pub(crate) fn remember<I: Index>(parts: &mut Parts<'_, I>) {
    if parts.state.objects.has_inserted == 0 {
        // These slots are of the step before.
        parts.former.reused.clear();
    }
    if !(EVENTS && TREE) {
        return;
    }
    let BoxParts { now, before, .. } = &mut parts.boxes;
    let changed = &*parts.changed.words;
    parts.outdated.for_each_word(|word, outdated| {
        for bit in bits::of_word(outdated & !changed.at(word)) {
            before.put(word * 32 + bit, now.at(word * 32 + bit));
        }
    });
    parts.outdated.clear();
}

/// Which pairs stay, by the previous result alone: where a filter may answer differently, or nobody keeps the
/// boxes of before. Brings these to the front, and those of before that are gone. Returns how many both are.
fn tell_by_pairs<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    previous: &mut [Pair<I>],
    is_asked: &(dyn Fn(&Pair<I>) -> bool + Sync),
) -> (usize, usize) {
    let others = partition(context, pairs, Holds(&|pair| !is_asked(pair)));
    let open = pairs.span_mut(others, pairs.len() - others);
    sort(open);
    let gone = |pair: &Pair<I>| is_asked(pair) && !has(open, pair);
    let gone = partition(context, previous, Holds(&gone));
    let rest = previous.span_mut(gone, previous.len() - gone);
    let known = partition(context, rest, Holds(is_asked));
    let known = rest.span_mut(0, known);
    sort(known);
    let stay = partition(context, open, Holds(&|pair| has(known, pair)));
    (others + stay, gone)
}

/// The order of pairs by their slots, as one number: two comparisons would be two branches.
fn rank<I: Index>(pair: &Pair<I>) -> u64 {
    u64::from(pair[0].slot()) << 32 | u64::from(pair[1].slot())
}

fn sort<I: Index>(pairs: &mut [Pair<I>]) {
    heapsort(pairs, |a, b| rank(&a) < rank(&b));
}

fn has<I: Index>(sorted: &[Pair<I>], pair: &Pair<I>) -> bool {
    sorted.binary_search_by_key(&rank(pair), rank).is_ok()
}

/// Sorts persisting, found and lost pairs, each by their slots. After a step without room for all pairs
/// nothing is done: which pairs fitted has no rule.
pub(crate) fn sort_results<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, output, .. } = parts;
    if state.pairs.complete == 0 {
        return;
    }
    let found = state.pairs.found as usize;
    let persisting = state.pairs.reported as usize - found;
    // None of them is parked any more.
    (state.pairs.parked, state.pairs.active) = (0, u32::MAX);
    sort(output.pairs.span_mut(0, persisting));
    sort(output.pairs.span_mut(persisting, found));
    sort(output.previous.span_mut(0, state.pairs.lost as usize));
}
