//! From overlaps of swept boxes to the result: the exact test, and which pairs are new or gone.
//!
//! A pair is new exactly if its boxes did not overlap when the last complete step reported them, and gone exactly if
//! it stood in that step's result and does not overlap now. That needs no search: the boxes from then are kept, and an
//! object that is new or gone has the empty box. A reused slot follows by itself, since the empty box is between
//! the two objects.

use crate::access::{Access, bits};
use crate::config::Mode;
use crate::filter::FILTERS;
use crate::id::{Index, Pair};
use crate::memory::slab::{BoxParts, Parts};
use crate::pairs::events;
use crate::pairs::partition::{Among, Apart, ClearOf, Dropped, Ended, Overlap, Touch, partition};
use crate::parallel::context::StepContext;
use crate::sort::heapsort;

/// Orders the first `swept` pairs of the buffer, but for those parked: persisting, found, surplus; and finds the lost
/// ones, unless the sweep has `found` them. Events only where the pairs are complete: a part does not tell what is lost.
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
        // What overlapped then and does not now; where slots may have new objects, they did not overlap then.
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

/// Brings the boxes of the last complete step up to date, of those who have not changed since: the others have kept theirs.
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

/// Which pairs stay whose boxes overlapped before and do now. Where a filter may answer differently than before, only the
/// pairs of then can tell: the range of those that they tell stay, in order, behind all the others that stay.
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
