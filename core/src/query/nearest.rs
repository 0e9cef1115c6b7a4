//! Which objects are nearest to a point.

use super::cast::{Hit, precedes};
use super::region::squared_distance;
use super::{MembersNear, is_current, key_above, key_below, parts_near};
use crate::access::Access;
use crate::error::Error;
use crate::geometry::aabb::widened;
use crate::geometry::key::{KeyBox, key};
use crate::id::{Id, Index};
use crate::simd::Simd;
use crate::simd::kernels::run;
use crate::sort::{heapsort, sift_down, sift_up};
use crate::tree::home_of;
use crate::tree::visit::{Probe, Visit};
use crate::world::World;

/// What is nearest to a point.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Hit, Id, InlineWorld, Region, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let ids = [world.insert(cube(2.0))?, world.insert(cube(5.0))?, world.insert(cube(9.0))?];
/// let mut hits = [None; 2];
/// assert_eq!(world.nearest([0.0; 3], &mut hits)?, 2);
/// assert_eq!(hits.map(|hit| hit.map(|hit| (hit.id, hit.distance))), [Some((ids[0], 2.0)), Some((ids[1], 5.0))]);
///
/// // The nearest shape, which need not have the nearest box; without the first object. Shapes are no nearer than their boxes.
/// let shape = |hit: &Hit| if hit.id == ids[1] { 8.5 } else { hit.distance + 0.2 };
/// let mut nearest = None;
/// world.visit_nearest([0.0; 3], f64::INFINITY, &mut |hit| {
///     if hit.id == ids[0] {
///         return f64::INFINITY; // refused: look on as far as before
///     }
///     let distance = shape(&hit);
///     if nearest.is_none_or(|(_, before)| distance < before) {
///         nearest = Some((hit.id, distance));
///     }
///     distance // beyond it nothing matters any more
/// })?;
/// assert_eq!(nearest, Some((ids[1], 8.5)));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Visits the objects whose boxes are at most so far from a point, each once, nearer leaves of the tree before farther ones. The
    /// visitor returns how far to look on: infinity to refuse an object and look as far as before, its distance to see only what
    /// is not farther, less than zero to stop. For the nearest of those that only the caller knows: by the distance of a shape, by
    /// what was visited before. Where boxes decide, [`nearest`](Self::nearest) and [`among`](Self::among) are shorter.
    ///
    /// # Errors
    /// [`Error::BadQuery`] where the point is not finite, or the distance is NaN or negative; it may be infinite.
    pub fn visit_nearest(
        &self,
        point: [f32; 3],
        distance: f64,
        visit: &mut dyn FnMut(Hit) -> f64,
    ) -> Result<(), Error> {
        if distance.is_nan() || distance < 0.0 {
            return Err(Error::BadQuery { index: 0 });
        }
        self.look_around(point, Visitor { far: distance, visit })
    }

    /// Writes the objects whose boxes are nearest to a point to `out`, as many as it takes, the nearest first, equally near
    /// ones by ascending slot. Squares of distances are compared, and two of them can have the same root. Returns how many there are:
    /// less than `out` takes only if there are no more objects.
    ///
    /// # Errors
    /// [`Error::BadQuery`] where the point is not finite.
    #[doc(alias("closest", "knn", "project_point"))]
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
        self.look_around(point, Best { heap: out, count: 0, condition })
    }

    fn look_around<W: Wanted>(&self, point: [f32; 3], wanted: W) -> Result<W::Output, Error> {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Error::BadQuery { index: 0 });
        }
        Ok(run!(self.kernels, |simd| visit_near(simd, self, point, wanted)))
    }
}

/// What is to become of the objects near a point.
trait Wanted {
    type Output;

    /// Beyond which squared distance nothing matters any more.
    fn limit(&self) -> f64;

    /// Whether an object in a slot is none of the wanted ones, however near it is.
    fn is_late(&self, slot: usize) -> bool;

    /// Takes an object within the limit, with its squared distance.
    fn offer(&mut self, id: Id, squared: f64);

    fn conclude(self) -> Self::Output;
}

/// The nearest objects so far: a heap with the farthest one of them at its root.
struct Best<'o> {
    heap: &'o mut [Option<Hit>],
    count: usize,
    /// Asked by reference, if there is one: the search is compiled once.
    condition: Option<&'o dyn Fn(Id) -> bool>,
}

