//! Queries about some of the objects alone, and many queries in one call, on the caller's workers.

use super::{Cast, Hit, Region};
use crate::access::Access;
use crate::error::Error;
use crate::id::{Id, Index};
use crate::memory::limits::{QUERIES_PER_BLOCK, QUERY_WORKERS};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Executor;
use crate::simd::kernels::Kernels;
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
    /// filters ([`meets`](Self::meets)), by what they are; or many queries at once, where `|_| true` asks
    /// about all. The condition is asked in any order, only about objects that the query has found. It has to
    /// answer the same for the same object. Visitors
    /// ([`visit_overlaps`](Self::visit_overlaps), [`visit_hits`](Self::visit_hits),
    /// [`visit_nearest`](Self::visit_nearest)) need no condition, as they can refuse what they see.
    ///
    /// ```
    /// # use trisap_core::{Aabb, Capacity, Cast, Config, Error, Filter, InlineWorld, layout};
    /// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_filters();
    /// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
    /// # let mut world = memory.init::<u16>(&CONFIG)?;
    /// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
    /// let [ball, other, wall] = [world.insert(cube(0.0))?, world.insert(cube(2.0))?, world.insert(cube(5.0))?];
    /// for (id, group) in [(ball, 1), (other, 1), (wall, 2)] {
    ///     world.set_filter(id, Filter::groups(group, u32::MAX))?;
    /// }
    /// let mut nearest = [None];
    /// world.among(|id| id != ball).nearest([0.0; 3], &mut nearest)?;
    /// assert_eq!(nearest[0].map(|hit| hit.id), Some(other));
    ///
    /// let sees_walls = Filter::groups(u32::MAX, 2);
    /// let ray = Cast::ray([0.5; 3], [1.0, 0.0, 0.0], 100.0);
    /// let hit = world.among(|id| world.meets(id, &sees_walls)).first_hit(&ray)?;
    /// assert_eq!(hit.map(|hit| hit.id), Some(wall));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn among<'w, C: Fn(Id) -> bool>(&'w self, condition: C) -> Among<'w, 'm, C, I> {
        Among { world: self, condition }
    }
}

impl<C: Fn(Id) -> bool, I: Index> Among<'_, '_, C, I> {
    /// Writes the answers of `ask` that may answer to `out`, in order. Returns how many there are. The
    /// visitor always says `on`.
    pub(super) fn collect<T: Copy, On: Copy>(
        &self,
        out: &mut [Option<T>],
        on: On,
        id: impl Fn(&T) -> Id,
        precedes: impl Fn(Option<T>, Option<T>) -> bool,
        ask: impl FnOnce(&mut dyn FnMut(T) -> On) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let mut count = 0;
        ask(&mut |answer| {
            if (self.condition)(id(&answer)) {
                if let Some(place) = out.get_mut(count) {
                    *place = Some(answer);
                }
                count += 1;
            }
            on
        })?;
        if count > out.len() {
            return Err(Error::OutputFull { needed: count as u64, room: out.len() });
        }
        heapsort(out.span_mut(0, count), precedes);
        Ok(count)
    }
}

/// Many queries at once, on the workers of a job system, which may ask the condition at the same time.
impl<C: Fn(Id) -> bool + Sync, I: Index> Among<'_, '_, C, I> {
    /// [`first_hit`](Self::first_hit) of each cast, in their order.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::LengthMismatch`]: `out` is shorter than `casts`. Nothing is written.
    pub fn first_hits(
        &self,
        casts: &[Cast],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        let short = Error::LengthMismatch { needed: casts.len(), given: out.len() };
        let out = out.get_mut(..casts.len()).ok_or(short)?;
        check(casts, Cast::is_valid)?;
        in_blocks(casts, executor, (out, QUERIES_PER_BLOCK), &mut [], &|casts, out, _| {
            // The casts are valid.
            out.iter_mut().zip(casts).for_each(|(out, cast)| *out = self.first_hit(cast).ok().flatten());
        });
        Ok(())
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
        check(points, |point| point.iter().all(|x| x.is_finite()))?;
        out.fill(None);
        let share = out.len() / points.len().max(1);
        in_blocks(points, executor, (out, share * QUERIES_PER_BLOCK), &mut [], &|points, out, _| {
            for (point, out) in points.iter().zip(out.chunks_mut(share.max(1))) {
                // The points are valid.
                let _ = self.nearest(*point, out);
            }
        });
        Ok(())
    }

