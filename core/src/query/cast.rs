//! Finds what a ray or a moving box meets, near things first.

use super::{is_current, prefetch_members, prefetch_parts};
use crate::access::Access;
use crate::error::Error;
use crate::geometry::aabb::Aabb;
use crate::geometry::key::{KeyBox, key};
use crate::geometry::line::{Crossing, Line, Walk};
use crate::id::{Id, Index};
use crate::memory::prefetch::CAST_ANSWERS;
use crate::simd::kernels::run;
use crate::simd::{EIGHT, Simd};
use crate::sort::heapsort;
use crate::tree::visit::{Probe, Visit};
use crate::tree::{Frame, Straddler, first_of_eight, leaf_of, sub_leaves_of};
use crate::world::World;

/// A box, or a point, that moves along a line.
#[doc(alias("Ray", "raycast", "ray_cast", "shape_cast"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cast {
    /// Where it starts. For a ray, a box of one point. Finite.
    pub start: Aabb,
    /// How it moves in one unit of distance. Finite, of any length; zero tests the start alone.
    pub direction: [f32; 3],
    /// How far it moves, in units of `direction`. Zero or more. It may be infinite; then boxes at infinity are not
    /// reached.
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
    /// How far the cast gets before it touches the object's box, in units of its direction; zero if it starts inside.
    /// For the nearest objects: the distance. Computed in `f64`.
    #[doc(alias("time_of_impact", "toi"))]
    pub distance: f64,
}

impl Hit {
    /// By distance, equal ones by slot.
    pub(super) fn precedes(&self, other: &Self) -> bool {
        (self.distance, self.id.slot()) < (other.distance, other.id.slot())
    }
}

/// What a ray or a moving box meets.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
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
    /// Visits the objects that a cast meets, each once, nearer leaves of the tree before farther ones. The visitor
    /// returns how far to look on: the cast's distance to see all, the hit's distance to see only nearer ones, less
    /// than zero to stop.
    ///
    /// # Errors
    /// [`Error::BadQuery`] if the cast is not valid: NaN, an infinity other than the distance, a negative distance.
    pub fn visit_hits(&self, cast: &Cast, visit: &mut dyn FnMut(Hit) -> f64) -> Result<(), Error> {
        if !cast.is_valid() {
            return Err(Error::BadQuery { index: 0 });
        }
        run!(self.kernels, |simd| visit_along(simd, self, cast, visit));
        Ok(())
    }

    /// The first object that a cast meets; of several at one distance the one with the lowest slot.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    #[doc(alias("raycast", "ray_cast", "cast_ray", "closest_hit"))]
    pub fn first_hit(&self, cast: &Cast) -> Result<Option<Hit>, Error> {
        self.first_hit_of(cast, |_| true)
    }

    /// The same of the objects that may answer.
    pub(super) fn first_hit_of(
        &self,
        cast: &Cast,
        condition: impl Fn(Id) -> bool,
    ) -> Result<Option<Hit>, Error> {
        let mut first: Option<Hit> = None;
        self.visit_hits(cast, &mut |hit| {
            if !condition(hit.id) {
                return f64::INFINITY;
            }
            let nearest = first.filter(|first| first.precedes(&hit)).unwrap_or(hit);
            first = Some(nearest);
            nearest.distance
        })?;
        Ok(first)
    }

    /// Writes the objects that a cast meets to `out`, the nearest first, equally near ones by ascending slot. Returns
    /// how many there are.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::OutputFull`], which says how many there are; `out` then holds some of them.
    #[doc(alias("raycast_all", "ray_hits"))]
    pub fn hits(&self, cast: &Cast, out: &mut [Option<Hit>]) -> Result<usize, Error> {
        self.hits_of(cast, out, |_| true)
    }

    /// The same of the objects that may answer.
    pub(super) fn hits_of(
        &self,
        cast: &Cast,
        out: &mut [Option<Hit>],
        condition: impl Fn(Id) -> bool,
    ) -> Result<usize, Error> {
        let mut count = 0;
        self.visit_hits(cast, &mut |hit| {
            if !condition(hit.id) {
                return f64::INFINITY;
            }
            if let Some(place) = out.get_mut(count) {
                *place = Some(hit);
            }
            count += 1;
            f64::INFINITY
        })?;
        if count > out.len() {
            return Err(Error::OutputFull { needed: count as u64, room: out.len() });
        }
        heapsort(out.span_mut(0, count), precedes);
        Ok(count)
    }
}

