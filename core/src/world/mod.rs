//! The public world. [`World::advance`] is a step: its phases in order.

mod contents;
mod filters;
mod inline;
mod names;
mod objects;
mod rest;
mod result;
mod shift;
mod stepper;
mod view;

pub use inline::InlineWorld;
pub use objects::Inserted;
pub use result::Step;
pub use stepper::Stepper;
pub use view::{LeafView, PlaneView};

use crate::access::{Access, faults};
use crate::config::Config;
use crate::error::{Error, Rejected};
use crate::geometry::aabb::{Aabb, Boxes};
use crate::id::{Id, Index, Pair};
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Progress, Route, Stats};
use crate::objects::intake::ingest;
use crate::pairs::results;
use crate::parallel::context::StepContext;
use crate::parallel::executor::{OneStep, Stage};
use crate::simd::kernels::Kernels;
use crate::step;
use crate::step::{policy, recount};
use crate::tree::keep;

/// Boxes, and which of them overlap.
///
/// A view of a slab that the caller lends; all state is in the slab, so a world can be dropped and
/// [opened](Self::open) again. `I` is the width of slots in memory and in pairs.
pub struct World<'m, I: Index = u32> {
    pub(crate) parts: Parts<'m, I>,
    pub(crate) kernels: Kernels,
}

/// From this many objects on a step is shared between workers, where no hook decides: below, to hand out the work takes
/// longer than to do it. Miri is too slow for that many.
const SHARED_FROM: u32 = if cfg!(miri) { 0 } else { 4096 };

/// A step.
impl<I: Index> World<'_, I> {
    fn advance(&mut self, bounds: Option<Boxes<'_>>, context: StepContext<'_>) -> Result<Step<'_, I>, Error> {
        let parts = &mut self.parts;
        let shared =
            parts.state.setup.hooks().sharing.fixed().unwrap_or(parts.state.objects.live >= SHARED_FROM);
        // A small world shares nothing.
        let shared = shared && !context.is_small();
        let executor = OneStep::new(context.executor, shared);
        let context = StepContext { executor: &executor, ..context };
        let (rejected, settled) = Self::take_in(parts, bounds, context);
        let mut result = Self::find(parts, settled, shared, context);
        if faults() != parts.state.faults {
            parts.state.faults = faults();
            parts.state.pairs.complete = 0;
            parts.state.tree.built = 0;
            parts.state.tree.baseline = 0;
            parts.state.tree.filled = 0;
            parts.state.lists.stale = 1;
            result = Err(Error::InvariantBroken);
        }
        context.executor.enter(Stage::Done);
        result?;
        Ok(Step { rejected, world: self })
    }

    /// All pairs of the boxes as they are now, and which of them are new or gone.
    fn find(
        parts: &mut Parts<'_, I>,
        mut settled: Option<u32>,
        shared: bool,
        context: StepContext<'_>,
    ) -> Result<(), Error> {
        let moved = parts.moved.count();
        if cfg!(feature = "large") && policy::weigh_margins(parts, moved) {
            settled = None;
        }
        let mut route = policy::choose(parts, moved);
        if cfg!(feature = "large") && parts.state.pairs.unproven != 0 {
            route = recount::prove(parts, route, moved, context);
        }
        policy::subdivide_when_calm(parts, route.path, moved, context);
        if route.path == Path::Unchanged && parts.state.objects.moved_inside_margin == 0 {
            Self::keep(parts, shared);
            return Ok(());
        }
        results::remember(parts);
        let (mut route, mut progress) = step::find(parts, route, settled, context);
        if progress.pairs > parts.output.pairs.len() as u64 && parts.has_surplus() {
            (route, progress) = step::find_without_surplus(parts, context);
        }
        parts.state.step.record(moved, parts.state.objects.outran, route, shared, &progress);
        context.executor.enter(Stage::Results);
        Self::conclude(parts, &progress, context)
    }

    /// Ingest: the caller's boxes, where there are any, and who moved (paper, section III.B).
    fn take_in(
        parts: &mut Parts<'_, I>,
        bounds: Option<Boxes<'_>>,
        context: StepContext<'_>,
    ) -> (Option<Rejected>, Option<u32>) {
        let Some(bounds) = bounds else { return (None, None) };
        parts.state.objects.dirty = 1;
        context.executor.enter(Stage::Intake);
        let settles = cfg!(feature = "large") && keep::settles(parts);
        let intake = ingest(parts, &bounds, settles, context.kernels, context.executor);
        parts.state.objects.note(intake.motions);
        let slot = intake.first_rejected;
        let first =
            if intake.rejected == 0 { None } else { Id::new(slot, parts.generations.at(slot as usize)) };
        (first.map(|first| Rejected { first, count: intake.rejected }), settles.then_some(intake.left))
    }

    /// Nothing has changed: the result stays as it is, with nothing found or lost.
    fn keep(parts: &mut Parts<'_, I>, shared: bool) {
        let leaves = parts.state.leaves();
        let progress = Progress { leaves, ..Progress::default() };
        parts.state.step.record(0, parts.state.objects.outran, Route::UNCHANGED, shared, &progress);
        parts.state.pairs.found = 0;
        parts.state.pairs.lost = 0;
        parts.state.objects.dirty = 0;
    }

    /// Exact test and events, if all pairs are there; else the prefix that fits, and everything stays as it was for
    /// the step that will be complete.
    fn conclude(
        parts: &mut Parts<'_, I>,
        progress: &Progress,
        context: StepContext<'_>,
    ) -> Result<(), Error> {
        let pairs = progress.pairs;
        let fitting = pairs.min(parts.output.pairs.len() as u64);
        let complete = pairs == fitting;
        results::sort_out(parts, fitting as usize, complete, progress.found, context);
        parts.state.pairs.complete = u8::from(complete);
        if !complete {
            return Err(Error::PairsFull { needed: pairs });
        }
        parts.changed.move_to(&mut parts.outdated);
        parts.moved.clear();
        parts.state.objects.moved_inside_margin = 0;
        parts.state.objects.outran = 0;
        parts.filters.changed.clear();
        if parts.state.objects.has_inserted == 0 {
            // Those are of the step before.
            parts.former.reused.clear();
        }
        parts.state.objects.has_inserted = 0;
        parts.state.objects.dirty = 0;
        Ok(())
    }
}

