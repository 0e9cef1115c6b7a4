//! What a ray or a moving box meets, near things first.

use super::line::{Crossing, Line, Walk};
use super::{is_current, prefetch_members, prefetch_parts};
use crate::aabb::Aabb;
use crate::access::Access;
use crate::arch::{EIGHT, Phase, Simd};
use crate::error::Error;
use crate::id::{Id, Index};
use crate::kernels::Kernels;
use crate::key::KeyBox;
use crate::sort::heapsort;
use crate::tree::{Frame, first_of_eight, leaf_of, parts_of};
use crate::world::World;

/// A box, or a point, that moves along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cast {
    /// Where it starts; a ray starts as a box of one point. Finite.
    pub start: Aabb,
    /// Where it moves to in one unit of distance. Finite, of any length; zero tests where it starts.
    pub direction: [f32; 3],
    /// How far it moves, in units of `direction`. Zero or more; may be infinite, which does not get to boxes that are at
    /// infinity alone.
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
        let finite = |corner: &[f32; 3]| corner.iter().all(|x| x.is_finite());
        let start = self.start.is_valid() && finite(&self.start.min) && finite(&self.start.max);
        start && finite(&self.direction) && self.distance >= 0.0
    }
}

/// An object that a cast meets, or that is near a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The object.
    pub id: Id,
    /// How far the cast gets before it touches the object's box, in units of its direction; zero where it starts inside. For
    /// the nearest objects: the distance. Computed in `f64`.
    pub distance: f64,
}

impl Hit {
    /// By distance, equal ones by slot.
    pub(super) fn precedes(&self, other: &Self) -> bool {
        (self.distance, self.id.slot()) < (other.distance, other.id.slot())
    }
}

impl<I: Index> World<'_, I> {
    /// Visits the objects that a cast meets, each once, nearer leaves of the tree before farther ones. The visitor returns how
    /// far to look on: the cast's distance to see everything, the hit's to see only nearer ones, less than zero to stop.
    ///
    /// # Errors
    /// [`Error::BadQuery`] where the cast is not valid: NaN, infinities other than the distance, a negative distance.
    pub fn visit_hits(
        &self,
        cast: &Cast,
        kernels: Kernels,
        visit: &mut dyn FnMut(Hit) -> f64,
    ) -> Result<(), Error> {
        if !cast.is_valid() {
            return Err(Error::BadQuery { index: 0 });
        }
        kernels.run(Hits { world: self, line: Line::new(cast), visit });
        Ok(())
    }

    /// The first object that a cast meets; of several at one distance the one with the lowest slot.
    ///
    /// # Errors
    /// [`Error::BadQuery`].
    pub fn first_hit(&self, cast: &Cast, kernels: Kernels) -> Result<Option<Hit>, Error> {
        let mut first: Option<Hit> = None;
        self.visit_hits(cast, kernels, &mut |hit| {
            let nearest = first.filter(|first| first.precedes(&hit)).unwrap_or(hit);
            first = Some(nearest);
            nearest.distance
        })?;
        Ok(first)
    }

    /// Writes the objects that a cast meets to `out`, the nearest first, equally near ones by ascending slot, and returns how
    /// many there are.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::OutputFull`], which says how many there are; `out` then holds some of them.
    pub fn hits(&self, cast: &Cast, kernels: Kernels, out: &mut [Option<Hit>]) -> Result<usize, Error> {
        let mut count = 0;
        self.visit_hits(cast, kernels, &mut |hit| {
            if let Some(place) = out.get_mut(count) {
                *place = Some(hit);
            }
            count += 1;
            f64::INFINITY
        })?;
        if count > out.len() {
            return Err(Error::OutputFull { needed: count as u64 });
        }
        heapsort(out.span_mut(0, count), precedes);
        Ok(count)
    }
}

/// The order of hits.
pub(super) fn precedes(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.precedes(&b),
        (a, b) => a.is_some() && b.is_none(),
    }
}

