//! Checks pairs: those of the last step, parked ones, and those that events compare with.

use super::content::{Content, Set};
use super::{Invalid, check};
use crate::config::Mode;
use crate::filter::meet;
use crate::id::{Index, Pair};
use crate::memory::state::State;

/// Checks each pair by itself. It has two slots in order. If it is parked, neither object is active. If nothing has
/// changed since, the boxes overlap and the filters let it through. O(pairs).
pub(crate) fn pairs<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    let state = content.state();
    let slots = state.objects.slots as usize;
    let touches = |set, pair: &Pair<I>| content.is_in(set, pair[0].at()) || content.is_in(set, pair[1].at());
    for at in 0..state.pairs.swept as usize {
        let pair = content.pair(at);
        check(pair[0] < pair[1] && pair[1].at() < slots, "a pair is not of two slots in order", at)?;
        let is_parked = at < state.pairs.parked as usize;
        check(!is_parked || !touches(Set::Active, &pair), "a pair of an active object is parked", at)?;
        if !touches(Set::Moved, &pair) {
            unmoved(content, &pair, at, touches(Set::Changed, &pair))?;
        }
    }
    for at in 0..previous(state) as usize {
        let pair = content.previous(at);
        check(pair[0] < pair[1] && pair[1].at() < slots, "a pair of the last step is not of two slots", at)?;
    }
    segments(content)
}

/// Checks a pair of two objects that have not moved. One may have changed inside its margin.
fn unmoved<I: Index>(
    content: &impl Content<I>,
    pair: &Pair<I>,
    at: usize,
    changed: bool,
) -> Result<(), Invalid> {
    let state = content.state();
    let [a, b] = pair.map(Index::at);
    check(content.swept(a).overlaps(&content.swept(b)), "a pair does not overlap", at)?;
    let keeps_changed = content.word(Set::Changed, 0).is_some();
    // Without a move inside a margin the next step divides no pairs, whatever is marked as changed.
    let unchanged = state.objects.moved_inside_margin == 0 || keeps_changed && !changed;
    if content.sizes().fat > 0 && state.setup.mode() == Mode::Exact && unchanged {
        check(
            content.now(a).overlaps(&content.now(b)) == state.pairs.result().contains(&at),
            "a pair overlaps and is surplus, or does not and is reported",
            at,
        )?;
    }
    let lets_through = || meet(&content.filter(a), &content.filter(b), |class| content.class(class));
    check(content.sizes().filters == 0 || lets_through(), "a pair that the filters do not let through", at)
}

/// Checks that segments divide the last result: each ends where the next one starts, and the last one at its end.
fn segments<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    let (state, segments, mut end) = (content.state(), content.segments(), 0);
    check(segments <= 2 * content.sizes().event_blocks, "segments of leaves that there are not", segments)?;
    for at in 0..segments {
        let next = content.segment(at);
        check(end <= next, "a segment of the last result ends before it starts", at)?;
        end = next;
    }
    let last = if state.pairs.complete != 0 { state.pairs.reported } else { state.pairs.previous };
    check(
        segments == 0 || u64::from(end) == last,
        "the segments are not those of the last result",
        end as usize,
    )
}

/// How many pairs of the step before mean something: those that are lost; if the last step had no room for its pairs,
/// all.
pub(crate) fn previous(state: &State) -> u64 {
    if state.pairs.complete != 0 { state.pairs.lost } else { state.pairs.previous }
}
