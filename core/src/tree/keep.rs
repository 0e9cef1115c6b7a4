//! Keeps the leaves as they are where few objects leave theirs: the pass that takes in the boxes has brought
//! the other objects' to their records, and the leavers are moved.
//!
//! Cells, frames and axes stay too, from the step that filled all leaves last. No frame loses a pair, but
//! where objects have left the frame for its rim more candidates tie, and then all leaves are filled anew.

use super::enclose::{enclose, list_straddlers, number_straddlers};
use super::relocate::relocate_all;
use super::{are_few, large};
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::parallel::context::StepContext;

/// One in so many objects may leave its leaf in a step in which all others keep their places.
pub(crate) const LEAVERS_SHARE: u32 = 8;

/// Steps in a row that keep the leaves: then all are filled anew, so that frames, the order of records and
/// the statistics of boxes are of late.
const MOST_KEPT: u8 = 32;

/// Whether the next boxes are to be brought to their records as they are taken in.
pub(crate) fn settles<I: Index>(parts: &Parts<'_, I>) -> bool {
    let state = &parts.state;
    let known = state.tree.filled != 0 && state.tree.subdivided == 0 && state.pairs.complete != 0;
    known && state.step.kept != 0 && parts.moved.count() <= state.objects.live / LEAVERS_SHARE
}

/// Moves the records of objects that have left their leaf, or were changed by themselves. Returns whether all
/// leaves are filled then; else they must be filled anew.
pub(crate) fn settle<I: Index>(parts: &mut Parts<'_, I>, left: u32, context: StepContext<'_>) -> bool {
    let (live, leaves) = (parts.state.objects.live, parts.state.tree.count);
    if left > live / LEAVERS_SHARE || !relocate_all(parts, left as usize, context) {
        return false;
    }
    let large = parts.state.tree.large;
    let straddlers = number_straddlers(parts, context);
    let fits = large::fits(u64::from(straddlers), u64::from(large), parts.tree.straddlers.len());
    if !fits || !are_few(u64::from(large), leaves, live) {
        return false;
    }
    large::seat(parts, straddlers, large);
    large::arrange(parts, true);
    list_straddlers(parts, context);
    enclose(parts);
    true
}

/// Candidates that may tie beyond the step before: one in so many of its, and one in so many objects.
const MORE_TIES: u64 = 8;
const MORE_TIES_SHARE: u64 = 64;

/// Notes a full step in which so many candidates tied, and which has kept the leaves, or has filled them
/// after so many objects had left theirs: does the next one keep them?
pub(crate) fn plan(state: &mut State, ties: u64, refilled: Option<u32>) {
    let (is_calm, kept) = match refilled {
        Some(left) => (left <= state.objects.live / LEAVERS_SHARE && state.tree.uneven == 0, 0),
        None => {
            let before = state.stats().tied;
            let most = before + before / MORE_TIES + u64::from(state.objects.live) / MORE_TIES_SHARE;
            (ties <= most && state.tree.heavy == 0 && state.tree.uneven == 0, state.step.kept)
        }
    };
    state.step.kept = if is_calm && kept < MOST_KEPT { kept + 1 } else { 0 };
}