/// The order of hits; `None` comes last.
pub(super) fn precedes(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.precedes(&b),
        (a, b) => a.is_some() && b.is_none(),
    }
}

/// A cast meets nodes in the time of [`Walk`].
struct Along<'w> {
    walk: &'w Walk,
    /// How far to look.
    until: f32,
}

impl Probe for Along<'_> {
    /// NaN if it is not met.
    type When = f32;

    const AT_ONCE: f32 = 0.0;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, nodes: [&KeyBox; 2]) -> [f32; 2] {
        simd.enter(self.walk, nodes, self.until)
    }

    #[inline(always)]
    fn is_met(&self, when: f32) -> bool {
        when <= self.until
    }

    #[inline(always)]
    fn is_right_first(&self, left: f32, right: f32) -> bool {
        right < left || left.is_nan()
    }
}

#[inline(always)]
fn visit_along<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    cast: &Cast,
    visit: &mut dyn FnMut(Hit) -> f64,
) {
    let parts = &world.parts;
    // What takes longest is started first: the leaf where the cast starts is found by planes alone, and
    // prefetched.
    let has_tree = world.has_tree();
    let mut home = 0;
    if has_tree {
        home = leaf_of(parts.tree.splits, &cast.start.min.map(key));
        prefetch_parts(simd, parts, home);
    }
    let line = Line::new(&cast.start, cast.direction, cast.distance);
    let mut search = Search { world, far: line.distance, line, visit, slots: [0; CAST_ANSWERS] };
    if world.has_apart() {
        for slot in world.apart_from_tree() {
            search.slots[0] = slot as u32;
            search.look(simd, 1);
        }
    }
    if !has_tree {
        return;
    }
    let walk = Walk::new(&search.line);
    // Large objects first: they are often hit, and what is behind them need not be looked at.
    if let Some(large) = world.large_objects() {
        let along = Along { walk: &walk, until: walk.time(search.far) };
        let mut visit = large.visit(along);
        while let Some(group) = visit.next(simd) {
            search.visit_large(simd, &visit.probe, large.group(group));
            visit.probe.until = walk.time(search.far);
        }
    }
    let along = Along { walk: &walk, until: walk.time(search.far) };
    let mut visit = Visit::new(simd, parts.tree.nodes(), home, along);
    while let Some(whole) = visit.next(simd) {
        prefetch_parts(simd, parts, whole);
        search.visit_leaf(simd, &walk, whole);
        visit.probe.until = walk.time(search.far);
    }
}

/// The sub-leaves that a cast meets, nearer ones first. A number each: its time, with the number of the sub-leaf in
/// the lowest bits. Times rise with their bits, a little earlier is right too, and NaN is above all others.
struct Met([u32; EIGHT]);

impl Met {
    const PART: u32 = EIGHT as u32 - 1;
    /// For a leaf that is not divided.
    const WHOLE: [f32; EIGHT] = [0.0, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN];

    #[inline(always)]
    fn new(times: [f32; EIGHT]) -> Self {
        let mut numbers = times.map(f32::to_bits);
        for (part, number) in (0..).zip(&mut numbers) {
            *number = *number & !Self::PART | part;
        }
        Self(numbers)
    }

    /// Takes out the first one: the sub-leaf, and when it is met; NaN if none is left.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S) -> (usize, f32) {
        let first = simd.pop_min(&mut self.0);
        ((first & Self::PART) as usize, f32::from_bits(first & !Self::PART))
    }
}