    /// [`overlaps`](Self::overlaps) of each region, one after another in `out`: `ends` tells where the
    /// objects of each end and the next ones begin. The rest of `out` means nothing. Returns how many there
    /// are in all.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::LengthMismatch`]: `ends` is shorter than `regions`. Nothing is written.
    /// [`Error::OutputFull`], which says how many there are; `ends` is right then, `out` holds some of them.
    pub fn overlaps_many(
        &self,
        regions: &[Region],
        executor: &dyn Executor,
        out: &mut [Option<Id>],
        ends: &mut [usize],
    ) -> Result<usize, Error> {
        let short = Error::LengthMismatch { needed: regions.len(), given: ends.len() };
        let ends = ends.get_mut(..regions.len()).ok_or(short)?;
        check(regions, |region| region.bounds().is_some())?;
        // Each block writes to an equal share first, from which its objects move to their place.
        let share = out.len() / regions.len().div_ceil(QUERIES_PER_BLOCK).max(1);
        let mut total = 0usize;
        let is_packed = executor.workers() > 1 && {
            in_blocks(regions, executor, (out, share), ends, &|regions, out, ends| {
                self.pack(regions, out, ends)
            });
            ends.chunks_mut(QUERIES_PER_BLOCK).enumerate().all(|(block, ends)| {
                let count = ends.last().copied().unwrap_or(0);
                for k in 0..if count <= share { count } else { 0 } {
                    out.put(total + k, out.at(block * share + k));
                }
                ends.iter_mut().for_each(|end| *end = end.saturating_add(total));
                total = total.saturating_add(count);
                count <= share
            })
        };
        if !is_packed {
            self.pack(regions, out, ends);
            total = ends.last().copied().unwrap_or(0);
        }
        let full = Error::OutputFull { needed: total as u64, room: out.len() };
        if total > out.len() { Err(full) } else { Ok(total) }
    }

    /// Writes the objects of each region and where they end, one after another. Beyond the room it counts.
    fn pack(&self, regions: &[Region], out: &mut [Option<Id>], ends: &mut [usize]) {
        let mut end = 0usize;
        for (region, place) in regions.iter().zip(ends) {
            end = end.saturating_add(match self.overlaps(region, out.get_mut(end..).unwrap_or_default()) {
                Ok(count) => count,
                Err(Error::OutputFull { needed, .. }) => needed as usize,
                // The regions are valid.
                Err(_) => 0,
            });
            *place = end;
        }
    }
}

type Answer<'a, Q, T> = dyn Fn(&[Q], &mut [T], &mut [usize]) + Sync + 'a;

/// Answers blocks of queries on an executor's workers, each with so much room, and a number for each query
/// if there are any.
fn in_blocks<Q: Sync, T: Send>(
    queries: &[Q],
    executor: &dyn Executor,
    (out, room): (&mut [T], usize),
    numbers: &mut [usize],
    answer: &Answer<'_, Q, T>,
) {
    let blocks = queries.len().div_ceil(QUERIES_PER_BLOCK);
    let out = if room == 0 { &mut [] } else { out };
    let parts = (blocks, Chunks::optional(out, room), Chunks::optional(numbers, QUERIES_PER_BLOCK));
    let context = StepContext { kernels: Kernels::BASELINE, executor, rule: None, workers: QUERY_WORKERS };
    context.each(parts, |block, (_, out, numbers)| {
        answer(queries.chunks(QUERIES_PER_BLOCK).nth(block).unwrap_or_default(), out, numbers);
    });
}

/// An error for the first query that is not valid.
fn check<T>(queries: &[T], is_valid: impl Fn(&T) -> bool) -> Result<(), Error> {
    let bad = queries.iter().position(|query| !is_valid(query));
    bad.map_or(Ok(()), |index| Err(Error::BadQuery { index: index as u32 }))
}
