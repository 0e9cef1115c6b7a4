//! Starts steps, with kernels, workers and a rule, and gives the result of the last one.

use super::World;
use crate::access::{Access, bits};
use crate::error::{Error, Rejected};
use crate::filter::Rule;
use crate::geometry::boxes::Boxes;
use crate::id::{Id, Index, Pair};
use crate::memory::state::PairState;
use crate::memory::stats::Stats;
use crate::pairs::results;
use crate::parallel::context::StepContext;
use crate::parallel::executor::{Executor, Serial};
use crate::simd::kernels::Kernels;
use core::ops::Deref;

/// A step on workers or with a rule: made by [`World::on`] and [`World::with_rule`], done by
/// [`step`](Self::step) or [`step_over`](Self::step_over). Errors are those of the world's methods, or
/// [`Error::NoFilters`] for a rule in a world without filters.
#[must_use = "does nothing until `step` or `step_over`"]
pub struct Stepper<'w, 'm, 'e, I: Index = u32> {
    world: &'w mut World<'m, I>,
    executor: &'e dyn Executor,
    rule: Option<&'e Rule<'e>>,
}

/// Steps.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Config, Error, InlineWorld, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_filters();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let teams = [1, 1, 2];
/// let mut boxes = [cube(0.0), cube(0.5), cube(1.25)];
/// for aabb in boxes {
///     world.insert(aabb)?; // slots are the positions in the array
/// }
/// assert_eq!(world.step()?.pairs().len(), 2);
///
/// // All boxes from the caller's array, and pairs of two teams alone.
/// boxes[0] = cube(0.75);
/// let rule = |a: u32, b: u32| teams[a as usize] != teams[b as usize];
/// let step = world.on(&Serial).with_rule(&rule).step_over(&boxes)?;
/// assert_eq!(step.pairs().len(), 2);
/// # world.on(&&Serial).step()?;
/// # Ok::<(), Error>(())
/// ```
impl<'m, I: Index> World<'m, I> {
    /// Finds all overlapping pairs of the boxes as they are now, on this thread.
    ///
    /// O(n + pairs) expected, O(movers + pairs) where few move; see [`Stats::path`](crate::Stats::path).
    ///
    /// If a [rule](Self::with_rule) or an [executor](Self::on) panics, the world stays valid and has no
    /// pairs; each box of [`step_over`](Self::step_over) may have been taken in or not. The next step finds
    /// all pairs anew, and its events are relative to the last complete step. A world that was in a step when
    /// its process ended finds all pairs anew, too, when it is [opened](Self::open); the first events may be
    /// wrong then, and a box that was being written is until it is given again.
    ///
    /// # Errors
    /// [`Error::PairsFull`], or [`Error::InvariantBroken`], which says that this library is at fault.
    #[doc(alias("update", "refit", "rebuild", "optimize"))]
    pub fn step(&mut self) -> Result<Step<'_, I>, Error> {
        self.on(&Serial).step()
    }

    /// As [`step`](Self::step), after giving every object the box at its slot in `bounds`, the caller's own
    /// array: one pass, no copy. Boxes at slots without an object do not matter. Objects beyond the end of
    /// the array keep their boxes, and so do objects whose new box is refused (see [`Step::rejected`]).
    ///
    /// # Errors
    /// [`Error::PairsFull`]. It does not tell about refused boxes; another step over the same array does.
    pub fn step_over<'b>(&mut self, bounds: impl Into<Boxes<'b>>) -> Result<Step<'_, I>, Error> {
        self.on(&Serial).step_over(bounds)
    }

    /// Steps on the workers of a job system: `world.on(&executor).step()`. The result is the same, byte for
    /// byte. At most [`Config::workers`](crate::Config::workers) work at once.
    pub fn on<'w, 'e>(&'w mut self, executor: &'e dyn Executor) -> Stepper<'w, 'm, 'e, I> {
        Stepper { world: self, executor, rule: None }
    }

    /// Steps with a rule that decides the pairs that the filters let through:
    /// `world.with_rule(&rule).step()`. If a world has a rule in one step, it should have the same in all.
    pub fn with_rule<'w, 'e>(&'w mut self, rule: &'e Rule<'e>) -> Stepper<'w, 'm, 'e, I> {
        Stepper { world: self, executor: &Serial, rule: Some(rule) }
    }

    /// Brings the tree up to date for queries without a look for pairs: a world that is only asked needs no
    /// step. Pairs and events stay as they are, also in the next step. Without this, queries look one by one
    /// at the objects that have changed since the last step, and at all before the first. Each call divides
    /// some leaves for queries, as a calm step does, until all are divided. Does nothing in worlds without a
    /// tree. O(objects that have changed + n/64), or O(n) where these are many.
    ///
    /// # Errors
    /// [`Error::InvariantBroken`], which says that this library is at fault.
    pub fn refresh(&mut self) -> Result<(), Error> {
        self.on(&Serial).refresh()
    }

    /// The kernels that steps and queries use.
    #[must_use]
    pub fn kernels(&self) -> Kernels {
        self.kernels
    }

    /// Makes steps and queries use other kernels than the best ones of this CPU. Only their speed differs.
    /// This belongs to the view: a world that is opened again uses the best ones.
    pub fn set_kernels(&mut self, kernels: Kernels) -> &mut Self {
        self.kernels = kernels;
        self
    }
}

