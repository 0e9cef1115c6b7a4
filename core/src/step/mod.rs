//! Finds the overlaps of swept boxes, by one of several paths.
//!
//! All give the same pairs. [`policy`] chooses by counts alone, so equal calls choose equally.

mod full;
mod incremental;
mod lists;
pub(crate) mod policy;

use crate::id::Index;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Reason, Route};
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::tree::balance;
use crate::tree::keep::LEAVERS_SHARE;

/// Finds the overlaps. The path may turn out to be impossible; then a full step follows. Returns the path
/// that was used, and how many overlaps there are, whether they fit or not.
pub(crate) fn find<I: Index>(
    parts: &mut Parts<'_, I>,
    route: Route,
    context: StepContext<'_>,
) -> (Route, u64) {
    parts.state.pairs.unkept = 0;
    let (route, pairs) = match route.path {
        _ if parts.sizes.is_small() => (route, lists::small(parts, context)),
        // Without fat boxes nothing is left to do.
        Path::Unchanged => {
            parts.state.step.did(Work::default(), parts.state.leaves(), 0);
            (route, persistent::persistent(parts, context))
        }
        Path::Movers => match incremental::movers(parts, context) {
            Some(pairs) => (route, pairs),
            None => full::full(parts, policy::anew(parts, Reason::NoRoom), context),
        },
        Path::Lists | Path::MoversByLeaf | Path::Full | Path::Rebuilt => full::full(parts, route, context),
    };
    (route, pairs + u64::from(parts.state.pairs.surplus_parked))
}

/// Brings the tree up to date, without a look for pairs: moves the records of moved objects, or fills all
/// leaves where that takes less. Leaves are divided as in steps of a calm world.
pub(crate) fn refresh<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let (filled, moved) = (parts.state.tree.filled, parts.moved.count());
    let few = moved <= parts.state.objects.live / LEAVERS_SHARE;
    let mut path = Path::Movers;
    if filled == 0 || !few || incremental::relocate(parts, context).is_none() {
        full::arrange(parts, balance::needs_planes(parts.state), context);
        parts.state.tree.filled = if filled == 1 { 1 } else { 2 };
        path = Path::Full;
    }
    policy::subdivide_when_calm(parts, path, moved, context);
}
