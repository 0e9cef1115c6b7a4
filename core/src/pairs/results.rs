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
use crate::pairs::events;
use crate::pairs::partition::{Among, Apart, ClearOf, Dropped, Ended, Overlap, Touch, partition};
use crate::parallel::context::StepContext;
use crate::sort::heapsort;

/// Orders the first `swept` pairs of the buffer, parked ones aside: persisting, found, surplus. Finds the lost ones,
/// unless the sweep has `found` the events. Events need complete pairs: a part does not tell what is lost.
pub(crate) fn sort_out<I: Index>(
    parts: &mut Parts<'_, I>,
    swept: usize,
    complete: bool,
    found: Option<u64>,
    context: StepContext<'_>,
) {
    parts.state.pairs.swept = swept as u64;
    if cfg!(feature = "large")
        && complete
        && let Some(found) = found
    {
        parts.state.pairs.reported = swept as u64;
        parts.state.pairs.found = found;
        parts.state.pairs.lost = events::conclude(parts) as u64;
        return;
    }
    let events = parts.sizes.previous > 0 && complete;
    if events {
        parts.output.segments.forget();
    }
    let has_surplus = parts.has_surplus();
    let mode = parts.state.setup.mode();
    let (now, before) = (parts.boxes.reported(mode), &*parts.boxes.before);
    let parked = parts.state.pairs.parked as usize;
    let pairs = parts.output.pairs.span_mut(parked, swept - parked);
    let result = if has_surplus { partition(context, pairs, Overlap(now)) } else { pairs.len() };
    let mut persisting = result;
    parts.state.pairs.lost = 0;
    if events {
        let previous = parts.output.previous.span_mut(0, parts.state.pairs.previous as usize);
        let pairs = pairs.span_mut(0, result);
        persisting = partition(context, pairs, Overlap(before));
        // A pair is lost if it overlapped then and does not now. If slots may have new objects, it may not have
        // overlapped then.
        let asked = &*parts.filters.changed.words;
        let lost = if FILTERS && parts.filters.changed.count() > 0 {
            let staying = staying(context, pairs.span_mut(0, persisting), previous, asked);
            persisting = staying.end;
            let staying = pairs.span(staying.start, staying.len());
            partition(context, previous, Dropped { now, before, asked, staying })
        } else if parts.state.objects.has_inserted != 0 {
            partition(context, previous, Ended { now, before })
        } else {
            partition(context, previous, Apart(now))
        };
        parts.state.pairs.lost = lost as u64;
    }
    parts.state.pairs.reported = (parked + result) as u64 - u64::from(parts.state.pairs.surplus_parked);
    parts.state.pairs.found = (result - persisting) as u64;
}

/// Brings `before` up to date for objects that have not changed since the last complete step. The others have kept
/// their boxes.
pub(crate) fn remember<I: Index>(parts: &mut Parts<'_, I>) {
    let mode = parts.state.setup.mode();
    let BoxParts { now, fat, before, .. } = &mut parts.boxes;
    let boxes = if mode == Mode::Fat && !fat.is_empty() { &**fat } else { &**now };
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
fn staying<I: Index>(
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