/// Making and asking.
impl<'m, I: Index> World<'m, I> {
    /// Makes an empty world in `slab`, which must be as long and as aligned as [`layout`](crate::layout) says. What was
    /// in the slab does not matter; what is beyond the needed length is not touched. O(bytes).
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`], [`Error::SlabMisaligned`], [`Error::CapacityTooLarge`] or [`Error::BadMargin`].
    pub fn new_in(slab: &'m mut [u8], config: &Config) -> Result<Self, Error> {
        Parts::init(slab, config).map(Self::of)
    }

    /// Opens the world that [`new_in`](Self::new_in) made in `slab`, with all that it holds. O(1).
    ///
    /// # Errors
    /// [`Error::NotAWorld`] where there is none of this index width, and the errors of `new_in`.
    pub fn open(slab: &'m mut [u8]) -> Result<Self, Error> {
        Parts::open(slab).map(Self::of)
    }

    fn of(parts: Parts<'m, I>) -> Self {
        Self { parts, kernels: Kernels::detect() }
    }

    /// What the world was made for.
    #[must_use]
    pub fn config(&self) -> Config {
        // The state of an opened world is known to be good.
        self.parts.state.setup.config(size_of::<I>()).unwrap_or(Config::new(crate::Capacity::for_objects(0)))
    }

    /// Living objects.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.parts.state.objects.live
    }

    /// Whether there is no object.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether `id` names a living object.
    #[must_use]
    pub fn contains(&self, id: Id) -> bool {
        self.slot_of(id).is_ok()
    }

    /// The object that lives in `slot`.
    #[must_use]
    pub fn id_at(&self, slot: u32) -> Option<Id> {
        let lives =
            slot < self.parts.state.objects.slots && !self.parts.boxes.now.at(slot as usize).is_empty();
        if lives { Id::new(slot, self.parts.generations.at(slot as usize)) } else { None }
    }

    /// The box of an object, as it was given last.
    #[must_use]
    pub fn aabb(&self, id: Id) -> Option<Aabb> {
        self.slot_of(id).ok().map(|slot| self.parts.boxes.now.at(slot).to_aabb())
    }

    pub(crate) fn slot_of(&self, id: Id) -> Result<usize, Error> {
        if self.id_at(id.slot()) == Some(id) { Ok(id.slot() as usize) } else { Err(Error::StaleId { id }) }
    }
}

/// Results.
impl<I: Index> World<'_, I> {
    /// The overlapping pairs of the last step, each once, the lower slot first; in no order that means anything, but
    /// always the same for the same calls. After [`Error::PairsFull`] those that fitted.
    #[must_use]
    pub fn pairs(&self) -> &[Pair<I>] {
        let result = self.parts.state.pairs.result();
        self.parts.output.pairs.span(result.start, result.len())
    }

    /// With events: the pairs that the last step has and the complete step before it had not. A pair of other objects in
    /// the same slots counts as another pair.
    #[must_use]
    pub fn found(&self) -> &[Pair<I>] {
        let found = self.parts.state.pairs.found as usize;
        self.parts.output.pairs.span(self.parts.state.pairs.result().end - found, found)
    }

    /// With events: the pairs that the complete step before the last one had and the last one has not. A removed object's
    /// slot may hold a new one by now.
    #[must_use]
    pub fn lost(&self) -> &[Pair<I>] {
        self.parts.output.previous.span(0, self.parts.state.pairs.lost as usize)
    }

    /// What the last step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.parts.state.stats()
    }
}
