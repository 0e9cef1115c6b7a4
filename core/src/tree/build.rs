//! Makes planes from sorted lists (paper, section III.A; errata E10, E11, E13, E14, E17).
//!
//! The three lists hold the objects of a node in one range, each in its own order. A node is divided at the exact
//! median of the axis that parts its objects best. Then each list is divided by side and keeps its order, so the
//! medians of the children need no other sort. Level by level, O(n log n) in all.

use super::large::is_thin;
use super::limits::{AXIS_SAMPLE, CROSSING, LEAF_SAMPLE, LOPSIDED};
use super::{AXIS, UNSPLIT, axis_of, key_of, plane};
use crate::access::{Access, bits};
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::lists::links;
use crate::memory::limits::{BUILD_SHARED_BELOW, BUILD_SHARED_FROM};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::sort::heapsort;

/// Sub-trees that are built at the same time.
const SUB_TREES: usize = 1 << BUILD_SHARED_BELOW;

/// What a build works on.
pub(crate) struct Build<'b, I> {
    pub(crate) boxes: &'b [KeyBox],
    /// The slots of the node, each list in order.
    pub(crate) lists: [&'b mut [I]; 3],
    pub(crate) planes: &'b mut [i32],
    /// One bit a slot, clear before and after.
    pub(crate) sides: &'b mut [u32],
    /// As many slots as a list.
    pub(crate) spare: &'b mut [I],
    /// Room for where each leaf below the node starts, and one more.
    pub(crate) starts: &'b mut [u32],
}

impl<I: Index> Build<'_, I> {
    /// As [`run`](Self::run); sub-trees are built at the same time if there are enough objects, and `room` for what
    /// each needs.
    pub(crate) fn share(mut self, root: usize, levels: u32, room: &mut [u32], context: StepContext<'_>) {
        let below = levels.saturating_sub(BUILD_SHARED_BELOW);
        let nodes = 1usize << below;
        let [sides, starts] = [bits::words(self.boxes.len()), nodes + 1];
        let few = self.lists[0].len() < BUILD_SHARED_FROM;
        if few || below == 0 || room.len() < SUB_TREES * (sides + starts + nodes) {
            return self.run(root, levels);
        }
        self.run(root, BUILD_SHARED_BELOW);
        let Build { boxes, lists: [mut x, mut y, mut z], planes, mut spare, starts: borders, .. } = self;
        let mut room = room;
        let mut builds = [const { None }; SUB_TREES];
        for (part, build) in builds.iter_mut().enumerate() {
            let count = borders.at(part + 1) - borders.at(part);
            let lists = [&mut x, &mut y, &mut z].map(|list| take_first(list, count as usize));
            let planes = bytemuck::cast_slice_mut(take_first(&mut room, nodes));
            let [starts, sides] = [starts, sides].map(|length| take_first(&mut room, length));
            sides.fill(0);
            *build = Some(Build {
                boxes,
                lists,
                planes,
                sides,
                spare: take_first(&mut spare, count as usize),
                starts,
            });
        }
        context.each(Chunks::new(&mut builds, 1), |_, builds| {
            builds.iter_mut().flatten().for_each(|build| build.run(1, below));
        });
        for (part, build) in builds.iter().flatten().enumerate() {
            for level in 0..below {
                let first = ((root << BUILD_SHARED_BELOW) + part) << level;
                let made = build.planes.span(1 << level, 1 << level);
                planes.span_mut(first, 1 << level).copy_in(made);
            }
        }
    }

    /// Makes the planes of all nodes below `root`, down to `levels` levels.
    pub(crate) fn run(&mut self, root: usize, levels: u32) {
        let count = self.lists[0].len();
        self.starts.put(0, 0);
        self.starts.put(1, count as u32);
        for level in 0..levels {
            let nodes = 1usize << level;
            // Two ranges replace one: from the back, so that none is overwritten before it has moved.
            for index in (0..=nodes).rev() {
                self.starts.put(2 * index, self.starts.at(index));
            }
            for index in 0..nodes {
                let start = self.starts.at(2 * index) as usize;
                let end = self.starts.at(2 * index + 2) as usize;
                let (plane, middle) = self.split(start, end);
                self.planes.put((root << level) + index, plane);
                self.starts.put(2 * index + 1, middle as u32);
            }
        }
    }

    /// The plane that parts the range best, or [`UNSPLIT`]; and how many boxes of a sample cross it, more than the
    /// sample has if it is lopsided.
    fn best_plane(&self, start: usize, end: usize) -> (usize, i32) {
        let count = end - start;
        let mut best = (usize::MAX, UNSPLIT);
        // If many minima are equal to the median, or too many boxes cross the planes there, quarters may be better.
        for position in [count / 2, count / 4, count - count / 4] {
            for axis in 0..3 {
                if let Some(plane) = self.plane_at(position, axis, start, end) {
                    let crossing = self.crossing(plane, start, end);
                    if crossing < best.0 {
                        best = (crossing, plane);
                    }
                }
            }
            if best.0 < sampled(count) {
                break;
            }
        }
        best
    }

    /// Divides the range. Returns its plane, and where the right side starts.
    fn split(&mut self, start: usize, end: usize) -> (i32, usize) {
        let (_, plane) = self.best_plane(start, end);
        if plane == UNSPLIT {
            return (UNSPLIT, end);
        }
        let axis = axis_of(plane);
        let below = links::position_of_key(
            self.lists[axis].span(start, end - start),
            self.boxes,
            axis,
            key_of(plane),
        );
        self.divide(axis, start, start + below, end);
        (plane, start + below)
    }

    /// The plane at a position in the list of an axis, if it has objects on both sides.
    fn plane_at(&self, position: usize, axis: usize, start: usize, end: usize) -> Option<i32> {
        // Not `[axis]`: the compiler loses sight of the axes that it loops over.
        let list = self.lists.get(axis)?.span(start, end - start);
        let key = |at: usize| list.get(at).map(|slot| self.boxes.at(slot.at()).min.at(axis));
        let (first, here) = (key(0)?, key(position)?);
        let plane = plane(axis, here);
        if key_of(plane) > first {
            return Some(plane);
        }
        // All minima up to here are equal: the next greater one is the nearest plane that parts anything.
        let above =
            list.partition_point(|slot| self.boxes.at(slot.at()).min.at(axis) <= first.saturating_add(AXIS));
        let plane = super::plane(axis, key(above)?);
        (key_of(plane) > first).then_some(plane)
    }

    /// How many boxes of a sample of the range cross the plane; the greatest number if too many do. Four long thin ones
    /// that go far beyond it count as one, since they are large objects then, which cost little.
    fn crossing(&self, plane: i32, start: usize, end: usize) -> usize {
        let axis = axis_of(plane);
        let list = self.lists[axis].span(start, end - start);
        let step = step(list.len());
        let minimum = |slot: Option<&I>| slot.map_or(0, |slot| self.boxes.at(slot.at()).min[axis]);
        let half = length(minimum(list.first()), minimum(list.last())) / 2.0;
        let (mut below, mut quarters) = (0, 0);
        for slot in list.iter().step_by(step) {
            let bounds = self.boxes.at(slot.at());
            if bounds.min[axis] < key_of(plane) {
                below += 1;
                if bounds.max[axis] >= key_of(plane) {
                    let is_far = length(key_of(plane), bounds.max[axis]) > half && is_thin(&bounds);
                    quarters += if is_far { 1 } else { 4 };
                }
            }
        }
        let crossing = quarters / 4;
        let all = sampled(list.len());
        match crossing {
            _ if crossing * CROSSING > below => usize::MAX,
            // Lopsided: any other plane is better.
            _ if below.min(all - below) < all / LOPSIDED => all + crossing,
            _ => crossing,
        }
    }

    /// Divides the range of every list: objects before `middle` on `axis` come first.
    fn divide(&mut self, axis: usize, start: usize, middle: usize, end: usize) {
        for slot in self.lists[axis].span(middle, end - middle) {
            bits::set(self.sides, slot.at());
        }
        for other in [(axis + 1) % 3, (axis + 2) % 3] {
            // Not by index: the compiler loses sight of the axes that it loops over.
            let Some(list) = self.lists.get_mut(other) else { continue };
            let list = list.span_mut(start, end - start);
            let (mut left, mut right) = (0, 0);
            for index in 0..list.len() {
                let slot = list.at(index);
                let is_right = bits::test(self.sides, slot.at());
                // Both are written, since a branch here would be guessed wrong half of the time.
                list.put(left, slot);
                self.spare.put(right, slot);
                left += usize::from(!is_right);
                right += usize::from(is_right);
            }
            list.span_mut(left, right).copy_in(self.spare.span(0, right));
        }
        for slot in self.lists[axis].span(middle, end - middle) {
            bits::clear(self.sides, slot.at());
        }
    }
}

