//! Steps in which few objects have moved: test each against the leaves that it reaches, and keep all other
//! pairs (paper, section III.B.1).

use crate::access::Access;
use crate::id::Index;
use crate::memory::limits::MOVERS_PER_BLOCK;
use crate::memory::slab::{OutputParts, Parts};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::simd::kernels::run;
use crate::sweep::Collector;
use crate::sweep::leaves::TreeView;
use crate::sweep::movers::sweep_movers;
use crate::tree::large;
use crate::tree::refit::refit_some;
use crate::tree::relocate::{order_movers, relocate_all, thirds};

/// Moves the records of moved objects and tests them. Returns what it has found; `None` if a leaf
/// had no room.
// Its stack frame does not stand below the sweep's.
#[inline(never)]
pub(super) fn movers<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Option<u64> {
    let moved = relocate(parts, context)?;
    let count = order_movers(parts, moved);
    let from = persistent::persistent(parts, context);
    context.executor.enter(Stage::Sweep);
    let leaves = parts.state.leaves();
    // As many blocks as in a full step at most, as each may leave a chunk of pairs unfinished.
    let per_block = count.div_ceil(parts.state.tree.count.max(1) as usize).max(MOVERS_PER_BLOCK);
    let [_, homes, movers] = thirds(parts.spare);
    let (movers, homes) = (movers.span(0, count), homes.span(0, count));
    let moved = &*parts.moved.words;
    let tree_view = TreeView::new(&parts.state.tree, parts.boxes.swept(), &parts.tree);
    let pair_filter = PairFilter::new(&parts.filters, context.rule);
    let OutputParts { pairs, staged, chunks, scratch, .. } = &mut parts.output;
    let end = pairs.len() - parts.state.pairs.surplus_parked as usize;
    let (pairs, blocks, sizes) = (pairs.span_mut(0, end), count.div_ceil(per_block), &parts.sizes);
    let mut collector = Collector { pairs, staged, chunks, scratch, sizes, pair_filter, from, blocks: 0 };
    let (pairs, work) = collector.collect(context, blocks, &|block, scratch, sink| {
        let start = block * per_block;
        let len = per_block.min(count - start);
        let movers = (movers.span(start, len), homes.span(start, len));
        let filters = pair_filter.as_ref();
        run!(context.kernels, |simd| sweep_movers(simd, &tree_view, moved, movers, filters, scratch, sink));
    });
    context.executor.enter(Stage::Results);
    collector.merge(context, pairs);
    parts.state.step.did(work, leaves, 0);
    Some(pairs)
}

/// Moves the records of moved objects, which are in the scratch memory then. Returns how many they are;
/// `None` if a leaf had no room, or there is none for so many.
pub(super) fn relocate<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Option<usize> {
    context.executor.enter(Stage::Fill);
    let [movers, ..] = thirds(parts.spare);
    if parts.moved.count() as usize > movers.len() {
        return None;
    }
    let moved = parts.moved.list(movers);
    if !relocate_all(parts, moved, context) {
        return None;
    }
    if large::is_due(&parts.state.tree) {
        large::arrange(parts, true);
    }
    refit_some(parts, moved);
    Some(moved)
}
