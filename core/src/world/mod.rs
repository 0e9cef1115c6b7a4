//! The public world. [`World::advance`] is a step: its phases in order.

mod filters;
mod inline;
mod rest;
mod shift;
mod view;

pub use inline::InlineWorld;
pub use view::{LeafView, PlaneView};

use crate::access::{Access, bits, faults};
use crate::config::Config;
use crate::error::{Error, Rejected};
use crate::filter::{Filter, Rule};
use crate::geometry::aabb::{Aabb, Boxes};
use crate::geometry::key::KeyBox;
use crate::id::{Id, Index, Pair};
use crate::lists::links;
use crate::memory::slab::Parts;
use crate::memory::state::{Path, Route, Stats};
use crate::objects::intake::ingest;
use crate::objects::margin_length;
use crate::pairs::results;
use crate::parallel::context::StepContext;
use crate::parallel::executor::{Executor, OneStep, Stage};
use crate::simd::kernels::Kernels;
use crate::step;
use crate::step::recount;

/// Boxes, and which of them overlap.
///
/// A view of a slab that the caller lends; all state is in the slab, so a world can be dropped and
/// [opened](Self::open) again. `I` is the width of slots in memory and in pairs.
pub struct World<'m, I: Index = u32> {
    pub(crate) parts: Parts<'m, I>,
}

/// From this many objects on a step is shared between workers, where nobody has chosen: below, to hand out the work takes
/// longer than to do it. Miri is too slow for that many.
const SHARED_FROM: u32 = if cfg!(miri) { 0 } else { 4096 };

/// A step.
impl<I: Index> World<'_, I> {
    fn advance(&mut self, bounds: Option<Boxes<'_>>, means: StepContext<'_>) -> Result<Step<'_, I>, Error> {
        let parts = &mut self.parts;
        let shared = parts.state.sharing().fixed().unwrap_or(parts.state.live >= SHARED_FROM);
        // A small world shares nothing.
        let shared = shared && !means.is_small();
        let executor = OneStep::new(means.executor, shared);
        let means = StepContext { executor: &executor, ..means };
        let rejected = Self::take_in(parts, bounds, means);
        let mut result = Self::find(parts, shared, means);
        if faults() != parts.state.faults {
            parts.state.faults = faults();
            parts.state.complete = 0;
            parts.state.planted = 0;
            parts.state.settled = 0;
            parts.state.filled = 0;
            parts.state.stale_lists = 1;
            result = Err(Error::InvariantBroken);
        }
        means.executor.enter(Stage::Done);
        result?;
        Ok(Step { rejected, world: self })
    }

    /// All pairs of the boxes as they are now, and which of them are new or gone.
    fn find(parts: &mut Parts<'_, I>, shared: bool, means: StepContext<'_>) -> Result<(), Error> {
        let moved = parts.moved.count();

        let mut route = step::choose(parts, moved);
        if cfg!(feature = "large") && parts.state.unproven != 0 {
            route = recount::prove(parts, route, moved, means);
        }
        step::refine_when_calm(parts, route.path, moved, means);
        if route.path == Path::Unchanged && parts.state.crept == 0 {
            Self::keep(parts, shared);
            return Ok(());
        }
        let (mut route, mut progress) = step::find(parts, route, means);
        if progress.pairs > parts.output.pairs.len() as u64 && parts.has_surplus() {
            (route, progress) = step::find_without_surplus(parts, means);
        }
        parts.state.record(moved, route, shared, &progress);
        means.executor.enter(Stage::Results);
        Self::conclude(parts, progress.pairs, means)
    }

    /// Ingest: the caller's boxes, where there are any, and who moved (paper, section III.B).
    fn take_in(
        parts: &mut Parts<'_, I>,
        bounds: Option<Boxes<'_>>,
        means: StepContext<'_>,
    ) -> Option<Rejected> {
        let bounds = bounds?;
        parts.state.touched = 1;
        means.executor.enter(Stage::Intake);
        let intake = ingest(parts, &bounds, means.kernels, means.executor);
        parts.state.note(intake.told);
        if intake.rejected == 0 {
            return None;
        }
        let slot = intake.first_rejected;
        let first = Id::new(slot, parts.generations.at(slot as usize))?;
        Some(Rejected { first, count: intake.rejected })
    }

    /// Nothing has changed: the result stays as it is, with nothing found or lost.
    fn keep(parts: &mut Parts<'_, I>, shared: bool) {
        let leaves = parts.state.leaves();
        let progress = crate::memory::state::Progress { leaves, ..Default::default() };
        parts.state.record(0, Route::UNCHANGED, shared, &progress);
        parts.state.found = 0;
        parts.state.lost = 0;
        parts.state.touched = 0;
    }

    /// Exact test and events, if all pairs are there; else the prefix that fits, and everything stays as it was for
    /// the step that will be complete.
    fn conclude(parts: &mut Parts<'_, I>, pairs: u64, means: StepContext<'_>) -> Result<(), Error> {
        let fitting = pairs.min(parts.output.pairs.len() as u64);
        let complete = pairs == fitting;
        results::sort_out(parts, fitting as usize, complete, means);
        parts.state.complete = u8::from(complete);
        if !complete {
            return Err(Error::PairsFull { needed: pairs });
        }
        results::remember(parts, means);
        parts.moved.clear();
        parts.state.crept = 0;
        parts.state.outran = 0;
        parts.filters.changed.clear();
        parts.state.entered = 0;
        parts.state.touched = 0;
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
        Parts::init(slab, config).map(|parts| Self { parts })
    }

    /// Opens the world that [`new_in`](Self::new_in) made in `slab`, with all that it holds. O(1).
    ///
    /// # Errors
    /// [`Error::NotAWorld`] where there is none of this index width, and the errors of `new_in`.
    pub fn open(slab: &'m mut [u8]) -> Result<Self, Error> {
        Parts::open(slab).map(|parts| Self { parts })
    }

    /// What the world was made for.
    #[must_use]
    pub fn config(&self) -> Config {
        // The state of an opened world is known to be good.
        self.parts.state.config(size_of::<I>()).unwrap_or(Config::new(crate::Capacity::for_objects(0)))
    }

    /// Living objects.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.parts.state.live
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
        let lives = slot < self.parts.state.slots && !self.parts.boxes.now.at(slot as usize).is_empty();
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

