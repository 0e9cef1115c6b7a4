//! Turns overlaps of swept boxes into the result: the exact test, and which pairs are found and lost.
//!
//! A pair is found exactly if its boxes did not overlap when the last complete step reported them. It is lost exactly
//! if that step's result had it and its boxes do not overlap now. That needs no search: the boxes of that step are
//! kept, and an object that is new or gone has the empty box. So a reused slot needs no rule of its own.

use crate::access::{Access, bits};
use crate::config::Mode;
use crate::filter::FILTERS;
use crate::id::{Index, Pair};
use crate::memory::slab::{BoxParts, Parts};
use crate::memory::state::PairState;
use crate::pairs::partition::Test::{Among, Apart, ClearOf, Dropped, Ended, Overlap, Touch};
use crate::pairs::partition::partition;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::sort::heapsort;

/// Orders the first `swept` pairs of the buffer, parked ones aside: persisting, found, surplus. Finds the lost ones.
/// Kept pairs are looked at only if a box has moved inside its fat box: where such a pair stands tells whether it
/// overlapped before. Events need complete pairs: a part does not tell what is lost.
pub(crate) fn sort_out<I: Index>(
    parts: &mut Parts<'_, I>,
    swept: usize,
    complete: bool,
    context: StepContext<'_>,
) {
    parts.state.pairs.swept = swept as u64;
    let events = parts.sizes.previous > 0;
    let (has_surplus, mode) = (parts.has_surplus(), parts.state.setup.mode());
    let PairState { parked, kept, kept_result, surplus_parked, .. } = parts.state.pairs;
    let (parked, kept, kept_result) = (parked as usize, kept as usize, kept_result as usize);
    let (mut staying, mut coming) = (kept_result, 0);
    if mode == Mode::Exact && parts.state.objects.moved_inside_margin != 0 {
        let now = parts.boxes.reported(mode);
        let pairs = &mut *parts.output.pairs;
        staying = parked + partition(context, pairs.span_mut(parked, kept_result - parked), Overlap(now));
        coming = partition(context, pairs.span_mut(kept_result, kept - kept_result), Overlap(now));
    }
    if events {
        // If a step has no room for all its pairs, the next one needs all of the last complete result.
        persistent::set_aside(parts, if complete { staying } else { parked });
    }
    let (now, before) = (parts.boxes.reported(mode), &*parts.boxes.before);
    let pairs = parts.output.pairs.span_mut(parked, swept - parked);
    let new = pairs.span_mut(kept - parked, swept - kept);
    let result = if has_surplus { partition(context, new, Overlap(now)) } else { new.len() };
    let mut persisting = result;
    parts.state.pairs.lost = 0;
    if events && complete {
        let previous = parts.output.previous.span_mut(0, parts.state.pairs.previous as usize);
        let new = new.span_mut(0, result);
        persisting = partition(context, new, Overlap(before));
        // A pair is lost if it overlapped then and does not now. If slots may have new objects, it may not have
        // overlapped then.
        let asked = &*parts.filters.changed.words;
        let lost = if FILTERS && parts.filters.changed.count() > 0 {
            let known = known(context, new.span_mut(0, persisting), previous, asked);
            persisting = known.end;
            let staying = new.span(known.start, known.len());
            partition(context, previous, Dropped { now, before, asked, staying })
        } else if parts.state.objects.has_inserted != 0 {
            partition(context, previous, Ended { now, before })
        } else {
            partition(context, previous, Apart(now))
        };
        parts.state.pairs.lost = lost as u64;
        parts.state.pairs.found = (coming + result - persisting) as u64;
    } else {
        parts.state.pairs.found = 0;
    }
    // Staying, gone, coming and other kept pairs; persisting, found and other new ones. Now: staying, persisting, coming,
    // found, all others.
    let pairs = pairs.span_mut(staying - parked, kept + result - staying);
    let (gone, others) = (kept_result - staying, kept - staying - coming);
    exchange(pairs.span_mut(0, gone + coming), gone);
    exchange(pairs.span_mut(coming, others + persisting), others);
    exchange(pairs.span_mut(0, coming + persisting), coming);
    exchange(pairs.span_mut(coming + persisting, others + result - persisting), others);
    parts.state.pairs.reported = (staying + coming + result) as u64 - u64::from(surplus_parked);
}

/// Brings the pairs from position `from` on to the front. The order inside both parts may change.
pub(super) fn exchange<I: Index>(pairs: &mut [Pair<I>], from: usize) {
    let count = pairs.len();
    for at in 0..from.min(count - from) {
        pairs.swap_at(at, count - 1 - at);
    }
}

/// Brings `before` up to date for objects that have not changed since the last complete step. The others have kept
/// their boxes.
pub(crate) fn remember<I: Index>(parts: &mut Parts<'_, I>) {
    let mode = parts.state.setup.mode();
    let BoxParts { now, fat, before, tight, .. } = &mut parts.boxes;
    let boxes = if mode == Mode::Fat && !fat.is_empty() && !*tight { &**fat } else { &**now };
    let changed = &*parts.changed.words;
    parts.outdated.for_each_word(|word, outdated| {
        for bit in bits::of_word(outdated & !changed.at(word)) {
            before.put(word * 32 + bit, boxes.at(word * 32 + bit));
        }
    });
    parts.outdated.clear();
}

/// Which pairs stay, of those whose boxes overlapped before and do now. If a filter may answer differently, only the
/// pairs of then can tell. Returns the range of those that they tell, in order, behind all others that stay.
fn known<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    previous: &mut [Pair<I>],
    asked: &[u32],
) -> core::ops::Range<usize> {
    let others = partition(context, pairs, ClearOf(asked));
    let known = partition(context, previous, Touch(asked));
    let known = previous.span_mut(0, known);
    heapsort(known, |a, b| a < b);
    let open = pairs.len() - others;
    let open = pairs.span_mut(others, open);
    let stay = partition(context, open, Among(known));
    heapsort(open.span_mut(0, stay), |a, b| a < b);
    others..others + stay
}