/// Whether a plane would part some objects nearly into halves. Looks at up to [`LEAF_SAMPLE`] of them.
pub(crate) fn is_divisible<I: Index>(boxes: &[KeyBox], slots: &[I]) -> bool {
    let mut lists = [[I::default(); LEAF_SAMPLE]; 3];
    let count = slots.len().min(LEAF_SAMPLE);
    for (axis, list) in lists.iter_mut().enumerate() {
        let list = list.span_mut(0, count);
        list.copy_in(slots);
        // Not `[axis]`: the compiler loses sight of the axes that it loops over.
        let key = |slot: I| (KeyBox::of(boxes, slot.at()).min.at(axis), slot.slot());
        heapsort(list, |a, b| key(a) < key(b));
    }
    let [x, y, z] = &mut lists;
    let lists = [x.span_mut(0, count), y.span_mut(0, count), z.span_mut(0, count)];
    let build = Build { boxes, lists, planes: &mut [], sides: &mut [], spare: &mut [], starts: &mut [] };
    let (_, plane) = build.best_plane(0, count);
    let is_below = |slot: &&I| KeyBox::of(boxes, slot.at()).min.at(axis_of(plane)) < key_of(plane);
    let below = slots.iter().take(count).filter(is_below).count();
    // Nearly halves: if half of the boxes are in one place, a plane parts only the others, again and again.
    plane != UNSPLIT && 8 * below.min(count - below) >= 3 * count
}

/// The step from one object of a sample to the next, and how many there are.
fn step(count: usize) -> usize {
    count.div_ceil(AXIS_SAMPLE).max(1)
}
fn sampled(count: usize) -> usize {
    count.div_ceil(step(count))
}

/// Takes the first `count` items off a slice.
fn take_first<'s, T>(slice: &mut &'s mut [T], count: usize) -> &'s mut [T] {
    slice.split_off_mut(..count).unwrap_or_default()
}