impl<'w, 'm, 'e, I: Index> Stepper<'w, 'm, 'e, I> {
    /// The same on the workers of a job system.
    pub fn on(self, executor: &'e dyn Executor) -> Self {
        Self { executor, ..self }
    }

    /// The same with a rule.
    pub fn with_rule(self, rule: &'e Rule<'e>) -> Self {
        Self { rule: Some(rule), ..self }
    }

    /// See [`World::step`].
    pub fn step(self) -> Result<Step<'w, I>, Error> {
        let (world, context) = self.context()?;
        world.advance(None, context)
    }

    /// See [`World::step_over`].
    pub fn step_over<'b>(self, bounds: impl Into<Boxes<'b>>) -> Result<Step<'w, I>, Error> {
        let (world, context) = self.context()?;
        world.advance(Some(bounds.into()), context)
    }

    /// See [`World::refresh`]. No rule is asked.
    pub fn refresh(self) -> Result<(), Error> {
        let (world, context) = self.context()?;
        world.renew_tree(context)
    }

    fn context(self) -> Result<(&'w mut World<'m, I>, StepContext<'e>), Error> {
        let Self { world, executor, rule } = self;
        if rule.is_some() && world.parts.filters.classes.is_empty() {
            return Err(Error::NoFilters);
        }
        let (kernels, workers) = (world.kernels, world.parts.sizes.workers);
        let context = StepContext { kernels, executor, rule, workers };
        Ok((world, context))
    }
}

