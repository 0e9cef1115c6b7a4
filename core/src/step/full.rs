//! Steps in which many objects have moved: fill all leaves and sweep them, for all pairs, or for pairs of
//! moved objects if it pays to keep the others.

use crate::access::Access;
use crate::id::Index;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
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

/// Fills all leaves and sweeps them. Returns how many pairs there are.
pub(super) fn full<I: Index>(
    parts: &mut Parts<'_, I>,
    route: Route,
    context: StepContext<'_>,
) -> (Route, u64) {
    let anew = route.path == Path::Rebuilt;
    let kept = if route.path == Path::MoversByLeaf {
        Some(persistent::persistent(parts, context))
    } else {
        persistent::start_over(parts);
        None
    };
    let (coarse, rebalanced) = arrange(parts, anew, context);
    context.executor.enter(Stage::Sweep);
    let leaves = parts.state.tree.count;
    let (pairs, work) = sweep(parts, kept, leaves as usize, context);
    if kept.is_none() {
        balance::weigh(parts.state, work.candidates.saturating_sub(pairs), work.copies);
    }
    let rebalanced = if anew { parts.state.objects.live } else { rebalanced };
    parts.state.step.did(work, leaves, rebalanced, coarse);
    (route, pairs)
}

/// Fills all leaves; if some are too full, after new planes for these, or `anew` after those of the whole
/// tree. Returns whether `f32` is too coarse, if it has looked, and how many objects got new planes otherwise.
pub(super) fn arrange<I: Index>(
    parts: &mut Parts<'_, I>,
    anew: bool,
    context: StepContext<'_>,
) -> (Option<bool>, u32) {
    let executor = context.executor;
    let was_filled = parts.state.tree.filled != 0;
    executor.enter(Stage::Build);
    let was_subdivided = merge(parts);
    balance::plan(parts.state);
    let refined = balance::refine(parts);
    if anew {
        plant(&mut parts.tree, &mut parts.state.tree);
    }
    executor.enter(Stage::Fill);
    let (mut coarse, mut rebalanced) = (None, 0);
    if anew || was_subdivided || refined || !keep(parts, context) {
        let (mut bounds_scan, left) = assign::count(parts, context);
        let few = was_filled && left <= parts.state.objects.live / LEAVERS_SHARE;
        executor.enter(Stage::Build);
        rebalanced = balance::balance(parts, &bounds_scan.extent, was_filled && !few);
        executor.enter(Stage::Fill);
        if rebalanced > 0 {
            bounds_scan = assign::count(parts, context).0;
        }
        assign::fill(parts, &bounds_scan, context);
        coarse = Some(bounds_scan.is_coarse(parts.state.objects.live));
        parts.state.step.kept = u8::from(few);
    }
    balance::review(parts);
    (coarse, rebalanced)
}

/// Sweeps all leaves for all pairs; or, if the first `kept` pairs stay, for pairs of moved objects. Returns
/// how many pairs there are.
fn sweep<I: Index>(
    parts: &mut Parts<'_, I>,
    kept: Option<u64>,
    leaf_count: usize,
    context: StepContext<'_>,
) -> (u64, Work) {
    let StepContext { kernels, executor, .. } = context;
    let moved = kept.map(|_| &*parts.moved.words);
    let tree_view = TreeView::new(parts.state, parts.boxes.swept(), &parts.tree);
    let pair_filter = PairFilter::if_needed(&parts.filters, parts.state.objects.slots, &context);
    let codes = parts.spare.span_mut(0, parts.state.objects.slots as usize);
    let kinds = Kinds::new(pair_filter.as_ref(), moved, codes);
    let mut collector = Collector { output: &mut parts.output, sizes: &parts.sizes, pair_filter };
    collector.collect(executor, kept.unwrap_or_default(), leaf_count, &|leaf, scratch, sink| {
        run!(kernels, |simd| sweep_leaf(simd, &tree_view, leaf, &kinds, scratch, sink));
    })
}
