//! Steps in which many objects have moved: fill all leaves and sweep them, for all pairs, or for those of moved
//! objects if it pays to keep the others.

use crate::access::Access;
use crate::id::Index;
use crate::memory::limits::LEAVES_PER_BLOCK;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Progress, Reason, Route};
use crate::pairs::events;
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::Collector;
use crate::sweep::kinds::Kinds;
use crate::sweep::leaves::{SweepLeaves, TreeView};
use crate::tree::subdivide::merge;
use crate::tree::{assign, balance, keep};

/// Fills all leaves and sweeps them; if they are out of balance, after new planes. `settled`: how many objects left
/// their leaf, if the intake has brought the others to their records.
pub(super) fn full<I: Index>(
    parts: &mut Parts<'_, I>,
    mut route: Route,
    settled: Option<u32>,
    context: StepContext<'_>,
) -> (Route, Progress) {
    let executor = context.executor;
    let mut rebuild = route.path == Path::Rebuilt;
    let was_filled = parts.state.tree.filled != 0;
    let kept = if route.path == Path::MoversByLeaf {
        Some(persistent::persistent(parts))
    } else {
        persistent::start_over(parts);
        None
    };
    executor.enter(Stage::Build);
    let was_subdivided = merge(parts);
    let rebalanced = if rebuild {
        balance::build_planes(parts, context);
        0
    } else if was_subdivided {
        0
    } else {
        balance::rebalance(parts, context)
    };
    let depth = parts.state.tree.depth;
    balance::deepen(parts);
    executor.enter(Stage::Fill);
    let settled =
        settled.filter(|_| !rebuild && !was_subdivided && rebalanced == 0 && parts.state.tree.depth == depth);
    let leaves_stay = settled.is_some_and(|settled| keep::settle(parts, settled, context));
    let mut counted = if leaves_stay { None } else { Some(assign::count(parts, context)) };
    if !rebuild && balance::is_out_of_balance(parts) {
        rebuild = true;
        route = Route { path: Path::Rebuilt, reason: Reason::OutOfBalance };
        executor.enter(Stage::Build);
        balance::build_planes(parts, context);
        executor.enter(Stage::Fill);
        counted = Some(assign::count(parts, context));
    }
    if rebuild {
        balance::set_baseline(parts);
    }
    let coarse = counted.map(|(bounds_scan, _)| {
        assign::fill(parts, &bounds_scan, context);
        bounds_scan.is_coarse(parts.state.objects.live)
    });
    balance::review(parts);
    executor.enter(Stage::Sweep);
    let Swept { pairs, work, found, leaves } = sweep(parts, kept, context);
    if kept.is_none() {
        balance::weigh(parts.state, work.candidates.saturating_sub(pairs), rebuild);
    }
    // If no leaves were filled before, all objects count as having left theirs.
    let left = counted.map(|(_, left)| if was_filled { left } else { u32::MAX });
    keep::plan(parts.state, work.tied, left);
    let rebalanced = if rebuild { parts.state.objects.live } else { rebalanced };
    (route, Progress { pairs, work, leaves, rebalanced, coarse, found })
}

/// The result of a sweep of all leaves.
struct Swept {
    pairs: u64,
    work: Work,
    /// How many of these pairs are found, if the events were told block by block.
    found: Option<u64>,
    leaves: u32,
}

/// Sweeps all leaves for all pairs; or, if the first `kept` pairs stay, for those of moved objects.
fn sweep<I: Index>(parts: &mut Parts<'_, I>, kept: Option<u64>, context: StepContext<'_>) -> Swept {
    let StepContext { kernels, executor, .. } = context;
    let leaf_count = 1usize << parts.state.tree.depth;
    let blocks = leaf_count.div_ceil(LEAVES_PER_BLOCK);
    let tells = kept.is_none() && events::share_out(parts, blocks);
    let moved = kept.map(|_| &*parts.moved.words);
    let tree_view = TreeView::new(parts.state, parts.boxes.swept(), &parts.tree);
    let pair_filter = PairFilter::if_needed(&parts.filters, parts.state.objects.slots, &context);
    // The sorted lists serve as scratch memory.
    parts.state.lists.stale = 1;
    let codes = parts.order[2].span_mut(0, parts.state.objects.slots as usize);
    let kinds = Kinds::new(pair_filter.as_ref(), moved, codes);
    let mut next = [&[][..]; 2];
    let mut collector = if tells {
        let boxes = events::Boxes::new(&parts.boxes, parts.state, kernels);
        next = boxes.far();
        Collector::with_events(&mut parts.output, &parts.sizes, pair_filter, boxes, parts.state)
    } else {
        Collector::new(&mut parts.output, &parts.sizes, pair_filter)
    };
    let (pairs, work) =
        collector.collect(executor, kept.unwrap_or_default(), blocks, &|block, scratch, sink| {
            let first = block * LEAVES_PER_BLOCK;
            let leaves = first..(first + LEAVES_PER_BLOCK).min(leaf_count);
            kernels.run(SweepLeaves { tree_view: &tree_view, leaves, kinds, next, scratch, sink });
        });
    Swept { pairs, work, found: tells.then_some(collector.found), leaves: leaf_count as u32 }
}
