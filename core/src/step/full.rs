//! Steps in which many objects have moved: all leaves are filled and swept.

use crate::id::Index;
use crate::memory::limits::LEAVES_PER_BLOCK;
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Progress, Reason, Route};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::Collector;
use crate::sweep::leaves::{SweepLeaves, TreeView};
use crate::tree::subdivide::merge;
use crate::tree::{assign, balance};

/// Many have moved: fill all leaves and sweep them; where they are out of balance, after new planes.
pub(super) fn full<I: Index>(
    parts: &mut Parts<'_, I>,
    mut route: Route,
    context: StepContext<'_>,
) -> (Route, Progress) {
    let StepContext { kernels, executor, .. } = context;
    let mut rebuild = route.path == Path::Rebuilt;
    persistent::start_over(parts);
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
    balance::deepen(parts);
    executor.enter(Stage::Fill);
    let mut bounds_scan = assign::count(parts, kernels, executor);
    if !rebuild && balance::is_out_of_balance(parts) {
        rebuild = true;
        route = Route { path: Path::Rebuilt, reason: Reason::OutOfBalance };
        executor.enter(Stage::Build);
        balance::build_planes(parts, context);
        executor.enter(Stage::Fill);
        bounds_scan = assign::count(parts, kernels, executor);
    }
    if rebuild {
        balance::set_baseline(parts);
    }
    assign::fill(parts, &bounds_scan, kernels, executor);
    balance::review(parts);
    executor.enter(Stage::Sweep);
    let leaf_count = 1usize << parts.state.tree.depth;
    let tree_view = TreeView::new(parts.state, parts.boxes.swept(), &parts.tree);
    let pair_filter = PairFilter::if_needed(&parts.filters, parts.state.objects.slots, &context);
    let mut collector = Collector::new(&mut parts.output, &parts.sizes, pair_filter);
    let blocks = leaf_count.div_ceil(LEAVES_PER_BLOCK);
    let (pairs, work) = collector.collect(executor, 0, blocks, &|block, scratch, sink| {
        let first = block * LEAVES_PER_BLOCK;
        let leaves = first..(first + LEAVES_PER_BLOCK).min(leaf_count);
        kernels.run_wide(SweepLeaves { tree_view: &tree_view, leaves, scratch, sink });
    });
    balance::weigh(parts.state, work.candidates.saturating_sub(pairs), rebuild);
    let rebalanced = if rebuild { parts.state.objects.live } else { rebalanced };
    let coarse = Some(bounds_scan.is_coarse(parts.state.objects.live));
    (route, Progress { pairs, work, leaves: leaf_count as u32, rebalanced, coarse })
}
