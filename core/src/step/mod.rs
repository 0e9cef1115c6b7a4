//! The ways to find the overlaps of swept boxes, and the choice between them.
//!
//! All give the same set. Which one is cheapest follows from counts alone, so equal calls choose equally.

mod full;
mod incremental;
mod lists;
pub(crate) mod policy;
pub(crate) mod recount;

use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Progress, Reason, Route};
use crate::pairs::persistent;
use crate::parallel::context::StepContext;

/// Finds the overlaps by a path, which may have to give way to a wider one. Returns the one that was used.
pub(crate) fn find<I: Index>(
    parts: &mut Parts<'_, I>,
    route: Route,
    settled: Option<u32>,
    context: StepContext<'_>,
) -> (Route, Progress) {
    parts.state.pairs.without_surplus = 0;
    match route.path {
        Path::Unchanged => (route, unchanged(parts)),
        _ if parts.sizes.is_small() => (route, lists::small(parts, context)),
        Path::Movers => match incremental::movers(parts, context) {
            Some(progress) => (route, progress),
            None => full::full(parts, policy::anew(parts, Reason::NoRoom), None, context),
        },
        Path::Lists | Path::MoversByLeaf | Path::Full | Path::Rebuilt => {
            full::full(parts, route, settled, context)
        }
    }
}

/// Finds the overlaps of the boxes as given, after a step of an exact world found more overlaps of fat boxes than fit: its pairs
/// may fit without the surplus. None of these pairs persists, so the next step finds all pairs anew.
pub(crate) fn find_without_surplus<I: Index>(
    parts: &mut Parts<'_, I>,
    context: StepContext<'_>,
) -> (Route, Progress) {
    // What the result before has to tell is kept already.
    parts.state.pairs.complete = 0;
    parts.boxes.tight = true;
    let route = policy::choose(parts, parts.state.objects.live);
    let (route, progress) = find(parts, route, None, context);
    parts.boxes.tight = false;
    parts.state.tree.filled = 0;
    parts.state.pairs.without_surplus = 1;
    (Route { reason: Reason::NoRoomForSurplus, ..route }, progress)
}

/// Nothing has moved: all pairs stay.
fn unchanged<I: Index>(parts: &mut Parts<'_, I>) -> Progress {
    let leaves = parts.state.leaves();
    Progress { pairs: persistent::persistent(parts), leaves, ..Progress::default() }
}
