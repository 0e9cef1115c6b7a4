//! The public world. [`World::advance`] is a step: its phases in order.

// In the order of use, in which the documentation lists the methods.
mod make;
mod objects;
mod attributes;
mod steps;
mod contents;
mod shift;
mod view;

pub use make::InlineWorld;
pub use objects::Inserted;
pub use steps::{Step, Stepper};
pub use view::{LeafView, PlaneView};

use crate::access::Access;
use crate::config::{SHARING, TREE};
use crate::error::{Error, Rejected};
use crate::geometry::boxes::Boxes;
use crate::id::{Id, Index};
use crate::memory::limits::SHARED_FROM;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::PairState;
use crate::memory::stats::{Path, Reason};
use crate::objects::intake::ingest;
use crate::pairs::{met, persistent, results};
use crate::parallel::context::StepContext;
use crate::parallel::executor::{OneStep, Stage};
use crate::simd::kernels::Kernels;
use crate::step;
use crate::step::policy;

/// Boxes, and which of them overlap.
///
/// A view of a slab that the caller lends. All state is in the slab, so a world can be dropped and
/// [opened](Self::open) again. `I` is the width of slots in memory and in pairs.
///
/// Its methods in the order of use: [make](Self::new_in) a world; [insert](Self::insert) objects, give them
/// boxes, [values](Self::set_value), [filters](Self::set_filter) or [rest](Self::set_resting);
/// [step](Self::step); look at the [results](Self::pairs) by slot, id or value, and at [what is
/// there](Self::iter). Between two steps [queries](Self::overlaps) answer, [snapshots](Self::save) are taken
/// and loaded, a world [moves](Self::move_into) to where there is more room.
#[doc(alias("broad_phase", "bvh", "dynamic_tree", "space"))]
pub struct World<'m, I: Index = u32> {
    pub(crate) parts: Parts<'m, I>,
    pub(crate) kernels: Kernels,
}