/// A node that waits to be visited.
#[derive(Clone, Copy, Default)]
struct Waiting {
    /// The low sides of its members.
    low: [f32; 4],
    /// When the cast comes to it, in the time of [`Walk`].
    from: f32,
    node: u32,
}

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// Boxes that are asked for before the first of them is looked at: they are anywhere in memory.
const TOGETHER: usize = 16;

struct Hits<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    line: Line,
    visit: &'q mut dyn FnMut(Hit) -> f64,
}

impl<I: Index> Phase for Hits<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { world, line, visit } = self;
        let parts = &world.parts;
        let mut far = line.distance;
        // The large ones first: they are often hit, and what is behind them need not be looked at.
        for slot in world.large_in_tree().chain(world.apart_from_tree()) {
            let now = KeyBox::of(parts.boxes.now, slot);
            let (distance, to) = line.span(simd, &now.min, &now.max, far);
            if let (true, Some(id)) = (distance <= to, world.id_of(slot)) {
                far = far.min(visit(Hit { id, distance }));
            }
        }
        if !world.has_tree() {
            return;
        }
        let first = 1u32 << parts.state.depth;
        let walk = Walk::new(&line);
        let reaches: &[KeyBox] = bytemuck::try_cast_slice(parts.tree.reach).unwrap_or_default();
        let mut until = walk.time(far);
        let mut stack = [Waiting::default(); STACK];
        let mut waiting = 0;
        // The way to the leaf where the cast starts is found by planes alone, so that the nodes on it, and what is beside them,
        // can be looked at all together. What is met of it waits, the deepest last: the nearest.
        let home = first | leaf_of(parts.tree.planes, parts.state.depth, &line.corner()) as u32;
        prefetch_parts(simd, parts, (home - first) as usize);
        let (mut low, mut from) = ([f32::NEG_INFINITY; 4], 0.0);
        for level in (0..parts.state.depth).rev() {
            let child = home >> level;
            let node = (child / 2) as usize;
            let plane = parts.tree.planes.at(node);
            let (entered, above) = simd.enter(&walk, low, plane, KeyBox::of(reaches, node), until);
            let lows = [low, above];
            let side = (child & 1) as usize;
            let beside = entered.at(side ^ 1);
            // Written always, and kept or not, so that nothing depends on a guess of the branch predictor.
            stack.put(waiting, Waiting { low: lows.at(side ^ 1), from: beside, node: child ^ 1 });
            waiting += usize::from(beside <= until);
            (low, from) = (lows.at(side), entered.at(side));
        }
        stack.put(waiting, Waiting { low, from, node: home });
        waiting += 1;
        while waiting > 0 {
            waiting -= 1;
            let mut here = stack.at(waiting);
            // Down to the leaf that is met first. What is not met has no time, and NaN is not at most anything.
            while here.from <= until && here.node < first {
                let Waiting { node, low, .. } = here;
                let plane = parts.tree.planes.at(node as usize);
                let ([left, right], above) =
                    simd.enter(&walk, low, plane, KeyBox::of(reaches, node as usize), until);
                let left = Waiting { low, from: left, node: 2 * node };
                let right = Waiting { low: above, from: right, node: 2 * node + 1 };
                let swap = right.from < left.from || left.from.is_nan();
                let (near, later) = if swap { (right, left) } else { (left, right) };
                if later.from <= until {
                    stack.put(waiting, later);
                    waiting += 1;
                }
                here = near;
                if let Some(leaf) = here.node.checked_sub(first) {
                    prefetch_parts(simd, parts, leaf as usize);
                }
            }
            if here.from <= until {
                let whole = (here.node - first) as usize;
                far = parts_met(simd, world, whole, &line, &walk, far, visit);
                until = walk.time(far);
            }
        }
    }
}

