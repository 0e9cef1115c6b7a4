//! Which objects are nearest to a point.

use super::cast::{Hit, precedes};
use super::region::squared_distance;
use super::{MembersNear, key_above, key_below, parts_near};
use crate::access::Access;
use crate::error::Error;
use crate::geometry::aabb::widened;
use crate::geometry::key::{KeyBox, key};
use crate::id::Index;
use crate::simd::{Phase, Simd};
use crate::sort::{heapsort, sift_down, sift_up};
use crate::tree::home_of;
use crate::world::World;

impl<I: Index> World<'_, I> {
    /// Writes the objects whose boxes are nearest to a point to `out`, as many as it takes, the nearest first, equally near
    /// ones by ascending slot. Returns how many there are: less than `out` takes only if there are no more objects.
    ///
    /// # Errors
    /// [`Error::BadQuery`] where the point is not finite.
    pub fn nearest(&self, point: [f32; 3], out: &mut [Option<Hit>]) -> Result<usize, Error> {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(Error::BadQuery { index: 0 });
        }
        Ok(self.kernels.run(Nearest { world: self, point, out }))
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

/// A node that waits to be visited.
#[derive(Clone, Copy, Default)]
struct Waiting {
    node: u32,
    squared: f64,
}

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

struct Nearest<'q, 'm, I: Index> {
    world: &'q World<'m, I>,
    point: [f32; 3],
    out: &'q mut [Option<Hit>],
}

impl<I: Index> Phase for Nearest<'_, '_, I> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { world, point, out } = self;
        let parts = &world.parts;
        let mut best = Best { heap: out, count: 0 };
        let offer = |best: &mut Best<'_>, slot: usize| {
            let squared = squared_distance(&point, KeyBox::of(parts.boxes.now, slot));
            if let (true, Some(id)) = (squared <= best.limit(), world.id_of(slot)) {
                best.offer(Hit { id, distance: squared });
            }
        };
        if world.has_others() {
            for slot in world.others() {
                offer(&mut best, slot);
            }
        }
        let has_tree = world.has_tree();
        let sub_levels = parts.state.tree.sub_levels();
        let home = if has_tree { home_of(parts.tree.planes, parts.state, &point.map(key)) } else { 0 };
        let first = 1u32 << parts.state.tree.depth;
        let mut stack = [Waiting::default(); STACK];
        stack[0] = Waiting { node: 1, squared: 0.0 };
        let mut waiting = usize::from(has_tree);
        while waiting > 0 {
            waiting -= 1;
            let Waiting { node, squared } = stack.at(waiting);
            let limit = best.limit();
            if squared > limit {
                continue;
            }
            if node >= first {
                let whole = (node - first) as usize;
                // The part around the point first, if it is one of these: the others are hardly near enough then.
                let around_point =
                    if home >> sub_levels == whole { 1 << (home - (whole << sub_levels)) } else { 0 };
                let all = u32::MAX >> (u32::BITS - (1 << sub_levels));
                for some in [around_point, all & !around_point].into_iter().filter(|some| *some != 0) {
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
                continue;
            }
            let enter = |node: u32| {
                let around = KeyBox::of(parts.tree.nodes, node as usize);
                let squared = squared_distance(&point, around);
                (!around.is_empty() && squared <= limit).then_some(Waiting { node, squared })
            };
            let mut children = [enter(2 * node), enter(2 * node + 1)];
            let squared = |child: &Option<Waiting>| child.map_or(f64::INFINITY, |child| child.squared);
            if squared(&children[0]) <= squared(&children[1]) {
                children.swap(0, 1);
            }
            for child in children.into_iter().flatten() {
                stack.put(waiting, child);
                waiting += 1;
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