/// Objects. None of these calls changes the result of the last step; the next step sees all of them at once.
impl<I: Index> World<'_, I> {
    /// Adds an object. In a world that has not lost any, slots are given out in ascending order. O(1).
    ///
    /// # Errors
    /// [`Error::BadBox`] or [`Error::ObjectsFull`].
    pub fn insert(&mut self, aabb: Aabb) -> Result<Id, Error> {
        let bounds = KeyBox::from_aabb(&aabb).ok_or(Error::BadBox { index: 0 })?;
        self.enter(bounds)
    }

    /// Gives an object another box. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`] or [`Error::BadBox`]; the object keeps its box.
    pub fn set_aabb(&mut self, id: Id, aabb: Aabb) -> Result<(), Error> {
        self.slot_of(id)?;
        let bounds = KeyBox::from_aabb(&aabb).ok_or(Error::BadBox { index: 0 })?;
        self.accept(&[id], [bounds].into_iter());
        Ok(())
    }

    /// Sets how far an object may move before it counts as moved, in place of the world's margin. It counts as moved once.
    /// Does nothing in a world without margins. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], or [`Error::BadMargin`] where `length` is negative or not finite.
    pub fn set_margin(&mut self, id: Id, length: f32) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        crate::Margin::length(length).check()?;
        if let Some(margin) = self.parts.boxes.margins.get_mut(slot) {
            *margin = length;
            let bounds = self.parts.boxes.now.at(slot);
            self.parts.objects().anchor(slot, bounds, length);
            self.parts.state.touched = 1;
        }
        Ok(())
    }

    /// Removes an object. Its id is stale from now on; its pairs are lost at the next step. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    pub fn remove(&mut self, id: Id) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        self.leave(slot);
        Ok(())
    }

    /// Adds objects, all or none. Their ids go to `ids`. O(n).
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] where `ids` is shorter than `boxes`, [`Error::BadBox`] or [`Error::ObjectsFull`].
    pub fn insert_many(&mut self, boxes: Boxes<'_>, ids: &mut [Option<Id>]) -> Result<(), Error> {
        if ids.len() < boxes.len() {
            return Err(Error::LengthMismatch { needed: boxes.len() });
        }
        let needed = u64::from(self.len()) + boxes.len() as u64;
        if needed > self.parts.sizes.objects as u64 {
            return Err(Error::ObjectsFull { needed });
        }
        check_all(&boxes)?;
        for (index, id) in ids.iter_mut().enumerate().take(boxes.len()) {
            *id = match boxes.get(index).as_ref().and_then(KeyBox::from_aabb) {
                Some(bounds) => Some(self.enter(bounds)?),
                None => None,
            };
        }
        Ok(())
    }

    /// Gives objects other boxes, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] where there are not as many boxes as ids, [`Error::StaleId`] or [`Error::BadBox`].
    pub fn update_many(&mut self, ids: &[Id], boxes: Boxes<'_>) -> Result<(), Error> {
        if ids.len() != boxes.len() {
            return Err(Error::LengthMismatch { needed: ids.len() });
        }
        for id in ids {
            self.slot_of(*id)?;
        }
        check_all(&boxes)?;
        let bounds = |index| boxes.get(index).as_ref().and_then(KeyBox::from_aabb);
        self.accept(ids, (0..boxes.len()).filter_map(bounds));
        Ok(())
    }

    /// Removes objects, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`], also where an id comes twice.
    pub fn remove_many(&mut self, ids: &[Id]) -> Result<(), Error> {
        for id in ids {
            self.slot_of(*id)?;
        }
        // All of them name living objects, so that only an id that comes twice meets the mark of its first time.
        const MARK: u32 = 1 << 31;
        let toggle = |world: &mut Self, id: &Id| {
            let generation = world.parts.generations.at(id.slot() as usize);
            world.parts.generations.put(id.slot() as usize, generation ^ MARK);
        };
        for (index, id) in ids.iter().enumerate() {
            if let Err(error) = self.slot_of(*id) {
                ids.iter().take(index).for_each(|id| toggle(self, id));
                return Err(error);
            }
            toggle(self, id);
        }
        for id in ids {
            toggle(self, id);
            self.leave(id.slot() as usize);
        }
        Ok(())
    }

    fn enter(&mut self, bounds: KeyBox) -> Result<Id, Error> {
        let parts = &mut self.parts;
        let free = parts.state.free;
        let slot = if free > 0 { free - 1 } else { parts.state.slots };
        if slot as usize >= parts.sizes.objects {
            return Err(Error::ObjectsFull { needed: u64::from(parts.state.live) + 1 });
        }
        let at = slot as usize;
        if free > 0 {
            parts.state.free = parts.boxes.now.at(at).next_free();
        } else {
            parts.state.slots += 1;
        }
        parts.state.live += 1;
        // After four billion objects in one slot an old id could match again; skipping zero keeps ids non-null.
        let generation = parts.generations.at(at).wrapping_add(1).max(1);
        parts.generations.put(at, generation);
        if let (Some(margin), Some(length)) = (parts.state.margin(), parts.boxes.margins.get_mut(at)) {
            *length = margin_length(&margin, &bounds);
        }
        parts.objects().enter(at, bounds);
        if let Some(filter) = parts.filters.of.get_mut(at) {
            *filter = Filter::ALL;
        }
        // An object that had the slot since the last step is forgotten: its pairs are lost either way.
        if let Some(before) = parts.boxes.before.get_mut(at) {
            *before = KeyBox::EMPTY;
        }
        parts.state.entered = 1;
        parts.state.touched = 1;
        links::append(parts, slot);
        // The generation is not zero.
        Id::new(slot, generation).ok_or(Error::NotAWorld)
    }

    /// Gives living objects other boxes.
    fn accept(&mut self, ids: &[Id], boxes: impl Iterator<Item = KeyBox>) {
        let parts = &mut self.parts;
        for id in ids {
            parts.state.touched = 1;
            bits::clear(parts.resting, id.slot() as usize);
        }
        let mut objects = parts.objects();
        for (id, bounds) in ids.iter().zip(boxes) {
            objects.accept(id.slot() as usize, bounds);
        }
        let told = objects.fat.told;
        parts.state.note(told);
    }

    fn leave(&mut self, slot: usize) {
        let next = self.parts.state.free;
        self.parts.state.touched = 1;
        bits::clear(self.parts.resting, slot);
        self.parts.objects().leave(slot, next);
        self.parts.state.free = slot as u32 + 1;
        self.parts.state.live -= 1;
    }
}