/// A cast that looks for hits.
struct Search<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    line: Line,
    /// How far to look.
    far: f64,
    visit: &'q mut dyn FnMut(Hit) -> f64,
    /// Objects that it may touch.
    slots: [u32; CAST_ANSWERS],
}

impl<I: Index> Search<'_, '_, I> {
    /// Visits the members of a whole leaf that the cast meets, sub-leaf by sub-leaf.
    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, simd: S, walk: &Walk, whole: usize) {
        let parts = &self.world.parts;
        let sub_levels = parts.state.tree.sub_levels();
        let frame = parts.tree.frames.get(whole).unwrap_or(&Frame::NONE);
        let mut crossing = walk.crossing(frame, walk.time(self.far));
        let first = whole << sub_levels;
        let mut met = Met::new(match sub_leaves_of(parts.tree.bounds, sub_levels, whole) {
            Some(bounds) => simd.met(bounds, &crossing),
            None => Met::WHOLE,
        });
        let (mut part, mut from) = met.take(simd);
        prefetch_members(simd, parts, first + part);
        // A sub-leaf that is not met has NaN, which ends the loop.
        while from <= crossing.until {
            let leaf = first + part;
            (part, from) = met.take(simd);
            prefetch_members(simd, parts, first + part);
            self.visit_members(simd, leaf, &crossing);
            crossing.until = walk.time(self.far);
        }
    }

    /// Visits the large objects of a group that the cast meets.
    #[inline(always)]
    fn visit_large<S: Simd>(&mut self, simd: S, along: &Along<'_>, group: &[Straddler]) {
        let mut count = 0;
        for two in group.chunks(2) {
            let bounds = [0, 1].map(|at| two.get(at).map_or(&KeyBox::NOTHING, |straddler| &straddler.bounds));
            let when = along.meet(simd, bounds);
            for (straddler, when) in two.iter().zip(when) {
                if along.is_met(when) && is_current(&self.world.parts, straddler.slot as usize) {
                    self.slots.put(count, straddler.slot);
                    count += 1;
                }
            }
        }
        self.look(simd, count);
    }

    /// Visits the members of a leaf that the cast meets.
    #[inline(always)]
    fn visit_members<S: Simd>(&mut self, simd: S, leaf: usize, crossing: &Crossing) {
        let parts = &self.world.parts;
        let mut count = 0;
        for (eight, left) in parts.tree.leaves.at(leaf).chunks_of_eight(parts.tree.records) {
            let mut mask = simd.crossed(eight, crossing);
            if mask != 0 {
                mask &= first_of_eight(left);
            }
            while mask != 0 {
                let slot = eight.at(mask.trailing_zeros() as usize).slot();
                mask &= mask - 1;
                if is_current(parts, slot as usize) {
                    simd.prefetch(parts.boxes.now, slot as usize);
                    simd.prefetch(parts.generations, slot as usize);
                    self.slots.put(count, slot);
                    count += 1;
                    if count == CAST_ANSWERS {
                        self.look(simd, count);
                        count = 0;
                    }
                }
            }
        }
        self.look(simd, count);
    }

    /// Visits the objects that the cast meets, of the first so many slots.
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, count: usize) {
        for slot in self.slots.span(0, count) {
            let slot = *slot as usize;
            let now = KeyBox::of(self.world.parts.boxes.now, slot);
            let (distance, to) = self.line.span(simd, &now.min, &now.max, self.far);
            if let (true, Some(id)) = (distance <= to, self.world.id_of(slot)) {
                self.far = self.far.min((self.visit)(Hit { id, distance }));
            }
        }
    }
}

impl Line {
    /// Between which distances up to `far` the cast touches a box. If it does not, the first one is above the second.
    /// Each number rises with the box's sides, so a larger box is met no later and left no earlier.
    #[inline(always)]
    fn span<S: Simd>(&self, simd: S, min: &[i32; 3], max: &[i32; 3], far: f64) -> (f64, f64) {
        let four = |[x, y, z]: [i32; 3]| [x, y, z, 0];
        simd.span(&self.slabs, four(*min), four(*max), far)
    }
}