// A step.
impl<I: Index> World<'_, I> {
    fn advance(&mut self, bounds: Option<Boxes<'_>>, context: StepContext<'_>) -> Result<Step<'_, I>, Error> {
        let find = |parts: &mut Parts<'_, I>, context: StepContext<'_>, shared| {
            if TREE {
                parts.settled.move_to(&mut parts.moved);
            }
            parts.state.objects.dirty = 1;
            let rejected = Self::take_in(parts, bounds, context);
            (rejected, Self::find(parts, shared, context))
        };
        let rejected = self.run(context, find, |parts, (rejected, needed)| {
            Self::conclude(parts, needed).map(|()| rejected)
        })?;
        Ok(Step { rejected, world: self })
    }

    fn renew_tree(&mut self, context: StepContext<'_>) -> Result<(), Error> {
        let state = &self.parts.state;
        let is_divided = state.tree.subdivided > state.tree.count;
        if self.parts.sizes.is_small() || state.tree.filled != 0 && state.objects.dirty == 0 && is_divided {
            return Ok(());
        }
        let refresh = |parts: &mut Parts<'_, I>, context: StepContext<'_>, _| step::refresh(parts, context);
        self.run(context, refresh, |parts, ()| {
            Self::settle(parts);
            Ok(())
        })
    }

    /// Does a step, and concludes it unless an index was out of range.
    fn run<T, R>(
        &mut self,
        context: StepContext<'_>,
        work: impl FnOnce(&mut Parts<'_, I>, StepContext<'_>, bool) -> T,
        conclude: impl FnOnce(&mut Parts<'_, I>, T) -> Result<R, Error>,
    ) -> Result<R, Error> {
        self.parts.state.stepping = 1;
        let unfinished = Unfinished(&mut self.parts);
        let parts = &mut *unfinished.0;
        let shared = Self::shares(parts);
        let executor = OneStep::new(context.executor, shared);
        let context = StepContext { executor: &executor, ..context };
        let done = work(parts, context, shared);
        let result = if parts.watch.sees_fault() {
            parts.watch.forget();
            Err(Error::InvariantBroken)
        } else {
            parts.state.stepping = 0;
            conclude(parts, done)
        };
        drop(unfinished);
        context.executor.enter(Stage::Done);
        result
    }

    /// For tests: as if an index into the memory of this world had been out of range.
    #[cfg(feature = "validate")]
    #[doc(hidden)]
    pub fn break_index(&self) {
        crate::access::note_fault(self.parts.generations.as_ptr().addr());
    }

    /// Whether the work is offered to the executor's workers. A world without a tree shares nothing.
    fn shares(parts: &Parts<'_, I>) -> bool {
        // An interpreter takes minutes for so many.
        let from = if cfg!(miri) { 512 } else { SHARED_FROM };
        let is_large = parts.state.objects.live >= from;
        !parts.sizes.is_small() && parts.config().forced.of(SHARING).unwrap_or(is_large)
    }

    /// The tree has all objects as they are.
    fn settle(parts: &mut Parts<'_, I>) {
        if cfg!(feature = "large") && parts.state.tree.filled != 0 {
            parts.moved.move_to(&mut parts.settled);
            parts.state.objects.dirty = 0;
        }
    }

    /// All pairs of the boxes as they are now, and which of them are new or gone. Returns for how many there
    /// has to be room.
    fn find(parts: &mut Parts<'_, I>, shared: bool, context: StepContext<'_>) -> u64 {
        let moved = parts.moved.count();
        // Whose fat box is left unused from now on has another box that is swept.
        let swept_anew = if cfg!(feature = "large") { policy::renew(parts, moved) } else { moved };
        let route = policy::choose(parts, swept_anew);
        policy::subdivide_when_calm(parts, route.path, moved, context);
        if route.path == Path::Unchanged && (parts.sizes.is_small() || !parts.any_stays()) {
            // Nothing has changed.
            parts.state.step.did(Work::default(), parts.state.leaves(), 0);
            parts.state.step.record(0, 0, route, shared);
            (parts.state.pairs.found, parts.state.pairs.lost) = (0, 0);
            return 0;
        }
        results::remember(parts);
        let room = parts.output.pairs.len() as u64;
        let (mut route, mut pairs) = step::find(parts, route, context);
        if pairs > room && parts.boxes.are_fat() {
            // Without surplus they may fit. Fat boxes are left unused for a while.
            policy::pause(parts);
            let all = policy::choose(parts, parts.state.objects.live);
            (route, pairs) = step::find(parts, all, context);
            route.reason = Reason::NoRoomForSurplus;
        }
        parts.state.step.record(moved, parts.state.objects.outran, route, shared);
        context.executor.enter(Stage::Results);
        results::sort_out(parts, pairs, context);
        pairs
    }

    /// Takes in the caller's boxes, if there are any (paper, section III.B.1). Returns which were refused.
    fn take_in(
        parts: &mut Parts<'_, I>,
        bounds: Option<Boxes<'_>>,
        context: StepContext<'_>,
    ) -> Option<Rejected> {
        let bounds = bounds?;
        context.executor.enter(Stage::Intake);
        let regrows = policy::regrows(parts, &bounds);
        if cfg!(feature = "large") {
            policy::foresee(parts, &bounds, regrows);
        }
        let intake = ingest(parts, &bounds, regrows, context);
        parts.state.objects.outran = parts.state.objects.outran.saturating_add(intake.outran);
        let slot = intake.first_rejected?;
        let first = Id::new(slot, parts.generations.at(slot as usize));
        first.map(|first| Rejected { first, count: intake.rejected })
    }

    /// The step is complete, if all pairs fit. Else the result has the pairs that fit, and everything else
    /// stays for the next complete step.
    fn conclude(parts: &mut Parts<'_, I>, needed: u64) -> Result<(), Error> {
        if needed > parts.output.pairs.len() as u64 {
            Self::settle(parts);
            parts.state.objects.has_inserted = 2 * parts.state.objects.has_inserted.min(1);
            return Err(Error::PairsFull { needed, room: parts.output.pairs.len() as u32 });
        }
        parts.state.pairs.complete = 1;
        parts.state.tree.known = parts.state.objects.slots;
        parts.state.pairs.before_unknown = 0;
        if TREE {
            parts.changed.move_to(&mut parts.outdated);
        }
        parts.moved.clear();
        parts.state.objects.outran = 0;
        parts.filters.changed.clear();
        parts.state.objects.has_inserted = 0;
        parts.state.objects.dirty = 0;
        Ok(())
    }
}

/// A step that has begun. Dropped before it has ended, as when the caller's code panics in it, it leaves no
/// result, and all that the next step needs to find all pairs anew, with events relative to the last complete
/// step.
struct Unfinished<'p, 'm, I: Index>(&'p mut Parts<'m, I>);

impl<I: Index> Drop for Unfinished<'_, '_, I> {
    fn drop(&mut self) {
        let Self(parts) = self;
        if parts.state.stepping == 0 {
            return;
        }
        parts.boxes.tight = parts.state.step.margins_in > 0;
        persistent::start_over(parts);
        met::set_all(parts);
        let PairState { swept, reported, found, lost, .. } = &mut parts.state.pairs;
        (*swept, *reported, *found, *lost) = (0, 0, 0, 0);
        parts.state.tree.forget();
        parts.state.lists.stale = 1;
        parts.state.objects.dirty = 1;
        parts.state.stepping = 0;
    }
}
