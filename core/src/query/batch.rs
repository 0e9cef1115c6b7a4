//! Answers many queries in one call, on the caller's workers.

use super::{Cast, Hit, Region};
use crate::access::Access;
use crate::error::Error;
use crate::id::{Id, Index};
use crate::memory::limits::{QUERIES_PER_BLOCK, QUERY_WORKERS};
use crate::parallel::block_queue::{BlockQueue, Chunks};
use crate::parallel::executor::{self, Executor};
use crate::world::World;

/// A condition that all workers may ask.
type Shared<'c> = &'c (dyn Fn(Id) -> bool + Sync);

/// Many queries at once, on the workers of a job system.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
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
    /// [`Error::BadQuery`], or [`Error::LengthMismatch`] if `out` is shorter than `casts`. Nothing is written then.
    pub fn first_hits(
        &self,
        casts: &[Cast],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        self.first_hits_of(casts, executor, out, None)
    }

    /// The same of the objects that may answer.
    pub(super) fn first_hits_of(
        &self,
        casts: &[Cast],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
        condition: Option<Shared<'_>>,
    ) -> Result<(), Error> {
        let short = Error::LengthMismatch { needed: casts.len(), given: out.len() };
        let out = out.get_mut(..casts.len()).ok_or(short)?;
        check(casts, Cast::is_valid)?;
        let queue = BlockQueue::new(Chunks::new(out, QUERIES_PER_BLOCK));
        executor::run(executor, QUERY_WORKERS, casts.len().div_ceil(QUERIES_PER_BLOCK), &|| {
            while let Some((block, out)) = queue.claim() {
                for (cast, out) in casts.span(block * QUERIES_PER_BLOCK, out.len()).iter().zip(out) {
                    let first = match condition {
                        Some(condition) => self.first_hit_of(cast, condition as &dyn Fn(Id) -> bool),
                        None => self.first_hit(cast),
                    };
                    // The casts are valid.
                    *out = first.ok().flatten();
                }
            }
        });
        Ok(())
    }

    /// [`nearest`](Self::nearest) of each point, in their order. Each gets an equal share of `out`, whose rest is `None` where there
    /// are fewer objects.
    ///
    /// # Errors
    /// [`Error::BadQuery`] for the first point that is not finite. Nothing is written then.
    pub fn nearest_many(
        &self,
        points: &[[f32; 3]],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
    ) -> Result<(), Error> {
        self.nearest_many_of(points, executor, out, None)
    }

    /// The same of the objects that may answer.
    pub(super) fn nearest_many_of(
        &self,
        points: &[[f32; 3]],
        executor: &dyn Executor,
        out: &mut [Option<Hit>],
        condition: Option<Shared<'_>>,
    ) -> Result<(), Error> {
        check(points, |point| point.iter().all(|x| x.is_finite()))?;
        out.fill(None);
        let share = out.len() / points.len().max(1);
        let out = out.span_mut(0, share * points.len());
        let queue = BlockQueue::new(Chunks::new(out, QUERIES_PER_BLOCK * share));
        executor::run(executor, QUERY_WORKERS, points.len().div_ceil(QUERIES_PER_BLOCK), &|| {
            while let Some((block, out)) = queue.claim() {
                let from = points.get(block * QUERIES_PER_BLOCK..).unwrap_or_default();
                for (point, out) in from.iter().zip(out.chunks_mut(share.max(1))) {
                    let condition = condition.map(|condition| condition as &dyn Fn(Id) -> bool);
                    // The points are valid.
                    let _ = self.nearest_of(*point, out, condition);
                }
            }
        });
        Ok(())
    }

    /// [`overlaps`](Self::overlaps) of each region. Each gets an equal share of `out`; `counts` tells how many
    /// objects overlap each region.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::LengthMismatch`] if `counts` is shorter than `regions`; nothing is written
    /// then. [`Error::OutputFull`] if a region has more objects than its share holds: the counts are right, and so
    /// are the shares that suffice.
    pub fn overlaps_many(
        &self,
        regions: &[Region],
        executor: &dyn Executor,
        out: &mut [Option<Id>],
        counts: &mut [u32],
    ) -> Result<(), Error> {
        self.overlaps_many_of(regions, executor, out, counts, None)
    }

    /// The same of the objects that may answer.
    pub(super) fn overlaps_many_of(
        &self,
        regions: &[Region],
        executor: &dyn Executor,
        out: &mut [Option<Id>],
        counts: &mut [u32],
        condition: Option<Shared<'_>>,
    ) -> Result<(), Error> {
        let short = Error::LengthMismatch { needed: regions.len(), given: counts.len() };
        let counts = counts.get_mut(..regions.len()).ok_or(short)?;
        check(regions, Region::is_valid)?;
        let share = out.len() / regions.len().max(1);
        let queue = BlockQueue::new((
            Chunks::optional(out.span_mut(0, share * regions.len()), QUERIES_PER_BLOCK * share),
            Chunks::new(counts, QUERIES_PER_BLOCK),
        ));
        executor::run(executor, QUERY_WORKERS, regions.len().div_ceil(QUERIES_PER_BLOCK), &|| {
            while let Some((block, (out, counts))) = queue.claim() {
                for (at, count) in counts.iter_mut().enumerate() {
                    let Some(region) = regions.get(block * QUERIES_PER_BLOCK + at) else { continue };
                    let out = out.get_mut(at * share..(at + 1) * share).unwrap_or_default();
                    let answered = match condition {
                        Some(condition) => self.overlaps_of(region, out, condition as &dyn Fn(Id) -> bool),
                        None => self.overlaps(region, out),
                    };
                    *count = match answered {
                        Ok(count) => count as u32,
                        Err(Error::OutputFull { needed, .. }) => needed as u32,
                        // The regions are valid.
                        Err(_) => 0,
                    };
                }
            }
        });
        let most = counts.iter().copied().max().unwrap_or(0);
        if most as usize > share {
            let needed = u64::from(most) * regions.len() as u64;
            return Err(Error::OutputFull { needed, room: out.len() });
        }
        Ok(())
    }
}

/// An error for the first query that is not valid.
fn check<T>(queries: &[T], is_valid: impl Fn(&T) -> bool) -> Result<(), Error> {
    match queries.iter().position(|query| !is_valid(query)) {
        Some(index) => Err(Error::BadQuery { index: index as u32 }),
        None => Ok(()),
    }
}
