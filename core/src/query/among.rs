//! Queries about some of the objects alone, and many queries in one call, on the caller's workers.

use super::{Cast, Hit, Region};
use crate::access::Access;
use crate::error::Error;
use crate::id::{Id, Index};
use crate::memory::limits::{QUERIES_PER_BLOCK, QUERY_WORKERS};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::each;
use crate::parallel::executor::Executor;
use crate::sort::heapsort;
use crate::world::World;

/// Queries that only objects with a condition can answer: made by [`World::among`]. Errors are those of the
/// queries about all objects.
#[must_use = "does nothing until a query is asked"]
#[derive(Clone, Copy)]
pub struct Among<'w, 'm, C, I: Index = u32> {
    pub(super) world: &'w World<'m, I>,
    pub(super) condition: C,
}

/// Queries about some of the objects alone.
impl<'m, I: Index> World<'m, I> {
    /// Asks queries as if there were only the objects for which a condition holds: without one's own, by
    /// filters ([`meets`](Self::meets)), by what they are. The condition is asked in any order, only about
    /// objects that the query has found. It has to answer the same for the same object. Visitors
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
    /// Writes the answers of `ask` that may answer to `out`, in order. Returns how many there are.
    pub(super) fn collect<T: Copy>(
        &self,
        out: &mut [Option<T>],
        id: impl Fn(&T) -> Id,
        precedes: impl Fn(Option<T>, Option<T>) -> bool,
        ask: impl FnOnce(&mut dyn FnMut(T)) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let mut count = 0;
        ask(&mut |answer| {
            if (self.condition)(id(&answer)) {
                if let Some(place) = out.get_mut(count) {
                    *place = Some(answer);
                }
                count += 1;
            }
        })?;
        if count > out.len() {
            return Err(Error::OutputFull { needed: count as u64, room: out.len() });
        }
        heapsort(out.span_mut(0, count), precedes);
        Ok(count)
    }
}

/// Many queries at once, on the workers of a job system.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Cast, Config, Error, InlineWorld, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let a = world.insert(cube(2.0))?;
/// let down = [0.0, 0.0, -1.0];
/// let rays = [Cast::ray([2.5, 0.5, 9.0], down, 100.0), Cast::ray([7.0, 0.5, 9.0], down, 100.0)];
/// let mut hits = [None; 2];
/// world.first_hits(&rays, &Serial, &mut hits)?;
/// assert_eq!(hits.map(|hit| hit.map(|hit| hit.id)), [Some(a), None]);
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// [`first_hit`](Self::first_hit) of each cast, in their order.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::LengthMismatch`] if `out` is shorter than `casts`; nothing is written.
    pub fn first_hits(
        &self,
        casts: &[Cast],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        self.among(|_| true).first_hits(casts, executor, out)
    }

    /// [`nearest`](Self::nearest) of each point, in their order. Each gets an equal share of `out`, whose
    /// rest is `None` where there are fewer objects.
    ///
    /// # Errors
    /// [`Error::BadQuery`] for the first point that is not finite. Nothing is written then.
    pub fn nearest_many(
        &self,
        points: &[[f32; 3]],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        self.among(|_| true).nearest_many(points, executor, out)
    }

    /// [`overlaps`](Self::overlaps) of each region. Each gets an equal share of `out`; `counts` tells how
    /// many objects overlap each region.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::LengthMismatch`] if `counts` is shorter than `regions`; nothing is
    /// written then. [`Error::OutputFull`] if a region has more objects than its share holds: the counts are
    /// right, and so are the shares that suffice.
    pub fn overlaps_many(
        &self,
        regions: &[Region],
        executor: &dyn Executor,
        out: &mut [Option<Id>],
        counts: &mut [u32],
    ) -> Result<(), Error> {
        self.among(|_| true).overlaps_many(regions, executor, out, counts)
    }
}

/// Many queries at once. Several workers may ask the condition at a time. Errors are as those of the world.
impl<C: Fn(Id) -> bool + Sync, I: Index> Among<'_, '_, C, I> {
    /// See [`World::first_hits`].
    pub fn first_hits(
        &self,
        casts: &[Cast],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        let short = Error::LengthMismatch { needed: casts.len(), given: out.len() };
        let out = out.get_mut(..casts.len()).ok_or(short)?;
        check(casts, Cast::is_valid)?;
        in_blocks(casts, executor, out, &mut [], &|cast, out| {
            // The casts are valid.
            out.fill(self.first_hit(cast).ok().flatten());
            0
        });
        Ok(())
    }

    /// See [`World::nearest_many`].
    pub fn nearest_many(
        &self,
        points: &[[f32; 3]],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        check(points, |point| point.iter().all(|x| x.is_finite()))?;
        out.fill(None);
        // The points are valid.
        in_blocks(points, executor, out, &mut [], &|point, out| {
            self.nearest(*point, out).unwrap_or(0) as u32
        });
        Ok(())
    }

    /// See [`World::overlaps_many`].
    pub fn overlaps_many(
        &self,
        regions: &[Region],
        executor: &dyn Executor,
        out: &mut [Option<Id>],
        counts: &mut [u32],
    ) -> Result<(), Error> {
        let short = Error::LengthMismatch { needed: regions.len(), given: counts.len() };
        let counts = counts.get_mut(..regions.len()).ok_or(short)?;
        check(regions, Region::is_valid)?;
        let share = out.len() / regions.len().max(1);
        in_blocks(regions, executor, out, counts, &|region, out| match self.overlaps(region, out) {
            Ok(count) => count as u32,
            Err(Error::OutputFull { needed, .. }) => needed as u32,
            // The regions are valid.
            Err(_) => 0,
        });
        let most = counts.iter().copied().max().unwrap_or(0);
        if most as usize > share {
            let needed = u64::from(most) * regions.len() as u64;
            return Err(Error::OutputFull { needed, room: out.len() });
        }
        Ok(())
    }
}

/// Answers queries on the workers of an executor. Each query gets an equal share of `out`, and tells a number
/// for `counts`, if that is not empty.
fn in_blocks<Q: Sync, T: Send>(
    queries: &[Q],
    executor: &dyn Executor,
    out: &mut [T],
    counts: &mut [u32],
    answer: &(dyn Fn(&Q, &mut [T]) -> u32 + Sync),
) {
    let (share, blocks) = (out.len() / queries.len().max(1), queries.len().div_ceil(QUERIES_PER_BLOCK));
    let parts = (
        blocks,
        Chunks::optional(out.span_mut(0, share * queries.len()), QUERIES_PER_BLOCK * share),
        Chunks::optional(counts, QUERIES_PER_BLOCK),
    );
    each(executor, QUERY_WORKERS, parts, |block, (_, out, counts)| {
        let queries = queries.get(block * QUERIES_PER_BLOCK..).unwrap_or_default();
        for (at, query) in queries.iter().enumerate().take(QUERIES_PER_BLOCK) {
            let told = answer(query, out.get_mut(at * share..(at + 1) * share).unwrap_or_default());
            if let Some(count) = counts.get_mut(at) {
                *count = told;
            }
        }
    });
}

/// An error for the first query that is not valid.
fn check<T>(queries: &[T], is_valid: impl Fn(&T) -> bool) -> Result<(), Error> {
    match queries.iter().position(|query| !is_valid(query)) {
        Some(index) => Err(Error::BadQuery { index: index as u32 }),
        None => Ok(()),
    }
}
