//! Finds what a ray or a moving box meets, near things first.

use super::{Among, Search, is_current, walk};
use crate::access::{Access, bits};
use crate::error::Error;
use crate::geometry::aabb::Aabb;
use crate::geometry::key::{KeyBox, key};
use crate::geometry::line::{Line, Walk};
use crate::id::{Id, Index};
use crate::simd::kernels::run;
use crate::simd::{EIGHT, Simd};
use crate::tree::visit::Probe;
use crate::tree::{Frame, first_of_eight, sub_leaves_of};
use crate::world::World;
use core::ops::ControlFlow;

/// A box, or a point, that moves along a line.
#[doc(alias("Ray", "raycast", "ray_cast", "shape_cast"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cast {
    /// Where it starts. For a ray, a box of one point. Finite.
    pub start: Aabb,
    /// How it moves in one unit of distance. Finite, of any length; zero tests the start alone.
    pub direction: [f32; 3],
    /// How far it moves, in units of `direction`. Zero or more. It may be infinite; then boxes at infinity
    /// are not reached.
    #[doc(alias("max_toi", "max_time_of_impact"))]
    pub distance: f32,
}

impl Cast {
    /// A ray: `origin + t * direction` for `t` from zero to `distance`.
    #[must_use]
    pub const fn ray(origin: [f32; 3], direction: [f32; 3], distance: f32) -> Self {
        Self { start: Aabb::new(origin, origin), direction, distance }
    }

    /// A box that moves by `direction`.
    #[must_use]
    pub const fn swept(start: Aabb, direction: [f32; 3]) -> Self {
        Self { start, direction, distance: 1.0 }
    }

    pub(super) fn is_valid(&self) -> bool {
        let Self { start: Aabb { min, max }, direction, distance } = self;
        // All are tested: there is no branch.
        let finite = [min, max, direction].into_iter().flatten().fold(true, |all, x| all & x.is_finite());
        finite & self.start.is_valid() & (*distance >= 0.0)
    }
}

/// An object that a cast meets, or that is near a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The object.
    pub id: Id,
    /// How far the cast gets before it touches the object's box, in units of its direction; zero if it starts
    /// inside. For the nearest objects: the distance. Computed in `f64`.
    #[doc(alias("time_of_impact", "toi"))]
    pub distance: f64,
}

/// What a ray or a moving box meets.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Cast, Config, Error, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [a, b] = [world.insert(cube(2.0))?, world.insert(cube(5.0))?];
/// let ray = Cast::ray([0.0, 0.5, 0.5], [1.0, 0.0, 0.0], f32::INFINITY);
/// let hit = world.first_hit(&ray)?.expect("the nearer one");
/// assert_eq!((hit.id, hit.distance), (a, 2.0));
///
/// let mut hits = [None; 8];
/// assert_eq!(world.hits(&ray, &mut hits)?, 2);
/// assert_eq!(hits[1].map(|hit| hit.id), Some(b));
///
/// // A box that moves by 4 meets the first one after a quarter of its way.
/// let moving = Cast::swept(cube(0.0), [4.0, 0.0, 0.0]);
/// assert_eq!(world.first_hit(&moving)?.map(|hit| hit.distance), Some(0.25));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Visits the objects that a cast meets, each once, nearer leaves of the tree before farther ones. The
    /// visitor returns how far to look on: the cast's distance to see all, the hit's distance to see only what
    /// is not farther, less than zero to stop.
    ///
    /// # Errors
    /// [`Error::BadQuery`]: NaN, an infinity other than the distance, a negative distance.
    pub fn visit_hits(&self, cast: &Cast, visit: &mut dyn FnMut(Hit) -> f64) -> Result<(), Error> {
        if !cast.is_valid() {
            return Err(Error::BadQuery { index: 0 });
        }
        let _ = run!(self.kernels, |simd| visit_along(simd, self, cast, visit));
        Ok(())
    }

    /// The first object that a cast meets; of several at one distance the one with the lowest slot.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    #[doc(alias("raycast", "ray_cast", "cast_ray", "closest_hit"))]
    pub fn first_hit(&self, cast: &Cast) -> Result<Option<Hit>, Error> {
        self.among(|_| true).first_hit(cast)
    }

    /// Writes the objects that a cast meets to `out`, the nearest first, equally near ones by ascending slot.
    /// Returns how many there are.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::OutputFull`], which says how many there are; `out` holds some.
    #[doc(alias("raycast_all", "ray_hits"))]
    pub fn hits(&self, cast: &Cast, out: &mut [Option<Hit>]) -> Result<usize, Error> {
        self.among(|_| true).hits(cast, out)
    }
}

