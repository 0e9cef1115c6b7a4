//! What overlaps a box, a ball or a point, or is inside a part of space of the caller's own. The tree asks
//! about the boxes of its nodes first, and about nothing in a node that is wholly inside or outside.

use super::{Among, Search, is_current, key_above, key_below, parts_near, walk};
use crate::access::{Access, bits};
use crate::error::Error;
use crate::geometry::aabb::{Aabb, widened};
use crate::geometry::key::KeyBox;
use crate::id::{Id, Index};
use crate::simd::kernels::run;
use crate::simd::{Simd, limit};
use crate::tree::visit::Probe;
use crate::tree::{Frame, first_of_eight, sub_leaves_of};
use crate::world::World;
use core::ops::ControlFlow;

/// A closed part of space to look for objects: touching counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Region {
    /// A box. Decided exactly.
    Aabb(Aabb),
    /// A point. Decided exactly.
    Point([f32; 3]),
    /// A ball. The squared distance is computed in `f64`. An object that does not touch the least `f32` box
    /// of the ball does not touch the ball, however the distance is rounded.
    Sphere {
        /// The centre.
        center: [f32; 3],
        /// The radius, zero or more. An infinite ball holds everything.
        radius: f32,
    },
}

impl From<Aabb> for Region {
    fn from(aabb: Aabb) -> Self {
        Self::Aabb(aabb)
    }
}

impl Region {
    /// A [ball](Self::Sphere).
    #[must_use]
    pub const fn sphere(center: [f32; 3], radius: f32) -> Self {
        Self::Sphere { center, radius }
    }

    /// The least box around the region; `None` if the region is not valid.
    #[inline]
    pub(super) fn bounds(&self) -> Option<KeyBox> {
        match *self {
            Self::Aabb(aabb) => KeyBox::from_aabb(&aabb),
            Self::Point(point) => KeyBox::from_aabb(&Aabb::new(point, point)),
            Self::Sphere { center, radius } => {
                let valid = radius >= 0.0 && center.iter().all(|x| x.is_finite());
                let low = center.map(|x| key_below(widened(x) - widened(radius)));
                let high = center.map(|x| key_above(widened(x) + widened(radius)));
                valid.then_some(KeyBox { min: low, max: high })
            }
        }
    }
}

/// How a box lies to a part of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Outside. Then each box inside it is outside, too.
    Outside,
    /// Neither for certain: it counts as touching.
    Across,
    /// Inside. Then each box inside it is inside, too.
    Inside,
}

/// A part of space to look for objects: of the caller's own, or [`Planes`].
pub trait Volume {
    /// How a box lies to it: that of an object, or one around many. [`Side::Across`] is right for any box
    /// that is not outside, and for any box around many; more certain answers save time.
    fn side(&self, aabb: &Aabb) -> Side;
}

/// What is on the inner side of some planes or touches it: a frustum of six, an oriented box, any convex part
/// of space. A plane is a normal that points outward, and its distance along that: `x` is inside where
/// `normal * x <= distance`, in `f64`. A box is outside if it is wholly beyond one plane, so that near edges
/// and corners some boxes that are not quite inside count, as is usual in culling. Where there is NaN in a
/// plane, or infinities meet, a box counts as touching.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'p>(pub &'p [[f64; 4]]);

impl Volume for Planes<'_> {
    fn side(&self, aabb: &Aabb) -> Side {
        let (low, high) = (aabb.min.map(widened), aabb.max.map(widened));
        let mut side = Side::Inside;
        for plane in self.0 {
            // Of the innermost corner and of the outermost. Rounded products and sums rise with their parts,
            // so what is said of a box holds for each box inside it.
            let (mut inner, mut outer) = (0.0, 0.0);
            for k in 0..3 {
                let normal = plane[k];
                let (a, b) = if normal == 0.0 { (0.0, 0.0) } else { (normal * low[k], normal * high[k]) };
                inner += a.min(b);
                outer += a.max(b);
            }
            if inner > plane[3] {
                return Side::Outside;
            }
            let is_inside = outer <= plane[3];
            side = if is_inside { side } else { Side::Across };
        }
        side
    }
}

/// What is left to test of a ball where its bounds are touched.
struct Ball {
    center: [f32; 3],
    squared: f64,
}

