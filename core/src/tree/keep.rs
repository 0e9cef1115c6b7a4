//! Keeps the leaves as they are where few objects leave theirs: the pass that takes in the boxes has brought the others to their
//! records, and those that left are moved one by one.
//!
//! Cells, frames and axes stay too: they are those of the step that filled all leaves last. Any frame loses no pair, but where
//! objects have come to its rim more candidates tie, and then leaves are filled anew.

use super::are_few;
use super::enclose::{enclose, list_straddlers, number_straddlers};
use super::relocate::Relocate;
use crate::access::Access;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::parallel::context::StepContext;

/// One in so many objects may leave its leaf in a step for the others to keep their places.
const LEAVERS_SHARE: u32 = 8;

/// How many times as many candidates may tie as when all leaves were filled last, and one in so many objects besides.
const TIES: u64 = 2;
const TIES_SHARE: u64 = 16;

/// Steps in a row that keep the leaves: then all are filled anew, so that frames, the order of records and the statistics of boxes
/// are of late.
const MOST_KEPT: u16 = 32;

/// Whether the next boxes are to be brought to their records as they are taken in.
pub(crate) fn settles<I: Index>(parts: &Parts<'_, I>) -> bool {
    let state = &parts.state;
    let known = state.tree.filled != 0
        && state.tree.subdivided == 0
        && state.pairs.complete != 0
        && state.pairs.unproven == 0;
    known && state.tree.settles != 0 && parts.moved.count() <= state.objects.live / LEAVERS_SHARE
}

/// Moves the records of those that have left their leaf, or were changed one by one. Returns whether all leaves are filled then;
/// else they must be filled anew.
pub(crate) fn settle<I: Index>(parts: &mut Parts<'_, I>, left: u32, context: StepContext<'_>) -> bool {
    let (live, depth) = (parts.state.objects.live, parts.state.tree.depth);
    if left > live / LEAVERS_SHARE || !context.kernels.run(Relocate(parts, left as usize)) {
        return false;
    }
    parts.state.tree.strays = parts.state.tree.strays.saturating_add(left);
    let large = parts.state.tree.large;
    let straddlers = number_straddlers(parts, context.executor);
    let fits = u64::from(straddlers) + u64::from(large) <= parts.tree.straddlers.len() as u64;
    if !fits || !are_few(u64::from(large), depth, live) {
        return false;
    }
    // Behind the straddlers, of which there may be more or fewer now.
    let (from, to) = (parts.state.tree.large_start as usize, straddlers as usize);
    for index in 0..large as usize {
        // From the end that is not written to yet.
        let index = if to > from { large as usize - 1 - index } else { index };
        let object = parts.tree.straddlers.at(from + index);
        parts.tree.straddlers.put(to + index, object);
    }
    parts.state.tree.large_start = straddlers;
    list_straddlers(parts, context.kernels, context.executor);
    enclose(parts, depth, context.executor);
    true
}

/// Notes how a full step went, whether it kept the leaves or filled them anew: does the next one keep them?
pub(crate) fn weigh(state: &mut State, ties: u64, has_kept: bool) {
    let calm = if has_kept {
        state.tree.kept = state.tree.kept.saturating_add(1);
        state.tree.kept < MOST_KEPT
            && ties <= TIES * state.tree.baseline_ties + u64::from(state.objects.live) / TIES_SHARE
    } else {
        state.tree.baseline_ties = ties;
        let few = state.tree.strays <= state.objects.live / LEAVERS_SHARE;
        (state.tree.strays, state.tree.kept) = (0, 0);
        few
    };
    state.tree.settles = u16::from(calm);
}