/// Results of the last step by slot, id and value, which stay until the next one.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events().with_values();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [a, b] = [world.insert(cube(0.0))?, world.insert(cube(0.5))?];
/// world.set_value(b, 4711)?;
/// world.step()?;
/// assert_eq!((world.found().len(), world.lost().len(), world.stats().pairs), (1, 0, 1));
///
/// world.remove(b)?;
/// let other = world.insert(cube(9.0))?;
/// assert_eq!(other.slot(), b.slot()); // so a pair of slots no longer says who it was
/// let step = world.step()?;
/// assert_eq!(step.lost(), [[0, 1]]);
/// assert!(step.lost_ids().eq([[a, b]]) && step.lost_values().eq([[0, 4711]]));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// The overlapping pairs of the last step, each once, the lower slot first. Their order means nothing,
    /// but the same calls give the same order. After [`Error::PairsFull`](crate::Error::PairsFull) these are
    /// the pairs that fit.
    #[doc(alias("contacts", "collisions", "overlaps"))]
    #[must_use]
    pub fn pairs(&self) -> &[Pair<I>] {
        self.parts.output.pairs.span(0, self.parts.state.pairs.reported as usize)
    }

    /// With events: the pairs of the last step that the complete step before it did not have. Other objects
    /// in the same slots are another pair.
    #[doc(alias("started", "begin_contact"))]
    #[must_use]
    pub fn found(&self) -> &[Pair<I>] {
        let PairState { reported, found, .. } = self.parts.state.pairs;
        self.parts.output.pairs.span((reported - found) as usize, found as usize)
    }

    /// With events: the pairs of the complete step before that the last one has not. The slot of a removed
    /// object may have a new object by now, and the same two slots may be found again: take lost pairs first.
    #[doc(alias("stopped", "ended", "end_contact"))]
    #[must_use]
    pub fn lost(&self) -> &[Pair<I>] {
        self.parts.output.previous.span(0, self.parts.state.pairs.lost as usize)
    }

    /// Puts the result of the last step into an order of its own: [`pairs`](Self::pairs) begin with the pairs
    /// that the complete step before had, in ascending order, and behind them the [found](Self::found) ones
    /// in ascending order; the [lost](Self::lost) ones ascend, too. Without events all pairs ascend. So
    /// worlds with the same objects in the same slots give the same bytes, whatever their room, their workers
    /// and their past are: as a solver needs that takes contacts in order and has to agree with another
    /// machine. After [`Error::PairsFull`](crate::Error::PairsFull) nothing is done.
    ///
    /// O(pairs log pairs), in place. The next step with few movers looks at all pairs once more, as pairs at
    /// rest are no longer set aside.
    pub fn sort_results(&mut self) {
        results::sort_results(&mut self.parts);
    }

    /// What the last step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.parts.state.stats()
    }

    /// The [`pairs`](Self::pairs) with at least one awake object: one that was not put to rest, or has been
    /// woken since. A narrow phase that keeps the contacts of resting objects needs only these. O(pairs).
    pub fn awake_pairs(&self) -> impl Iterator<Item = Pair<I>> {
        let rests = |slot: I| bits::test(self.parts.resting, slot.at());
        self.pairs().iter().copied().filter(move |[a, b]| !rests(*a) || !rests(*b))
    }

    /// [`pairs`](Self::pairs) by id, without pairs of objects that were removed since the step, also where
    /// another object has got the slot since: after [`Error::PairsFull`], since the last complete step.
    pub fn pair_ids(&self) -> impl Iterator<Item = [Id; 2]> {
        self.living(self.pairs())
    }

    /// [`found`](Self::found) by id, without pairs of objects that were removed since the step.
    pub fn found_ids(&self) -> impl Iterator<Item = [Id; 2]> {
        self.living(self.found())
    }

    /// [`lost`](Self::lost) by the ids of the objects that were the pair, also if they are gone and others
    /// have their slots. Ask before you insert an object: until then these are the ids of the last two steps.
    pub fn lost_ids(&self) -> impl Iterator<Item = [Id; 2]> {
        both(self.lost().iter().copied(), |slot| {
            let generations =
                if self.is_reused(slot) { &self.parts.former.generations } else { &self.parts.generations };
            Id::new(slot.slot(), generations.at(slot.at()))
        })
    }

    /// [`pairs`](Self::pairs) by value, without pairs of objects that were removed since the step. None in a
    /// world without values.
    pub fn pair_values(&self) -> impl Iterator<Item = [u64; 2]> {
        both(self.pair_ids(), |id| self.value(id))
    }

    /// [`found`](Self::found) by value, without pairs of objects that were removed since the step.
    pub fn found_values(&self) -> impl Iterator<Item = [u64; 2]> {
        both(self.found_ids(), |id| self.value(id))
    }

    /// [`lost`](Self::lost) by the values that the objects of the pair had last, as [`lost_ids`](Self::lost_ids).
    pub fn lost_values(&self) -> impl Iterator<Item = [u64; 2]> {
        let values = &self.parts.values;
        both(self.lost().iter().copied(), |slot| {
            let values = if self.is_reused(slot) { &values.former } else { &values.of };
            values.get(slot.at()).copied()
        })
    }

    fn living(&self, pairs: &[Pair<I>]) -> impl Iterator<Item = [Id; 2]> {
        let some_are_new = self.parts.state.objects.has_inserted == 1;
        both(pairs.iter().copied(), move |slot| {
            if some_are_new && self.is_reused(slot) { None } else { self.id_at(slot.slot()) }
        })
    }

    /// Whether another object has got a slot since the complete step before the last one.
    fn is_reused(&self, slot: I) -> bool {
        bits::test(self.parts.former.reused.words, slot.at())
    }
}

/// The pairs of which both are something.
fn both<A, B>(
    pairs: impl Iterator<Item = [A; 2]>,
    of: impl Fn(A) -> Option<B>,
) -> impl Iterator<Item = [B; 2]> {
    pairs.filter_map(move |pair| {
        let [a, b] = pair.map(&of);
        Some([a?, b?])
    })
}

/// The result of a step, and a view of the world as it is after it.
#[derive(Debug)]
pub struct Step<'w, I: Index = u32> {
    pub(super) world: &'w World<'w, I>,
    pub(super) rejected: Option<Rejected>,
}

/// Its results are the world's.
impl<'w, I: Index> Deref for Step<'w, I> {
    type Target = World<'w, I>;

    fn deref(&self) -> &World<'w, I> {
        self.world
    }
}

impl<'w, I: Index> Step<'w, I> {
    /// The world after the step, for longer than the step is there.
    #[must_use]
    pub fn world(&self) -> &'w World<'w, I> {
        self.world
    }

    /// The objects whose boxes in the caller's array were refused: NaN, or a minimum above its maximum. They
    /// keep their last good boxes; all other objects are not affected.
    #[must_use]
    pub fn rejected(&self) -> Option<Rejected> {
        self.rejected
    }

    /// How many pairs there are only because of margins: their boxes as given do not overlap. Always zero in
    /// [`Mode::Exact`](crate::Mode::Exact). Each call counts: O(pairs).
    #[must_use]
    pub fn surplus(&self) -> u64 {
        let now = self.parts.boxes.given();
        let apart = |pair: &&Pair<I>| !now.at(pair[0].at()).overlaps(&now.at(pair[1].at()));
        self.pairs().iter().filter(apart).count() as u64
    }
}
