//! Starts steps, with kernels, workers and a rule.

use super::{Step, World};
use crate::error::Error;
use crate::filter::Rule;
use crate::geometry::boxes::Boxes;
use crate::id::Index;
use crate::parallel::context::StepContext;
use crate::parallel::executor::{Executor, Serial};
use crate::simd::kernels::Kernels;

/// A step on workers or with a rule: made by [`World::on`] and [`World::with_rule`], done by [`step`](Self::step) or
/// [`step_over`](Self::step_over).
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
    /// Expected O(n + pairs) where objects move, O(movers + pairs) where few do; see [`Stats::path`](crate::Stats::path).
    ///
    /// If a [rule](Self::with_rule) or an [executor](Self::on) panics, the world stays valid and has no
    /// pairs; each box of [`step_over`](Self::step_over) may have been taken in or not. The next step finds
    /// all pairs anew, and its events are relative to the last complete step. A world that was in a step when
    /// its process ended does the same when it is [opened](Self::open).
    ///
    /// # Errors
    /// [`Error::PairsFull`], or [`Error::InvariantBroken`], which says that this library is at fault.
    #[doc(alias("update", "refit", "rebuild", "optimize"))]
    pub fn step(&mut self) -> Result<Step<'_, I>, Error> {
        self.on(&Serial).step()
    }

    /// As [`step`](Self::step), after giving every object the box at its slot in `bounds`, the caller's own array:
    /// one pass, no copy. Boxes at slots without an object do not matter. Objects beyond the end of the array keep
    /// their boxes, and so do those whose new box is refused (see [`Step::rejected`]).
    ///
    /// # Errors
    /// [`Error::PairsFull`]. It does not tell about refused boxes; another step over the same array does.
    pub fn step_over<'b>(&mut self, bounds: impl Into<Boxes<'b>>) -> Result<Step<'_, I>, Error> {
        self.on(&Serial).step_over(bounds)
    }

    /// Steps on the workers of a job system: `world.on(&executor).step()`. The result is the same, byte for byte. At
    /// most [`Config::workers`](crate::Config::workers) work at once.
    pub fn on<'w, 'e>(&'w mut self, executor: &'e dyn Executor) -> Stepper<'w, 'm, 'e, I> {
        Stepper { world: self, executor, rule: None }
    }

    /// Steps with a rule that decides the pairs that the filters let through: `world.with_rule(&rule).step()`. If a
    /// world has a rule in one step, it should have the same in all.
    pub fn with_rule<'w, 'e>(&'w mut self, rule: &'e Rule<'e>) -> Stepper<'w, 'm, 'e, I> {
        Stepper { world: self, executor: &Serial, rule: Some(rule) }
    }

    /// Brings the tree up to date for queries, without a look for pairs: a world that is only asked needs no step. The pairs
    /// and events of the last step stay, and the next one has those that it would have had. Without this, queries look one by
    /// one at the objects that have changed since the last step, and at all before the first. Does nothing in worlds without a
    /// tree. O(objects that have changed), or O(n) where these are many.
    ///
    /// ```
    /// # use trisap_core::{Aabb, Capacity, Cast, Config, Error, InlineWorld, layout};
    /// # const CONFIG: Config = Config::new(Capacity::for_objects(1000).with_pairs(0));
    /// # let mut memory = Box::new(InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY);
    /// # let mut world = memory.init::<u16>(&CONFIG)?; // needs no room for pairs
    /// for k in 0..1000u16 {
    ///     world.insert(Aabb::from_center([f32::from(k); 3], [1.0; 3]))?;
    /// }
    /// world.refresh()?;
    /// let ray = Cast::ray([500.0, 500.0, 0.0], [0.0, 0.0, 1.0], f32::INFINITY);
    /// assert_eq!(world.first_hit(&ray)?.map(|hit| hit.distance), Some(498.0));
    /// # Ok::<(), Error>(())
    /// ```
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

    /// Makes steps and queries use other kernels than the best ones of this CPU. Only their speed differs. This
    /// belongs to the view: a world that is opened again uses the best ones.
    pub fn set_kernels(&mut self, kernels: Kernels) -> &mut Self {
        self.kernels = kernels;
        self
    }
}

impl<'w, 'e, I: Index> Stepper<'w, '_, 'e, I> {
    /// The same on the workers of a job system.
    pub fn on(self, executor: &'e dyn Executor) -> Self {
        Self { executor, ..self }
    }

    /// The same with a rule.
    pub fn with_rule(self, rule: &'e Rule<'e>) -> Self {
        Self { rule: Some(rule), ..self }
    }

    /// See [`World::step`].
    ///
    /// # Errors
    /// Those of [`World::step`], or [`Error::NoFilters`] for a rule in a world without filters.
    pub fn step(self) -> Result<Step<'w, I>, Error> {
        let (world, context) = self.context()?;
        world.advance(None, context)
    }

    /// See [`World::step_over`].
    ///
    /// # Errors
    /// Those of [`World::step_over`], or [`Error::NoFilters`] for a rule in a world without filters.
    pub fn step_over<'b>(self, bounds: impl Into<Boxes<'b>>) -> Result<Step<'w, I>, Error> {
        let (world, context) = self.context()?;
        world.advance(Some(bounds.into()), context)
    }

    /// See [`World::refresh`]. No rule is asked.
    ///
    /// # Errors
    /// Those of [`World::refresh`], or [`Error::NoFilters`] for a rule in a world without filters.
    pub fn refresh(self) -> Result<(), Error> {
        let (world, context) = self.context()?;
        world.renew_tree(context)
    }
}

impl<'w, 'm, 'e, I: Index> Stepper<'w, 'm, 'e, I> {
    fn context(self) -> Result<(&'w mut World<'m, I>, StepContext<'e>), Error> {
        let Self { world, executor, rule } = self;
        if rule.is_some() && world.parts.filters.classes.is_empty() {
            return Err(Error::NoFilters);
        }
        let sizes = &world.parts.sizes;
        let (workers, small) = (sizes.workers, sizes.is_small());
        let context = StepContext { kernels: world.kernels, executor, rule, workers, small };
        Ok((world, context))
    }
}