impl Volume for Ball {
    fn side(&self, aabb: &Aabb) -> Side {
        if aabb.squared_distance(&self.center) <= self.squared { Side::Across } else { Side::Outside }
    }
}

/// What overlaps a box, a ball or a point, or is inside a part of space of the caller's own.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, Planes, Region, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [a, b] = [world.insert(cube(0.0))?, world.insert(cube(3.0))?];
/// let mut found = [None; 8];
/// assert_eq!(world.overlaps(&Region::Point([0.5; 3]), &mut found)?, 1);
/// assert_eq!(found[0], Some(a));
///
/// let mut touched = None;
/// world.visit_overlaps(&Region::sphere([2.0, 0.5, 0.5], 1.0), &mut |id| {
///     touched = Some(id);
///     core::ops::ControlFlow::Break(()) // one is enough
/// })?;
/// assert!(touched == Some(a) || touched == Some(b));
///
/// // Between two planes: x >= 2 and x + y <= 8.
/// let wedge = Planes(&[[-1.0, 0.0, 0.0, -2.0], [1.0, 1.0, 0.0, 8.0]]);
/// assert_eq!(world.within(&wedge, &mut found)?, 1);
/// assert_eq!(found[0], Some(b));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Visits the objects whose boxes overlap a region, each once, until the visitor breaks. Same calls, same
    /// order. O(log n + answers + movers since the last step), or O(n) before there is a tree. A visitor that
    /// panics leaves the world as it was, as do visitors of [`visit_hits`](Self::visit_hits) and
    /// [`visit_nearest`](Self::visit_nearest) and conditions of [`among`](Self::among): queries only look.
    ///
    /// # Errors
    /// [`Error::BadQuery`] if the region is not valid: NaN, a minimum above its maximum, a negative radius.
    pub fn visit_overlaps(
        &self,
        region: &Region,
        visit: &mut dyn FnMut(Id) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let (now, bounds) = (self.parts.boxes.given(), region.bounds().ok_or(Error::BadQuery { index: 0 })?);
        let Region::Sphere { center, radius } = *region else {
            self.visit_boxes(now, bounds, None, visit);
            return Ok(());
        };
        let ball = Ball { center, squared: widened(radius) * widened(radius) };
        // Whose functions only a program has that asks about balls: the compiler must not call them by name.
        self.visit_boxes(now, bounds, Some(core::hint::black_box(&ball as &dyn Volume)), visit);
        Ok(())
    }

    /// Writes the objects that overlap a region to `out`, by ascending slot. Returns how many there are.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::OutputFull`], which says how many there are; `out` holds some.
    #[doc(alias("query_aabb", "intersections_with_aabb", "aabb_intersections"))]
    pub fn overlaps(&self, region: &Region, out: &mut [Option<Id>]) -> Result<usize, Error> {
        self.among(|_| true).overlaps(region, out)
    }

    /// Visits the objects whose boxes are inside a part of space or across its border, each once, until the
    /// visitor breaks. The same calls give the same order. O(nodes and objects at the border + answers +
    /// movers since the last step).
    pub fn visit_within(&self, volume: &dyn Volume, visit: &mut dyn FnMut(Id) -> ControlFlow<()>) {
        self.visit_boxes(self.parts.boxes.given(), KeyBox::ALL, Some(volume), visit);
    }

    /// Writes the objects whose boxes are inside a part of space or across its border to `out`, by ascending
    /// slot. Returns how many there are.
    ///
    /// # Errors
    /// [`Error::OutputFull`], which says how many there are; `out` then holds some of them.
    pub fn within(&self, volume: &dyn Volume, out: &mut [Option<Id>]) -> Result<usize, Error> {
        self.among(|_| true).within(volume, out)
    }

    /// The same of the boxes of all slots, as given last or as they are swept.
    pub(crate) fn visit_boxes(
        &self,
        boxes: &[KeyBox],
        bounds: KeyBox,
        volume: Option<&dyn Volume>,
        visit: &mut dyn FnMut(Id) -> ControlFlow<()>,
    ) {
        let home = self.leaf_in_tree(&bounds.min);
        let search = InRegion { world: self, boxes, bounds, volume, visit };
        let _ = run!(self.kernels, |simd| walk(simd, self, home, search));
    }
}

impl<C: Fn(Id) -> bool, I: Index> Among<'_, '_, C, I> {
    /// See [`World::overlaps`].
    pub fn overlaps(&self, region: &Region, out: &mut [Option<Id>]) -> Result<usize, Error> {
        self.collect_ids(out, |visit| self.world.visit_overlaps(region, visit))
    }

