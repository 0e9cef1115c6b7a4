//! Steps in which many objects have moved: all leaves are filled and swept.

use crate::id::Index;
use crate::memory::limits::LEAVES_PER_BLOCK;
use crate::memory::slab::Parts;
use crate::memory::state::{Path, Progress, Reason, Route};
use crate::pairs::carry;
use crate::pairs::gate::Gate;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::Collector;
use crate::sweep::leaves::{Grove, SweepLeaves};
use crate::tree::refine::coarsen;
use crate::tree::{assign, balance};

/// Many have moved: fill all leaves and sweep them; where they are out of balance, after new planes.
pub(super) fn full<I: Index>(
    parts: &mut Parts<'_, I>,
    mut route: Route,
    means: StepContext<'_>,
) -> (Route, Progress) {
    let StepContext { kernels, executor, .. } = means;
    let mut replant = route.path == Path::Rebuilt;
    carry::start_over(parts);
    executor.enter(Stage::Build);
    let was_refined = coarsen(parts);
    let rebalanced = if replant {
        balance::plant(parts, means);
        0
    } else if was_refined {
        0
    } else {
        balance::rebalance(parts, means)
    };
    balance::deepen(parts);
    executor.enter(Stage::Fill);
    let mut census = assign::count(parts, kernels, executor);
    if !replant && balance::is_out_of_balance(parts) {
        replant = true;
        route = Route { path: Path::Rebuilt, reason: Reason::OutOfBalance };
        executor.enter(Stage::Build);
        balance::plant(parts, means);
        executor.enter(Stage::Fill);
        census = assign::count(parts, kernels, executor);
    }
    if replant {
        balance::settle(parts);
    }
    assign::fill(parts, &census, kernels, executor);
    balance::review(parts);
    executor.enter(Stage::Sweep);
    let leaf_count = 1usize << parts.state.depth;
    let grove = Grove::new(parts.state, parts.boxes.swept(), &parts.tree);
    let gate = Gate::new(&parts.filters, means.rule);
    let mut collector = Collector::new(&mut parts.output, &parts.sizes, gate);
    let blocks = leaf_count.div_ceil(LEAVES_PER_BLOCK);
    let (pairs, work) = collector.collect(executor, 0, blocks, &|block, scratch, sink| {
        let first = block * LEAVES_PER_BLOCK;
        let leaves = first..(first + LEAVES_PER_BLOCK).min(leaf_count);
        kernels.run_wide(SweepLeaves { grove: &grove, leaves, scratch, sink });
    });
    balance::weigh(parts.state, work.candidates.saturating_sub(pairs), replant);
    let rebalanced = if replant { parts.state.live } else { rebalanced };
    let coarse = Some(census.is_coarse(parts.state.live));
    (route, Progress { pairs, work, leaves: leaf_count as u32, rebalanced, coarse })
}
