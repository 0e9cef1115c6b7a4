//! Keeps the leaves as they are where few objects leave theirs: the pass that takes in the boxes has brought
//! the other objects' to their records, and the leavers are moved.
//!
//! Cells, frames and axes stay too, as the step that filled all leaves last has left them. No frame loses a
//! pair.

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

/// Whether the next full step keeps the leaves, after one that has, or has filled them as many left theirs.
pub(crate) fn plan(state: &mut State, refilled: Option<u32>) {
    let kept = if refilled.is_some() { 0 } else { state.step.kept };
    let is_calm = refilled.map_or(state.tree.heavy == 0, |left| left <= state.objects.live / LEAVERS_SHARE);
    state.step.kept = if is_calm && state.tree.uneven == 0 && kept < MOST_KEPT { kept + 1 } else { 0 };
}
