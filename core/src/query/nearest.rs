//! Which objects are nearest to a point.

use super::cast::{Hit, precedes};
use super::region::squared_distance;
use super::{MembersNear, key_above, key_below, parts_near};
use crate::access::Access;
use crate::error::Error;
use crate::geometry::aabb::widened;
use crate::geometry::key::{KeyBox, key};
use crate::id::{Id, Index};
use crate::simd::{Phase, Simd};
use crate::sort::{heapsort, sift_down, sift_up};
use crate::tree::home_of;
use crate::tree::visit::{Probe, Visit};
use crate::world::World;

/// What is nearest to a point.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let ids = [world.insert(cube(2.0))?, world.insert(cube(5.0))?, world.insert(cube(9.0))?];
/// let mut hits = [None; 2];
/// assert_eq!(world.nearest([0.0; 3], &mut hits)?, 2);
/// assert_eq!(hits.map(|hit| hit.map(|hit| (hit.id, hit.distance))), [Some((ids[0], 2.0)), Some((ids[1], 5.0))]);
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Writes the objects whose boxes are nearest to a point to `out`, as many as it takes, the nearest first, equally near
    /// ones by ascending slot. Returns how many there are: less than `out` takes only if there are no more objects.
    ///
    /// # Errors
    /// [`Error::BadQuery`] where the point is not finite.
    #[cfg_attr(debug_assertions, inline(never))]
    pub fn nearest(&self, point: [f32; 3], out: &mut [Option<Hit>]) -> Result<usize, Error> {
        self.nearest_of(point, out, None)
    }

    /// The same of the objects that may answer.
    pub(super) fn nearest_of(
        &self,
        point: [f32; 3],
        out: &mut [Option<Hit>],
        condition: Option<&dyn Fn(Id) -> bool>,
    ) -> Result<usize, Error> {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Error::BadQuery { index: 0 });
        }
        Ok(self.kernels.run(Nearest { world: self, point, out, condition }))
    }
}

/// The nearest objects so far: a heap with the farthest one of them at its root.
struct Best<'o> {
    heap: &'o mut [Option<Hit>],
    count: usize,
}

impl Best<'_> {
    /// Beyond which squared distance nothing matters any more.
    fn limit(&self) -> f64 {
        match self.heap.first() {
            Some(Some(farthest)) if self.count == self.heap.len() => farthest.distance,
            Some(_) => f64::INFINITY,
            None => f64::NEG_INFINITY,
        }
    }

    fn offer(&mut self, hit: Hit) {
        if self.count < self.heap.len() {
            self.heap.put(self.count, Some(hit));
            self.count += 1;
            sift_up(self.heap.span_mut(0, self.count), &precedes);
        } else if precedes(Some(hit), self.heap.first().copied().flatten()) {
            self.heap.put(0, Some(hit));
            sift_down(self.heap, 0, &precedes);
        }
    }
}

/// A point meets the nodes that are near enough, by their squared distance.
struct Around<'p> {
    point: &'p [f32; 3],
    /// Beyond which squared distance nothing matters any more.
    limit: f64,
}

impl Probe for Around<'_> {
    /// NaN of a node without members.
    type When = f64;

    const AT_ONCE: f64 = 0.0;

    #[inline(always)]
    fn meet<S: Simd>(&self, _: S, nodes: [&KeyBox; 2]) -> [f64; 2] {
        nodes.map(|node| if node.is_empty() { f64::NAN } else { squared_distance(self.point, node) })
    }

    #[inline(always)]
    fn is_met(&self, squared: f64) -> bool {
        squared <= self.limit
    }

    #[inline(always)]
    fn is_right_first(&self, left: f64, right: f64) -> bool {
        right < left || left.is_nan()
    }
}

struct Nearest<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    point: [f32; 3],
    out: &'q mut [Option<Hit>],
    /// Asked by reference, if there is one: the search is compiled once.
    condition: Option<&'q dyn Fn(Id) -> bool>,
}

impl<I: Index> Phase for Nearest<'_, '_, I> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { world, point, out, condition } = self;
        let parts = &world.parts;
        let mut best = Best { heap: out, count: 0 };
        let offer = |best: &mut Best<'_>, slot: usize| {
            let squared = squared_distance(&point, KeyBox::of(parts.boxes.now, slot));
            if let (true, Some(id)) = (squared <= best.limit(), world.id_of(slot))
                && condition.is_none_or(|condition| condition(id))
            {
                best.offer(Hit { id, distance: squared });
            }
        };
        if world.has_others() {
            for slot in world.others() {
                offer(&mut best, slot);
            }
        }
        if world.has_tree() {
            let sub_levels = parts.state.tree.sub_levels();
            let home = home_of(parts.tree.planes, parts.state, &point.map(key));
            let start = home >> sub_levels;
            // The part around the point first: the others are hardly near enough then.
            let around_point = 1u32 << (home - (start << sub_levels));
            let probe = Around { point: &point, limit: best.limit() };
            let mut visit = Visit::new(simd, parts.tree.nodes, parts.state.tree.depth, start, probe);
            while let Some(whole) = visit.next(simd) {
                let first = if whole == start { around_point } else { 0 };
                for some in [first, !first].into_iter().filter(|some| *some != 0) {
                    let (record, near) = parts_near(simd, parts, whole, &around(&point, best.limit()));
                    let mut mask = near & some;
                    while mask != 0 {
                        let leaf = (whole << sub_levels) + mask.trailing_zeros() as usize;
                        mask &= mask - 1;
                        let mut members = MembersNear::new(simd, parts, leaf, record);
                        while let Some((slot, _)) = members.next() {
                            offer(&mut best, slot);
                        }
                    }
                }
                visit.probe.limit = best.limit();
            }
        }
        let found = best.heap.span_mut(0, best.count);
        heapsort(found, precedes);
        for hit in found.iter_mut().flatten() {
            hit.distance = libm::sqrt(hit.distance);
        }
        found.len()
    }
}

/// What overlaps everything up to a squared distance from a point: a little larger than need be.
fn around(point: &[f32; 3], squared: f64) -> KeyBox {
    let radius = libm::sqrt(squared) * (1.0 + 4.0 * f64::EPSILON);
    KeyBox {
        min: point.map(|x| key_below((widened(x) - radius).next_down())),
        max: point.map(|x| key_above((widened(x) + radius).next_up())),
    }
}