impl<C: Fn(Id) -> bool, I: Index> Among<'_, '_, C, I> {
    /// See [`World::first_hit`].
    pub fn first_hit(&self, cast: &Cast) -> Result<Option<Hit>, Error> {
        let mut first: Option<Hit> = None;
        self.world.visit_hits(cast, &mut |hit| {
            if !(self.condition)(hit.id) {
                return f64::INFINITY;
            }
            first = if precedes(first, Some(hit)) { first } else { Some(hit) };
            first.map_or(f64::INFINITY, |first| first.distance)
        })?;
        Ok(first)
    }

    /// See [`World::hits`].
    pub fn hits(&self, cast: &Cast, out: &mut [Option<Hit>]) -> Result<usize, Error> {
        let ask = |visit: &mut dyn FnMut(Hit) -> f64| self.world.visit_hits(cast, visit);
        self.collect(out, f64::INFINITY, |hit| hit.id, precedes, ask)
    }
}

/// The order of hits: by distance, equal ones by slot; `None` comes last.
pub(super) fn precedes(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a.distance, a.id.slot()) < (b.distance, b.id.slot()),
        (a, b) => a.is_some() && b.is_none(),
    }
}

/// A cast enters nodes in the time of [`Walk`].
struct OnLine<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    line: &'q Line,
    walk: &'q Walk,
    /// How far to look, and until when.
    far: f64,
    until: f32,
    visit: &'q mut dyn FnMut(Hit) -> f64,
}

#[inline(always)]
fn visit_along<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    cast: &Cast,
    visit: &mut dyn FnMut(Hit) -> f64,
) -> ControlFlow<()> {
    let home = world.leaf_in_tree(&cast.start.min.map(key));
    let line = &Line::new(&cast.start, cast.direction, cast.distance);
    let (far, along) = (line.distance, &Walk::new(line));
    walk(simd, world, home, OnLine { world, line, walk: along, far, until: along.time(far), visit })
}

impl<I: Index> Probe for OnLine<'_, '_, I> {
    /// NaN if it is not met.
    type When = f32;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, nodes: [&KeyBox; 2]) -> [f32; 2] {
        simd.enter(self.walk, nodes, self.until)
    }

    fn is_met(&self, when: f32) -> bool {
        when <= self.until
    }
}

impl<I: Index> Search for OnLine<'_, '_, I> {
    /// Sub-leaf by sub-leaf, nearer ones first.
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, simd: S, whole: usize) -> ControlFlow<()> {
        const PART: u32 = EIGHT as u32 - 1;
        const WHOLE: [f32; EIGHT] =
            [0.0, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN];
        let parts = &self.world.parts;
        let sub_levels = parts.state.tree.sub_levels();
        let frame = parts.tree.frames.get(whole).unwrap_or(&Frame::NONE);
        let mut crossing = self.walk.crossing(frame, self.until);
        let bounds = sub_leaves_of(parts.tree.bounds, sub_levels, whole);
        let times = bounds.map_or(WHOLE, |bounds| simd.met(bounds, &crossing).0);
        // Times rise with their bits, a little earlier is right too, and NaN is above all others. So a number
        // tells of each sub-leaf: the time, in the lowest bits which one.
        let numbers: [u32; EIGHT] = core::array::from_fn(|part| times[part].to_bits() & !PART | part as u32);
        let mut next = 0u32;
        loop {
            // The least number that was not taken yet: these are far ahead, round about.
            let ahead = numbers.iter().map(|number| number.wrapping_sub(next)).fold(u32::MAX, u32::min);
            let first = next.saturating_add(ahead);
            next = first.saturating_add(1);
            let from = f32::from_bits(first & !PART);
            let is_met = from <= crossing.until;
            if !is_met {
                return ControlFlow::Continue(());
            }
            let leaf = (whole << sub_levels) + (first & PART) as usize;
            for (eight, left) in parts.tree.leaves.at(leaf).chunks_of_eight(parts.tree.records) {
                let mut mask = simd.met(eight, &crossing).1;
                mask = if mask == 0 { 0 } else { mask & first_of_eight(left) };
                for slot in bits::of_word(mask).map(|at| eight.at(at).slot() as usize) {
                    if is_current(parts, slot) {
                        self.object(simd, slot)?;
                    }
                }
            }
            crossing.until = self.until;
        }
    }

    #[inline(always)]
    fn object<S: Simd>(&mut self, _: S, slot: usize) -> ControlFlow<()> {
        let now = KeyBox::of(self.world.parts.boxes.given(), slot);
        let (distance, to) = self.line.span(now, self.far);
        if let (true, Some(id)) = (distance <= to, self.world.id_of(slot)) {
            self.far = self.far.min((self.visit)(Hit { id, distance }));
            self.until = self.walk.time(self.far);
            if self.far < 0.0 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}
