//! The numbers of the state: each within what the arrays have room for, and together.

use super::{Invalid, check};
use crate::config::Mode;
use crate::memory::layout::Sizes;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::state::State;
use crate::tree::balance::depth_for;

/// Checks all numbers of a state. What an index is computed from comes first.
pub(crate) fn numbers(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    objects(state, sizes)?;
    tree(state, sizes)?;
    pairs(state, sizes)
}

fn objects(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let slots = state.slots;
    check(slots as usize <= sizes.objects, "more slots than there is room for", slots as usize)?;
    check(state.live <= slots, "more objects than slots", state.live as usize)?;
    check(state.free <= slots, "a free slot that there is not", state.free as usize)?;
    check(state.stale_lists != 0 || state.listed <= slots, "the lists are too long", state.listed as usize)?;
    check(state.list_axis < 3 && state.stripe_axis < 3, "an axis that there is not", 0)?;
    // Else they are chosen before they are used.
    let chosen = sizes.is_small() && state.scan_in > 0;
    check(!chosen || state.list_axis != state.stripe_axis, "strips along the axis of the sweep", 0)?;
    let yes_or_no = [
        state.stale_lists,
        state.filled,
        state.dirty,
        state.resting,
        state.has_inserted,
        state.moved_inside_margin,
        state.complete,
        state.without_surplus,
        state.unproven,
        state.poor,
        state.divisible,
    ];
    for (at, number) in yes_or_no.into_iter().enumerate() {
        check(number <= 1, "a number that is neither yes nor no", at)?;
    }
    check(state.moved_inside_margin == 0 || sizes.fat > 0, "movement in margins that there are not", 0)?;
    check(state.has_known_statistics(), "a path that there is not", 0)
}

fn tree(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let full = sizes.depth.saturating_sub(SUB_LEVELS);
    check(state.built as usize <= sizes.tree, "planes for too many objects", state.built as usize)?;
    // The planes below are not made.
    let deepest = if state.built > 0 { depth_for(state.built as usize, sizes.depth) } else { full };
    check(state.depth <= deepest.min(full), "a tree without planes", state.depth as usize)?;
    check(
        state.subdivided == 0 || sizes.tree > 0 && u64::from(state.subdivided) <= (1 << state.depth) + 1,
        "more leaves are divided than there are",
        state.subdivided as usize,
    )?;
    check(state.filled == 0 || state.built > 0, "filled leaves without planes", 0)?;
    // So that no sum of squares is too much.
    check(state.baseline <= u64::from(state.built).pow(2), "planes that were never so uneven", 0)?;
    check(
        u64::from(state.large_start) + u64::from(state.large) <= sizes.straddlers as u64,
        "more large objects than there is room for",
        state.large as usize,
    )
}

fn pairs(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let (parked, surplus_parked) = (u64::from(state.parked), u64::from(state.surplus_parked));
    let end = surplus_parked.saturating_add(state.result_pairs);
    let swept = state.swept_pairs;
    check(swept <= sizes.pairs as u64, "more pairs than room", swept as usize)?;
    check(end <= swept, "more pairs are exact, or surplus and set aside, than swept", swept as usize)?;
    check(
        surplus_parked <= parked && parked <= end,
        "more pairs are set aside than there are, or fewer than their surplus",
        state.parked as usize,
    )?;
    check(parked == 0 || sizes.tree > 0, "pairs are set aside without a tree", state.parked as usize)?;
    let has_surplus = state.mode() == Mode::Exact && sizes.fat > 0;
    check(has_surplus || surplus_parked == 0 && end == swept, "surplus without margins", swept as usize)?;
    check(state.found <= end - parked, "more pairs are found than there are", state.found as usize)?;
    let events = sizes.previous > 0;
    check(events || state.found == 0, "pairs are found without events", state.found as usize)?;
    let blocks = state.segments as usize;
    check(blocks <= sizes.event_blocks, "the last result is divided by leaves that there are not", blocks)?;
    check(events && state.swapped == 1 || state.swapped == 0, "buffers that have not changed places", 0)?;
    let previous = state.previous_result;
    check(state.lost <= previous, "more pairs are lost than there were", state.lost as usize)?;
    // A step that finds all pairs anew adds those that are parked.
    let more = if state.complete != 0 || !events { 0 } else { parked - surplus_parked };
    check(
        previous <= sizes.previous as u64 && previous + more <= sizes.previous as u64,
        "more pairs of the last step than room",
        previous as usize,
    )
}
