//! Steps in which many objects have moved: fill all leaves and sweep them, for all pairs, or for pairs of
//! moved objects if it pays to keep the others.

use crate::access::Access;
use crate::id::Index;
use crate::memory::slab::{OutputParts, Parts};
use crate::memory::stats::{Path, Route};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::simd::kernels::run;
use crate::sweep::Collector;
use crate::sweep::kinds::Kinds;
use crate::sweep::leaves::{TreeView, sweep_leaf};
use crate::tree::keep::{LEAVERS_SHARE, keep};
use crate::tree::shape::plant;
use crate::tree::subdivide::merge;
use crate::tree::{assign, balance};

/// Fills all leaves and sweeps them. Returns what it has found.
pub(super) fn full<I: Index>(
    parts: &mut Parts<'_, I>,
    route: Route,
    context: StepContext<'_>,
) -> (Route, u64) {
    let anew = route.path == Path::Rebuilt;
    let kept = (route.path == Path::MoversByLeaf).then(|| persistent::persistent(parts, context));
    if kept.is_none() {
        persistent::start_over(parts);
    }
    let rebalanced = arrange(parts, anew, context);
    context.executor.enter(Stage::Sweep);
    let (leaves, from) = (parts.state.tree.count, kept.unwrap_or_default());
    let moved = kept.map(|_| &*parts.moved.words);
    // Of slots in use alone, since the sweep may ask what all boxes have in common.
    let slots = parts.state.objects.slots;
    let boxes = parts.boxes.swept().span(0, slots as usize);
    let tree_view = TreeView::new(&parts.state.tree, boxes, &parts.tree);
    let pair_filter = PairFilter::if_needed(&parts.filters, slots, &context);
    let codes = bytemuck::cast_slice_mut(parts.spare).span_mut(0, slots as usize);
    let kinds = Kinds::new(pair_filter.as_ref(), moved, codes);
    let OutputParts { pairs, staged, chunks, scratch, .. } = &mut parts.output;
    let end = pairs.len() - parts.state.pairs.surplus_parked as usize;
    let (pairs, sizes) = (pairs.span_mut(0, end), &parts.sizes);
    let mut collector = Collector { pairs, staged, chunks, scratch, sizes, pair_filter, from, blocks: 0 };
    let (pairs, work) = collector.collect(context, leaves as usize, &|leaf, scratch, sink| {
        run!(context.kernels, |simd| sweep_leaf(simd, &tree_view, leaf, &kinds, scratch, sink));
    });
    context.executor.enter(Stage::Results);
    collector.merge(context, pairs);
    if kept.is_none() {
        balance::weigh(parts.state, work.candidates.saturating_sub(pairs), work.copies);
    }
    let rebalanced = if anew { parts.state.objects.live } else { rebalanced };
    parts.state.step.did(work, leaves, rebalanced);
    (route, pairs)
}

/// Fills all leaves; if some are too full, after new planes for these, or `anew` after those of the whole
/// tree. Returns how many objects got new planes otherwise.
// Its stack frame does not stand below the sweep's.
#[inline(never)]
pub(super) fn arrange<I: Index>(parts: &mut Parts<'_, I>, anew: bool, context: StepContext<'_>) -> u32 {
    let executor = context.executor;
    let was_filled = parts.state.tree.filled != 0;
    executor.enter(Stage::Build);
    let was_subdivided = merge(parts);
    balance::plan(parts.state);
    let refined = balance::refine(&mut parts.state.tree);
    if anew {
        plant(&mut parts.tree, &mut parts.state.tree);
    }
    executor.enter(Stage::Fill);
    let mut rebalanced = 0;
    let kept = if anew || was_subdivided || refined { Err(0) } else { keep(parts, context) };
    if let Err(left) = kept {
        let (mut extent, others) = assign::count(parts, context);
        let few = was_filled && left + others <= parts.state.objects.live / LEAVERS_SHARE;
        executor.enter(Stage::Build);
        rebalanced = balance::balance(parts, &extent, was_filled && !few, context);
        executor.enter(Stage::Fill);
        if rebalanced > 0 {
            extent = assign::count(parts, context).0;
        }
        while !assign::fill(parts, &extent, context) {
            assign::coarsen(parts);
            extent = assign::count(parts, context).0;
        }
        parts.state.step.kept = u8::from(few);
    }
    balance::review(parts);
    rebalanced
}
