//! Which objects are nearest to a point.

use super::cast::{Hit, precedes};
use super::{Among, Search, is_current, key_above, key_below, parts_near, walk};
use crate::access::{Access, bits};
use crate::error::Error;
use crate::geometry::aabb::widened;
use crate::geometry::key::{KeyBox, key};
use crate::id::{Id, Index};
use crate::simd::kernels::run;
use crate::simd::{Simd, limit};
use crate::sort::{heapsort, sift_down, sift_up};
use crate::tree::visit::Probe;
use crate::tree::{first_of_eight, home_of};
use crate::world::World;
use core::ops::ControlFlow;

/// What is nearest to a point.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, Hit, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let ids = [world.insert(cube(2.0))?, world.insert(cube(5.0))?, world.insert(cube(9.0))?];
/// let mut hits = [None; 2];
/// assert_eq!(world.nearest([0.0; 3], &mut hits)?, 2);
/// assert_eq!(hits.map(|hit| hit.map(|hit| (hit.id, hit.distance))), [Some((ids[0], 2.0)), Some((ids[1], 5.0))]);
///
/// // The nearest shape, without the first object. Its box need not be the nearest; no shape is nearer than its box.
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
    /// Visits the objects whose boxes are at most so far from a point, each once, nearer leaves before
    /// farther ones. The visitor returns how far to look on: infinity to refuse an object, its distance to
    /// see only what is not farther, less than zero to stop. For a nearest that only the caller knows: by the
    /// distance of a shape, by what was visited before. Where boxes decide, [`nearest`](Self::nearest),
    /// [`among`](Self::among) are shorter.
    ///
    /// # Errors
    /// [`Error::BadQuery`]: the point is not finite, or the distance NaN or negative; it may be infinite.
    pub fn visit_nearest(
        &self,
        point: [f32; 3],
        distance: f64,
        visit: &mut dyn FnMut(Hit) -> f64,
    ) -> Result<(), Error> {
        if distance.is_nan() || distance < 0.0 {
            return Err(Error::BadQuery { index: 0 });
        }
        let mut far = distance;
        self.visit_near(point, limit_of(far), &mut |hit| {
            let distance = libm::sqrt(hit.distance);
            if distance <= far {
                far = far.min(visit(Hit { distance, ..hit }));
            }
            limit_of(far)
        })
    }

    /// Writes the objects whose boxes are nearest to a point to `out`, the nearest first, equally near ones
    /// by ascending slot. Squares of distances are compared, and two can have the same root. Returns how many
    /// there are: less than `out` takes only if there are no more objects. Boxes at infinity come last.
    ///
    /// # Errors
    /// [`Error::BadQuery`] where the point is not finite.
    #[doc(alias("closest", "knn", "project_point"))]
    pub fn nearest(&self, point: [f32; 3], out: &mut [Option<Hit>]) -> Result<usize, Error> {
        self.among(|_| true).nearest(point, out)
    }

    /// Visits objects with the squares of their distances, up to a limit. The visitor returns the next limit.
    fn visit_near(
        &self,
        point: [f32; 3],
        limit: Limit,
        visit: &mut dyn FnMut(Hit) -> Limit,
    ) -> Result<(), Error> {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Error::BadQuery { index: 0 });
        }
        let (boxes, point, sub_levels) =
            (self.parts.boxes.given(), &point, self.parts.state.tree.sub_levels());
        let home = self.has_tree().then(|| home_of(&self.parts.tree, self.parts.state, &point.map(key)));
        let search = Near { world: self, boxes, point, home: home.unwrap_or(0), limit, visit };
        let _ = run!(self.kernels, |simd| walk(simd, self, home.map(|home| home >> sub_levels), search));
        Ok(())
    }
}