fn check_all(boxes: &Boxes<'_>) -> Result<(), Error> {
    let bad = (0..boxes.len()).find(|&index| boxes.get(index).as_ref().and_then(KeyBox::from_aabb).is_none());
    match bad {
        Some(index) => Err(Error::BadBox { index: index as u32 }),
        None => Ok(()),
    }
}

/// Stepping and results.
impl<I: Index> World<'_, I> {
    /// Finds all overlapping pairs of the boxes as they are now.
    ///
    /// Expected O(n + pairs) where objects move, O(movers + pairs) where few do; see [`Stats::path`].
    ///
    /// # Errors
    /// [`Error::PairsFull`], or [`Error::InvariantBroken`], which says that this library is at fault.
    pub fn step(&mut self, kernels: Kernels, executor: &dyn Executor) -> Result<Step<'_, I>, Error> {
        self.advance(None, self.means(kernels, executor, None))
    }

    /// As [`step`](Self::step), after giving every object the box that stands at its slot in `bounds`, the caller's own
    /// array: one pass over it, no copy. What stands at the slots of no object does not matter; objects beyond its end
    /// keep their boxes, and so do those whose new box is refused (see [`Step::rejected`]).
    ///
    /// # Errors
    /// [`Error::PairsFull`]. It says nothing of refused boxes; a step over the same array tells of them again.
    pub fn step_over(
        &mut self,
        bounds: Boxes<'_>,
        kernels: Kernels,
        executor: &dyn Executor,
    ) -> Result<Step<'_, I>, Error> {
        self.advance(Some(bounds), self.means(kernels, executor, None))
    }

    /// As [`step_over`](Self::step_over), or where there are no `bounds` as [`step`](Self::step), with a rule that decides
    /// about the pairs that the filters let through. A world that has a rule in one step should have it in all.
    ///
    /// # Errors
    /// [`Error::PairsFull`], or [`Error::NoFilters`] in a world without filters.
    pub fn step_with_rule(
        &mut self,
        bounds: Option<Boxes<'_>>,
        rule: &Rule<'_>,
        kernels: Kernels,
        executor: &dyn Executor,
    ) -> Result<Step<'_, I>, Error> {
        if self.parts.filters.classes.is_empty() {
            return Err(Error::NoFilters);
        }
        self.advance(bounds, self.means(kernels, executor, Some(rule)))
    }

    fn means<'e>(
        &self,
        kernels: Kernels,
        executor: &'e dyn Executor,
        rule: Option<&'e Rule<'e>>,
    ) -> StepContext<'e> {
        let sizes = &self.parts.sizes;
        StepContext { kernels, executor, rule, workers: sizes.workers, small: sizes.is_small() }
    }

    /// The overlapping pairs of the last step, each once, the lower slot first; in no order that means anything, but
    /// always the same for the same calls. After [`Error::PairsFull`] those that fitted.
    #[must_use]
    pub fn pairs(&self) -> &[Pair<I>] {
        let result = self.parts.state.result();
        self.parts.output.pairs.span(result.start, result.len())
    }

    /// With events: the pairs that the last step has and the complete step before it had not. A pair of other objects in
    /// the same slots counts as another pair.
    #[must_use]
    pub fn found(&self) -> &[Pair<I>] {
        let found = self.parts.state.found as usize;
        self.parts.output.pairs.span(self.parts.state.result().end - found, found)
    }

    /// With events: the pairs that the complete step before the last one had and the last one has not. A removed object's
    /// slot may hold a new one by now.
    #[must_use]
    pub fn lost(&self) -> &[Pair<I>] {
        self.parts.output.previous.span(0, self.parts.state.lost as usize)
    }

    /// What the last step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.parts.state.stats()
    }
}

