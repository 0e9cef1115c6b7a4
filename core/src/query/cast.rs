//! What a ray or a moving box meets, near things first.

use super::{key_above, key_below, members_near, reach_of};
use crate::aabb::Aabb;
use crate::access::Access;
use crate::arch::{Phase, Simd};
use crate::error::Error;
use crate::id::{Id, Index};
use crate::kernels::Kernels;
use crate::key::{KeyBox, NEGATIVE_INFINITY, value};
use crate::sort::heapsort;
use crate::tree::{axis_of, key_of};
use crate::world::World;

/// A box, or a point, that moves along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cast {
    /// Where it starts; a ray starts as a box of one point. Finite.
    pub start: Aabb,
    /// Where it moves to in one unit of distance. Finite, of any length; zero tests where it starts.
    pub direction: [f32; 3],
    /// How far it moves, in units of `direction`. Zero or more; may be infinite.
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

/// A cast, prepared: a box is met where the point `t * direction` is inside the box's difference from the start.
struct Line {
    low: [f64; 3],
    high: [f64; 3],
    direction: [f64; 3],
    /// One over the direction; infinite where it is zero.
    inverse: [f64; 3],
    distance: f64,
}

impl Line {
    fn new(cast: &Cast) -> Self {
        let direction = cast.direction.map(f64::from);
        Self {
            low: cast.start.min.map(f64::from),
            high: cast.start.max.map(f64::from),
            direction,
            inverse: direction.map(|d| 1.0 / d),
            distance: f64::from(cast.distance),
        }
    }

    /// Between which distances the cast touches a box, if it does up to `far`. Each number rises with the box's sides, so a
    /// larger box is met no later and left no earlier.
    #[inline(always)]
    fn span(&self, min: &[i32; 3], max: &[i32; 3], far: f64) -> Option<(f64, f64)> {
        let (mut from, mut to) = (0.0f64, far);
        for k in 0..3 {
            let near = f64::from(value(min[k])) - self.high[k];
            let end = f64::from(value(max[k])) - self.low[k];
            if self.direction[k] == 0.0 {
                if near > 0.0 || end < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (near * self.inverse[k], end * self.inverse[k]);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from <= to).then_some((from, to))
    }

    /// A box around everything that the cast passes between two distances.
    fn hull(&self, from: f64, to: f64) -> KeyBox {
        let mut hull = KeyBox::EMPTY;
        for k in 0..3 {
            let (a, b) = (self.direction[k] * from, self.direction[k] * to);
            // More than what the roundings of the distances and of these sums can come to; nothing moves where there is
            // no direction, however far.
            let slack = (a.abs() + b.abs() + self.low[k].abs() + self.high[k].abs()) * (8.0 * f64::EPSILON);
            let still = self.direction[k] == 0.0;
            let (a, b) = if still { (0.0, 0.0) } else { (a.min(b) - slack, a.max(b) + slack) };
            hull.min[k] = key_below(self.low[k] + a);
            hull.max[k] = key_above(self.high[k] + b);
        }
        hull
    }
}

/// A node that waits to be visited.
#[derive(Clone, Copy, Default)]
struct Waiting {
    node: u32,
    low: [i32; 3],
    from: f64,
}

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// Members of a leaf for each part that a cast's way through it is cut into: the shorter the part, the fewer boxes are near it.
const MEMBERS_PER_PART: u32 = 32;
/// Parts at most.
const PARTS: u32 = 8;

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
            if let (Some((from, _)), Some(id)) = (line.span(&now.min, &now.max, far), world.id_of(slot)) {
                far = far.min(visit(Hit { id, distance: from }));
            }
        }
        if !world.has_tree() {
            return;
        }
        let first = 1u32 << parts.state.depth;
        let mut stack = [Waiting::default(); STACK];
        stack[0] = Waiting { node: 1, low: [NEGATIVE_INFINITY; 3], from: 0.0 };
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let Waiting { node, low, from } = stack.at(waiting);
            if from > far {
                continue;
            }
            if node >= first {
                let leaf = (node - first) as usize;
                let span = reach_of(parts, node).and_then(|reach| line.span(&low, &reach, far));
                if let Some((from, to)) = span {
                    far = members(simd, world, leaf, &line, [from, to], far, visit);
                }
                continue;
            }
            let plane = parts.tree.planes.at(node as usize);
            let mut right = low;
            right[axis_of(plane)] = right[axis_of(plane)].max(key_of(plane));
            let enter = |node: u32, low: [i32; 3]| {
                let (from, _) = line.span(&low, &reach_of(parts, node)?, far)?;
                Some(Waiting { node, low, from })
            };
            let mut children = [enter(2 * node, low), enter(2 * node + 1, right)];
            let from = |child: &Option<Waiting>| child.map_or(f64::INFINITY, |child| child.from);
            if from(&children[0]) <= from(&children[1]) {
                children.swap(0, 1);
            }
            for child in children.into_iter().flatten() {
                stack.put(waiting, child);
                waiting += 1;
            }
        }
    }
}

/// Visits the members of a leaf that the cast meets between two distances, in parts of that way, and returns how far to look on.
#[inline(always)]
fn members<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    leaf: usize,
    line: &Line,
    [from, to]: [f64; 2],
    mut far: f64,
    visit: &mut dyn FnMut(Hit) -> f64,
) -> f64 {
    let parts = &world.parts;
    let count = parts.tree.leaves.at(leaf).len;
    let cuts = if to.is_finite() { (count / MEMBERS_PER_PART).clamp(1, PARTS) } else { 1 };
    let cut =
        |part: u32| if part == 0 { from } else { from + (to - from) * (f64::from(part) / f64::from(cuts)) };
    for part in 0..cuts {
        let last = part + 1 == cuts;
        let (start, end) = (cut(part), if last { to } else { cut(part + 1) });
        if start > far {
            break;
        }
        members_near(simd, parts, leaf, &line.hull(start, end), |slot| {
            let now = KeyBox::of(parts.boxes.now, slot);
            let Some((distance, _)) = line.span(&now.min, &now.max, far) else { return };
            // In the part where the cast touches it first; nothing starts before the first part or behind the last.
            let here = (part == 0 || distance >= start) && (last || distance < end);
            if let (true, Some(id)) = (here, world.id_of(slot)) {
                far = far.min(visit(Hit { id, distance }));
            }
        });
    }
    far
}