    /// See [`World::within`].
    pub fn within(&self, volume: &dyn Volume, out: &mut [Option<Id>]) -> Result<usize, Error> {
        self.collect_ids(out, |visit| {
            self.world.visit_within(volume, visit);
            Ok(())
        })
    }

    fn collect_ids(
        &self,
        out: &mut [Option<Id>],
        ask: impl FnOnce(&mut dyn FnMut(Id) -> ControlFlow<()>) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let precedes = |a: Option<Id>, b: Option<Id>| a.map(Id::slot) < b.map(Id::slot);
        self.collect(out, ControlFlow::Continue(()), |id| *id, precedes, ask)
    }
}

/// Finds what touches some bounds and is not outside of a volume, if there is one.
struct InRegion<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    boxes: &'q [KeyBox],
    bounds: KeyBox,
    volume: Option<&'q dyn Volume>,
    visit: &'q mut dyn FnMut(Id) -> ControlFlow<()>,
}

impl<I: Index> Probe for InRegion<'_, '_, I> {
    /// Whether they are apart.
    type When = bool;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, [a, b]: [&KeyBox; 2]) -> [bool; 2] {
        [
            !simd.overlap(a, &self.bounds) || self.side(a) == Side::Outside,
            !simd.overlap(b, &self.bounds) || self.side(b) == Side::Outside,
        ]
    }
}

impl<I: Index> Search for InRegion<'_, '_, I> {
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, whole: usize) -> ControlFlow<()> {
        let parts = &self.world.parts;
        let side = self.side(parts.tree.nodes().around(whole));
        if side == Side::Outside {
            return ControlFlow::Continue(());
        }
        let (region, mask) = parts_near(simd, parts, whole, &self.bounds);
        let touching = limit(&region);
        for part in bits::of_word(mask) {
            let leaf = (whole << parts.state.tree.sub_levels()) + part;
            let side = if side == Side::Across { self.side_of_part(whole, part) } else { side };
            if side == Side::Outside {
                continue;
            }
            for (eight, left) in parts.tree.leaves.at(leaf).chunks_of_eight(parts.tree.records) {
                let mask = simd.touching(eight, touching) & first_of_eight(left);
                for slot in bits::of_word(mask).map(|at| eight.at(at).slot() as usize) {
                    if !is_current(parts, slot) {
                        continue;
                    }
                    if side == Side::Inside {
                        self.found(slot)?;
                    } else {
                        self.object(simd, slot)?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn object<S: Simd>(&mut self, simd: S, slot: usize) -> ControlFlow<()> {
        let aabb = KeyBox::of(self.boxes, slot);
        if simd.overlap(aabb, &self.bounds) && self.side(aabb) != Side::Outside {
            self.found(slot)?;
        }
        ControlFlow::Continue(())
    }
}

impl<I: Index> InRegion<'_, '_, I> {
    /// How a box that touches the bounds lies to the volume.
    fn side(&self, of: &KeyBox) -> Side {
        match self.volume {
            None => Side::Across,
            // Of a node without members.
            Some(_) if of.is_empty() => Side::Outside,
            Some(volume) => volume.side(&of.to_aabb()),
        }
    }

    /// How the members of a sub-leaf lie to the volume.
    fn side_of_part(&self, whole: usize, part: usize) -> Side {
        let (tree, sub_levels) = (&self.world.parts.tree, self.world.parts.state.tree.sub_levels());
        let bounds = sub_leaves_of(tree.bounds, sub_levels, whole);
        // A ball is tested in no more time than a sub-leaf.
        let (Some(volume), Some(bounds)) = (self.volume.filter(|_| self.bounds == KeyBox::ALL), bounds)
        else {
            return Side::Across;
        };
        let (frame, around) = (tree.frames.get(whole).unwrap_or(&Frame::NONE), tree.nodes().around(whole));
        let members = frame.part(&around.to_aabb(), &bounds.at(part));
        // It may be empty.
        if members.is_valid() { volume.side(&members) } else { Side::Outside }
    }

    fn found(&mut self, slot: usize) -> ControlFlow<()> {
        self.world.id_of(slot).map_or(ControlFlow::Continue(()), &mut self.visit)
    }
}
