//! Pairs: those of the last step, those that steps need not look at, those that are compared for the events.

use super::content::{Content, Set};
use super::{Invalid, check};
use crate::config::Mode;
use crate::filter::meet;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::state::State;

/// Checks each pair by itself: it is one of two slots in order; nobody is active if it is parked; and if nothing has changed
/// since, the boxes overlap and the filters agree. O(pairs).
pub(crate) fn pairs<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    let state = content.state();
    let (slots, parked, result) =
        (state.objects.slots as usize, state.pairs.parked as usize, state.pairs.result());
    let (exact, margins) = (state.setup.mode() == Mode::Exact, content.sizes().fat > 0);
    let keeps_changed = content.word(Set::Changed, 0).is_some();
    let touches = |set, pair: &Pair<I>| content.is_in(set, pair[0].at()) || content.is_in(set, pair[1].at());
    let overlap =
        |boxes: &dyn Fn(usize) -> KeyBox, pair: &Pair<I>| boxes(pair[0].at()).overlaps(&boxes(pair[1].at()));
    let filters = content.sizes().filters > 0;
    for at in 0..state.pairs.swept as usize {
        let pair = content.pair(at);
        check(pair[0] < pair[1] && pair[1].at() < slots, "a pair is not of two slots in order", at)?;
        let is_aside = at < parked;
        check(
            !is_aside || !touches(Set::Awake, &pair),
            "a pair of an object that is awake is set aside",
            at,
        )?;
        if touches(Set::Moved, &pair) {
            continue;
        }
        if margins {
            check(overlap(&|slot| content.fat(slot), &pair), "a pair does not overlap", at)?;
            let unchanged = if keeps_changed {
                !touches(Set::Changed, &pair)
            } else {
                state.objects.moved_inside_margin == 0
            };
            if exact && unchanged {
                check(
                    overlap(&|slot| content.now(slot), &pair) == result.contains(&at),
                    "a pair overlaps and is surplus, or does not and is reported",
                    at,
                )?;
            }
        } else {
            check(overlap(&|slot| content.now(slot), &pair), "a pair does not overlap", at)?;
        }
        if filters {
            let [a, b] = pair.map(|slot| content.filter(slot.at()));
            check(
                meet(&a, &b, |class| content.class(class)),
                "a pair that the filters do not let through",
                at,
            )?;
        }
    }
    let previous = previous(state) as usize;
    for at in 0..previous {
        let pair = content.previous(at);
        check(pair[0] < pair[1] && pair[1].at() < slots, "a pair of the last step is not of two slots", at)?;
    }
    Ok(())
}

/// How many pairs of the step before mean something: those that are lost; after a step without room for its pairs, all.
pub(crate) fn previous(state: &State) -> u64 {
    if state.pairs.complete != 0 { state.pairs.lost } else { state.pairs.previous }
}