/// The parts of a leaf that a cast meets, nearer ones first: a number each, its time with the number of the part in the lowest
/// bits. Times rise with their bits, and a little earlier is right as well; NaN is above all others.
struct Met([u32; EIGHT]);

impl Met {
    const PART: u32 = EIGHT as u32 - 1;
    /// Of a leaf that is not divided.
    const WHOLE: [f32; EIGHT] = [0.0, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN, f32::NAN];

    #[inline(always)]
    fn new(times: [f32; EIGHT]) -> Self {
        let mut numbers = times.map(f32::to_bits);
        for (part, number) in (0..).zip(&mut numbers) {
            *number = *number & !Self::PART | part;
        }
        Self(numbers)
    }

    /// Takes the first one out; returns the part and when it is met, NaN where none is left.
    #[inline(always)]
    fn take(&mut self) -> (usize, f32) {
        let first = self.0.into_iter().fold(u32::MAX, u32::min);
        for number in &mut self.0 {
            *number |= if *number == first { u32::MAX } else { 0 };
        }
        ((first & Self::PART) as usize, f32::from_bits(first & !Self::PART))
    }
}

/// Visits the members of a leaf of the last full step that the cast meets, part by part, and returns how far to look on.
#[inline(always)]
fn parts_met<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    whole: usize,
    line: &Line,
    walk: &Walk,
    mut far: f64,
    visit: &mut dyn FnMut(Hit) -> f64,
) -> f64 {
    let parts = &world.parts;
    let finer = parts.state.finer();
    let mut crossing = walk.crossing(parts.tree.frames.get(whole).unwrap_or(&Frame::NONE), walk.time(far));
    let first = whole << finer;
    let mut met = Met::new(match parts_of(parts.tree.bounds, finer, whole) {
        Some(bounds) => simd.met(bounds, &crossing),
        None => Met::WHOLE,
    });
    let (mut part, mut from) = met.take();
    prefetch_members(simd, parts, first + part);
    // What is not met has no time, and NaN is not at most anything.
    while from <= crossing.until {
        let leaf = first + part;
        (part, from) = met.take();
        prefetch_members(simd, parts, first + part);
        far = members(simd, world, leaf, line, &crossing, far, visit);
        crossing.until = walk.time(far);
    }
    far
}

/// Visits the members of a leaf that the cast meets, and returns how far to look on.
#[inline(always)]
fn members<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    leaf: usize,
    line: &Line,
    crossing: &Crossing,
    mut far: f64,
    visit: &mut dyn FnMut(Hit) -> f64,
) -> f64 {
    let parts = &world.parts;
    let bag = parts.tree.leaves.at(leaf);
    let mut slots = [0; TOGETHER];
    let mut count = 0;
    for (eight, left) in bag.eights(parts.tree.records) {
        let mut mask = simd.crossed(eight, crossing) & first_of_eight(left);
        while mask != 0 {
            let slot = eight.at(mask.trailing_zeros() as usize).slot() as usize;
            mask &= mask - 1;
            if is_current(parts, slot) {
                simd.prefetch(parts.boxes.now, slot);
                simd.prefetch(parts.generations, slot);
                slots.put(count, slot);
                count += 1;
                if count == TOGETHER {
                    far = look(simd, world, line, &slots, far, visit);
                    count = 0;
                }
            }
        }
    }
    look(simd, world, line, slots.span(0, count), far, visit)
}

/// Visits the objects that the cast meets, and returns how far to look on.
#[inline(always)]
fn look<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    line: &Line,
    slots: &[usize],
    mut far: f64,
    visit: &mut dyn FnMut(Hit) -> f64,
) -> f64 {
    for &slot in slots {
        let now = KeyBox::of(world.parts.boxes.now, slot);
        let (distance, to) = line.span(simd, &now.min, &now.max, far);
        if let (true, Some(id)) = (distance <= to, world.id_of(slot)) {
            far = far.min(visit(Hit { id, distance }));
        }
    }
    far
}