impl<C: Fn(Id) -> bool, I: Index> Among<'_, '_, C, I> {
    /// See [`World::nearest`].
    pub fn nearest(&self, point: [f32; 3], out: &mut [Option<Hit>]) -> Result<usize, Error> {
        let (mut count, room) = (0, out.len());
        // A heap with the farthest hit at its root.
        let farthest = |heap: &[Option<Hit>], count: usize| match heap.first() {
            Some(Some(farthest)) if count == room => {
                Limit { squared: farthest.distance, slot: farthest.id.slot() }
            }
            Some(_) => Limit { squared: f64::INFINITY, slot: u32::MAX },
            None => Limit { squared: -1.0, slot: 0 },
        };
        self.world.visit_near(point, farthest(out, 0), &mut |hit| {
            // The condition is asked last: it may take longest.
            let is_wanted = count < room || precedes(Some(hit), out.first().copied().flatten());
            if is_wanted && (self.condition)(hit.id) {
                if count < room {
                    sift_up(out, 0, count, Some(hit), &precedes);
                    count += 1;
                } else {
                    out.put(0, Some(hit));
                    sift_down(out, 0, &precedes);
                }
            }
            farthest(out, count)
        })?;
        let found = out.span_mut(0, count);
        heapsort(found, precedes);
        found.iter_mut().flatten().for_each(|hit| hit.distance = libm::sqrt(hit.distance));
        Ok(count)
    }
}

/// Beyond which squared distance nothing matters any more; and for objects that hold the point, beyond which
/// slot: that spares a look at crowds around it.
#[derive(Clone, Copy)]
struct Limit {
    squared: f64,
    slot: u32,
}

/// A little larger than need be, so that no square whose root is rounded to `far` is beyond it.
fn limit_of(far: f64) -> Limit {
    let far = if far < 0.0 { f64::NAN } else { far };
    Limit { squared: far * far * (1.0 + 4.0 * f64::EPSILON), slot: u32::MAX }
}

/// A point meets the nodes that are near enough, by their squared distance.
struct Near<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    boxes: &'q [KeyBox],
    point: &'q [f32; 3],
    /// The leaf or sub-leaf of the point.
    home: usize,
    limit: Limit,
    visit: &'q mut dyn FnMut(Hit) -> Limit,
}

impl<I: Index> Probe for Near<'_, '_, I> {
    /// NaN of a node without members.
    type When = f64;

    #[inline(always)]
    fn meet<S: Simd>(&self, _: S, nodes: [&KeyBox; 2]) -> [f64; 2] {
        nodes.map(|node| match node.is_empty() {
            true => f64::NAN,
            false => node.to_aabb().squared_distance(self.point),
        })
    }

    fn is_met(&self, squared: f64) -> bool {
        squared <= self.limit.squared
    }
}

impl<I: Index> Search for Near<'_, '_, I> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, whole: usize) -> ControlFlow<()> {
        let parts = &self.world.parts;
        let first = whole << parts.state.tree.sub_levels();
        // The part around the point first: the others are hardly near enough then.
        let home = 1u32.checked_shl(self.home.wrapping_sub(first) as u32).unwrap_or(0);
        for some in [home, !home].into_iter().filter(|some| *some != 0) {
            let (region, near) = parts_near(simd, parts, whole, &around(self.point, self.limit.squared));
            let touching = limit(&region);
            for leaf in bits::of_word(near & some).map(|part| first + part) {
                for (eight, left) in parts.tree.leaves.at(leaf).chunks_of_eight(parts.tree.records) {
                    let mut mask = simd.touching(eight, touching) & first_of_eight(left);
                    while mask != 0 {
                        let slot = eight.at(mask.trailing_zeros() as usize).slot() as usize;
                        mask &= mask - 1;
                        if is_current(parts, slot) {
                            self.object(simd, slot)?;
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn object<S: Simd>(&mut self, _: S, slot: usize) -> ControlFlow<()> {
        if self.limit.squared == 0.0 && slot > self.limit.slot as usize {
            return ControlFlow::Continue(());
        }
        let now = KeyBox::of(self.boxes, slot).to_aabb();
        let distance = now.squared_distance(self.point);
        if let (true, Some(id)) = (distance <= self.limit.squared, self.world.id_of(slot)) {
            self.limit = (self.visit)(Hit { id, distance });
            if self.limit.squared.is_nan() {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
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
