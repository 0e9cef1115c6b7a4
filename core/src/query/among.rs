//! Queries about some of the objects alone.

use super::{Cast, Hit, Region};
use crate::error::Error;
use crate::id::{Id, Index};
use crate::parallel::executor::Executor;
use crate::world::World;

/// Queries that only objects with a condition can answer: made by [`World::among`].
#[must_use = "does nothing until a query is asked"]
#[derive(Clone, Copy)]
pub struct Among<'w, 'm, C, I: Index = u32> {
    pub(super) world: &'w World<'m, I>,
    pub(super) condition: C,
}

/// Queries about some of the objects alone.
impl<'m, I: Index> World<'m, I> {
    /// Asks queries as if there were only the objects for which a condition holds: without one's own, by filters
    /// ([`meets`](Self::meets)), by what they are. The condition is asked in any order, only about objects that the
    /// query has found. It has to answer the same for the same object. Visitors
    /// ([`visit_overlaps`](Self::visit_overlaps), [`visit_hits`](Self::visit_hits),
    /// [`visit_nearest`](Self::visit_nearest)) need no condition, as they can refuse what they see.
    ///
    /// ```
    /// use trisap_core::{Aabb, Capacity, Cast, Config, Filter, InlineWorld, layout};
    ///
    /// const CONFIG: Config = Config::new(Capacity::for_objects(16)).with_filters();
    /// const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
    /// const WALLS: u32 = 1;
    /// const BALLS: u32 = 2;
    ///
    /// let mut memory = InlineWorld::<BYTES>::EMPTY;
    /// let mut world = memory.init::<u16>(&CONFIG)?;
    /// let ball = world.insert(Aabb::from_center([0.0; 3], [0.5; 3]))?;
    /// let other = world.insert(Aabb::from_center([2.0, 0.0, 0.0], [0.5; 3]))?;
    /// let wall = world.insert(Aabb::from_center([5.0, 0.0, 0.0], [0.5; 3]))?;
    /// world.set_filter(ball, Filter::groups(BALLS, u32::MAX))?;
    /// world.set_filter(other, Filter::groups(BALLS, u32::MAX))?;
    /// world.set_filter(wall, Filter::groups(WALLS, u32::MAX))?;
    ///
    /// let mut nearest = [None];
    /// world.among(|id| id != ball).nearest([0.0; 3], &mut nearest)?;
    /// assert_eq!(nearest[0].map(|hit| hit.id), Some(other));
    ///
    /// let sees = Filter::groups(u32::MAX, WALLS);
    /// let ray = Cast::ray([0.0; 3], [1.0, 0.0, 0.0], 100.0);
    /// let hit = world.among(|id| world.meets(id, &sees)).first_hit(&ray)?;
    /// assert_eq!(hit.map(|hit| hit.id), Some(wall));
    /// # Ok::<(), trisap_core::Error>(())
    /// ```
    pub fn among<'w, C: Fn(Id) -> bool>(&'w self, condition: C) -> Among<'w, 'm, C, I> {
        Among { world: self, condition }
    }
}

impl<C: Fn(Id) -> bool, I: Index> Among<'_, '_, C, I> {
    /// See [`World::overlaps`].
    ///
    /// # Errors
    /// Those of [`World::overlaps`].
    pub fn overlaps(&self, region: &Region, out: &mut [Option<Id>]) -> Result<usize, Error> {
        self.world.overlaps_of(region, out, self.condition())
    }

    /// See [`World::first_hit`].
    ///
    /// # Errors
    /// Those of [`World::first_hit`].
    pub fn first_hit(&self, cast: &Cast) -> Result<Option<Hit>, Error> {
        self.world.first_hit_of(cast, self.condition())
    }

    /// See [`World::hits`].
    ///
    /// # Errors
    /// Those of [`World::hits`].
    pub fn hits(&self, cast: &Cast, out: &mut [Option<Hit>]) -> Result<usize, Error> {
        self.world.hits_of(cast, out, self.condition())
    }

    /// See [`World::nearest`].
    ///
    /// # Errors
    /// Those of [`World::nearest`].
    pub fn nearest(&self, point: [f32; 3], out: &mut [Option<Hit>]) -> Result<usize, Error> {
        self.world.nearest_of(point, out, Some(self.condition()))
    }

    /// By reference, so that each search is compiled once for all conditions.
    fn condition(&self) -> &dyn Fn(Id) -> bool {
        &self.condition
    }
}

/// Many queries at once. Several workers may ask the condition at a time.
impl<C: Fn(Id) -> bool + Sync, I: Index> Among<'_, '_, C, I> {
    /// See [`World::first_hits`].
    ///
    /// # Errors
    /// Those of [`World::first_hits`].
    pub fn first_hits(
        &self,
        casts: &[Cast],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        self.world.first_hits_of(casts, executor, out, Some(&self.condition))
    }

    /// See [`World::nearest_many`].
    ///
    /// # Errors
    /// Those of [`World::nearest_many`].
    pub fn nearest_many(
        &self,
        points: &[[f32; 3]],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        self.world.nearest_many_of(points, executor, out, Some(&self.condition))
    }

    /// See [`World::overlaps_many`].
    ///
    /// # Errors
    /// Those of [`World::overlaps_many`].
    pub fn overlaps_many(
        &self,
        regions: &[Region],
        executor: &dyn Executor,
        out: &mut [Option<Id>],
        counts: &mut [u32],
    ) -> Result<(), Error> {
        self.world.overlaps_many_of(regions, executor, out, counts, Some(&self.condition))
    }
}