/// The result of a step, and a view of the world as it is after it.
pub struct Step<'w, I: Index = u32> {
    world: &'w World<'w, I>,
    rejected: Option<Rejected>,
}

impl<'w, I: Index> Step<'w, I> {
    /// See [`World::pairs`].
    #[must_use]
    pub fn pairs(&self) -> &'w [Pair<I>] {
        self.world.pairs()
    }

    /// See [`World::found`].
    #[must_use]
    pub fn found(&self) -> &'w [Pair<I>] {
        self.world.found()
    }

    /// See [`World::lost`].
    #[must_use]
    pub fn lost(&self) -> &'w [Pair<I>] {
        self.world.lost()
    }

    /// What the step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.world.stats()
    }

    /// The objects whose boxes in the bounds array were refused: NaN, or a minimum above its maximum. They have kept
    /// their last good boxes, and all others are as if nothing had been.
    #[must_use]
    pub fn rejected(&self) -> Option<Rejected> {
        self.rejected
    }

    /// How many of the pairs are there only for the margins: their boxes as given do not overlap. Always zero in
    /// [`Mode::Exact`](crate::Mode::Exact). Counted when it is asked for: O(pairs).
    #[must_use]
    pub fn surplus(&self) -> u64 {
        let now = &self.world.parts.boxes.now;
        let apart = |pair: &&Pair<I>| !now.at(pair[0].at()).overlaps(&now.at(pair[1].at()));
        self.pairs().iter().filter(apart).count() as u64
    }
}