impl Wanted for Best<'_> {
    type Output = usize;

    #[inline(always)]
    fn limit(&self) -> f64 {
        match self.heap.first() {
            Some(Some(farthest)) if self.count == self.heap.len() => farthest.distance,
            Some(_) => f64::INFINITY,
            None => f64::NEG_INFINITY,
        }
    }

    /// Where all wanted ones hold the point, later slots come later: that spares a look at crowds around it.
    #[inline(always)]
    fn is_late(&self, slot: usize) -> bool {
        let last = self.heap.first().copied().flatten().filter(|_| self.count == self.heap.len());
        last.is_some_and(|last| last.distance == 0.0 && slot > last.id.slot() as usize)
    }

    #[inline(always)]
    fn offer(&mut self, id: Id, squared: f64) {
        let hit = Hit { id, distance: squared };
        let has_room = self.count < self.heap.len();
        // The condition is asked last: it may take longest.
        if !has_room && !precedes(Some(hit), self.heap.first().copied().flatten())
            || !self.condition.is_none_or(|condition| condition(id))
        {
            return;
        }
        if has_room {
            self.heap.put(self.count, Some(hit));
            self.count += 1;
            sift_up(self.heap.span_mut(0, self.count), &precedes);
        } else {
            self.heap.put(0, Some(hit));
            sift_down(self.heap, 0, &precedes);
        }
    }

    #[inline(always)]
    fn conclude(self) -> usize {
        let found = self.heap.span_mut(0, self.count);
        heapsort(found, precedes);
        for hit in found.iter_mut().flatten() {
            hit.distance = libm::sqrt(hit.distance);
        }
        found.len()
    }
}

/// Objects go to the caller.
struct Visitor<'v> {
    /// How far to look; less than zero where the caller has stopped.
    far: f64,
    visit: &'v mut dyn FnMut(Hit) -> f64,
}

impl Wanted for Visitor<'_> {
    type Output = ();

    /// A little larger than need be, so that no square whose root is rounded to `far` is beyond it.
    #[inline(always)]
    fn limit(&self) -> f64 {
        let far = self.far.max(0.0);
        far * far * (1.0 + 4.0 * f64::EPSILON)
    }

    #[inline(always)]
    fn is_late(&self, _: usize) -> bool {
        false
    }

    #[inline(always)]
    fn offer(&mut self, id: Id, squared: f64) {
        let distance = libm::sqrt(squared);
        if distance <= self.far {
            self.far = self.far.min((self.visit)(Hit { id, distance }));
        }
    }

    #[inline(always)]
    fn conclude(self) {}
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

#[inline(always)]
fn visit_near<S: Simd, W: Wanted, I: Index>(
    simd: S,
    world: &World<'_, I>,
    point: [f32; 3],
    mut wanted: W,
) -> W::Output {
    let parts = &world.parts;
    let offer = |wanted: &mut W, slot: usize| {
        if wanted.is_late(slot) {
            return;
        }
        let squared = squared_distance(&point, KeyBox::of(parts.boxes.now, slot));
        if let (true, Some(id)) = (squared <= wanted.limit(), world.id_of(slot)) {
            wanted.offer(id, squared);
        }
    };
    if world.has_apart() {
        for slot in world.apart_from_tree() {
            offer(&mut wanted, slot);
        }
    }
    if let Some(large) = world.large_objects() {
        let mut groups = large.visit(Around { point: &point, limit: wanted.limit() });
        while let Some(group) = groups.next(simd) {
            for straddler in large.group(group) {
                let slot = straddler.slot as usize;
                let near = squared_distance(&point, &straddler.bounds) <= wanted.limit();
                if near && is_current(parts, slot) {
                    offer(&mut wanted, slot);
                }
            }
            groups.probe.limit = wanted.limit();
        }
    }
    if world.has_tree() {
        let sub_levels = parts.state.tree.sub_levels();
        let home = home_of(&parts.tree, parts.state, &point.map(key));
        let start = home >> sub_levels;
        // The part around the point first: the others are hardly near enough then.
        let around_point = 1u32 << (home - (start << sub_levels));
        let probe = Around { point: &point, limit: wanted.limit() };
        let mut visit = Visit::new(simd, parts.tree.nodes(), start, probe);
        while let Some(whole) = visit.next(simd) {
            let first = if whole == start { around_point } else { 0 };
            for some in [first, !first].into_iter().filter(|some| *some != 0) {
                let (record, near) = parts_near(simd, parts, whole, &around(&point, wanted.limit()));
                let mut mask = near & some;
                while mask != 0 {
                    let leaf = (whole << sub_levels) + mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let mut members = MembersNear::new(simd, parts, leaf, record);
                    while let Some((slot, _)) = members.next() {
                        offer(&mut wanted, slot);
                    }
                }
            }
            visit.probe.limit = wanted.limit();
        }
    }
    wanted.conclude()
}

/// What overlaps everything up to a squared distance from a point: a little larger than need be.
fn around(point: &[f32; 3], squared: f64) -> KeyBox {
    let radius = libm::sqrt(squared) * (1.0 + 4.0 * f64::EPSILON);
    KeyBox {
        min: point.map(|x| key_below((widened(x) - radius).next_down())),
        max: point.map(|x| key_above((widened(x) + radius).next_up())),
    }
}
