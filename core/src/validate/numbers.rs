//! Checks the numbers of the state: each is within its array, and they agree.

use crate::config::Mode;
use crate::memory::layout::Sizes;
use crate::memory::state::State;
use crate::snapshot::check::{Invalid, check};
use crate::tree::large;

/// Checks all numbers of a state before any of them is used in an index, but for those that a snapshot has, too.
pub(crate) fn numbers(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    objects(state, sizes)?;
    tree(state, sizes)?;
    pairs(state, sizes)
}

fn objects(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let slots = state.objects.slots;
    check(slots as usize <= sizes.objects, "more slots than there is room for", slots as usize)?;
    check(
        state.lists.stale != 0 || state.lists.listed <= slots,
        "the lists are too long",
        state.lists.listed as usize,
    )?;
    check(state.lists.axis < 3 && state.lists.second_axis < 3, "an axis that there is not", 0)?;
    let flags = [state.lists.stale, state.tree.uneven, state.pairs.unkept, state.pairs.swapped];
    for (at, flag) in flags.into_iter().enumerate() {
        check(flag <= 1, "a number that is neither yes nor no", at)?;
    }
    check(state.tree.filled <= 2, "leaves that are filled in no known way", state.tree.filled.into())?;
    check(state.step.margins_in == 0 || sizes.fat > 0, "fat boxes that are not used where there are none", 0)
}

fn tree(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    check(
        state.tree.count as usize <= sizes.whole_leaves,
        "more leaves than room",
        state.tree.count as usize,
    )?;
    check(state.tree.coarser < 32, "leaves of no size", state.tree.coarser as usize)?;
    check(
        state.tree.subdivided == 0 || sizes.tree > 0 && state.tree.subdivided <= state.tree.count + 1,
        "more leaves are divided than there are",
        state.tree.subdivided as usize,
    )?;
    check(state.tree.filled == 0 || state.tree.count > 0, "filled leaves without planes", 0)?;
    check(
        large::has_room(&state.tree, state.tree.large as usize, sizes.straddlers),
        "more large objects than there is room for",
        state.tree.large as usize,
    )
}

fn pairs(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let (parked, surplus_parked) = (u64::from(state.pairs.parked), u64::from(state.pairs.surplus_parked));
    let end = surplus_parked.saturating_add(state.pairs.reported);
    let swept = state.pairs.swept;
    check(swept <= sizes.pairs as u64, "more pairs than room", swept as usize)?;
    check(end <= swept, "more pairs are exact, or surplus and parked, than swept", swept as usize)?;
    check(
        surplus_parked <= parked && parked <= end,
        "more pairs are parked than there are, or fewer than their surplus",
        state.pairs.parked as usize,
    )?;
    check(parked == 0 || sizes.tree > 0, "pairs are parked without a tree", state.pairs.parked as usize)?;
    let has_surplus = sizes.config.mode == Mode::Exact && sizes.fat > 0;
    check(has_surplus || surplus_parked == 0 && end == swept, "surplus without margins", swept as usize)?;
    check(
        state.pairs.found <= end - parked,
        "more pairs are found than there are",
        state.pairs.found as usize,
    )?;
    let events = sizes.previous > 0;
    check(events || state.pairs.swapped == 0, "buffers that have not changed places", 0)?;
    let previous = state.pairs.previous;
    // A step that finds all pairs anew adds the parked ones.
    let more = if state.pairs.complete != 0 || !events { 0 } else { parked - surplus_parked };
    check(
        previous <= sizes.previous as u64 && previous + more <= sizes.previous as u64,
        "more pairs of the last step than room",
        previous as usize,
    )
}
