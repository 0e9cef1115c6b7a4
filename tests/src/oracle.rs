//! The closed overlaps of boxes in two independent ways, neither of which shares code with trisap.

use crate::SlotPair;
use std::cell::RefCell;
use std::collections::VecDeque;
use trisap_core::Aabb;

/// Every pair of slots whose boxes share a point, ascending: all against all, compares only.
#[must_use]
pub fn brute_force(boxes: &[Option<Aabb>]) -> Vec<SlotPair> {
    let live = live(boxes);
    let sides = Sides::of(&live);
    let mut pairs = Vec::new();
    for i in 0..live.len() {
        sides.meeting(i, live.len(), |j| pairs.push([live[i].0, live[j].0]));
    }
    pairs
}

/// The same by sorting the minima on x and sweeping once: for scenes that are too large for all against all.
#[must_use]
pub fn sweep(boxes: &[Option<Aabb>]) -> Vec<SlotPair> {
    let mut live = live(boxes);
    live.sort_by(|(a, first), (b, second)| first.min[0].total_cmp(&second.min[0]).then(a.cmp(b)));
    let sides = Sides::of(&live);
    let mut pairs = Vec::new();
    for (i, (a, first)) in live.iter().enumerate() {
        // Total order puts -0 before +0, plain comparison calls them equal: still ascending for `partition_point`.
        let end = live.partition_point(|(_, later)| later.min[0] <= first.max[0]);
        sides.meeting(i, end, |j| pairs.push([*a.min(&live[j].0), *a.max(&live[j].0)]));
    }
    crate::sorted(&pairs)
}

/// The cheaper of the two for this many boxes. What a thread has asked lately about many boxes is remembered: the same frames are
/// played on all kernels and under all job systems, and most of the time of the tests went into the same answers.
#[must_use]
pub fn overlaps(boxes: &[Option<Aabb>]) -> Vec<SlotPair> {
    if boxes.len() < SWEPT {
        return brute_force(boxes);
    }
    if boxes.len() < KEPT {
        return sweep(boxes);
    }
    KNOWN.with_borrow_mut(|known| {
        if let Some((_, pairs)) = known.iter().find(|(known, _)| known == boxes) {
            return pairs.clone();
        }
        let pairs = sweep(boxes);
        let size = |(boxes, pairs): &Known| boxes.len() + pairs.len();
        while known.iter().map(size).sum::<usize>() > REMEMBERED {
            known.pop_front();
        }
        known.push_back((boxes.to_vec(), pairs.clone()));
        pairs
    })
}

/// From so many boxes on sorting them is cheaper than all against all.
const SWEPT: usize = 64;

/// From so many boxes on the answer is remembered. Sequences of operations have smaller worlds, and never the same twice.
const KEPT: usize = 300;

/// How many boxes and pairs a thread remembers.
const REMEMBERED: usize = 2_000_000;

/// The boxes of a question, and their pairs.
type Known = (Vec<Option<Aabb>>, Vec<SlotPair>);

thread_local! {
    static KNOWN: RefCell<VecDeque<Known>> = const { RefCell::new(VecDeque::new()) };
}

/// All slots alive.
#[must_use]
pub fn all_live(boxes: &[Aabb]) -> Vec<Option<Aabb>> {
    boxes.iter().copied().map(Some).collect()
}

fn live(boxes: &[Option<Aabb>]) -> Vec<(u32, Aabb)> {
    boxes.iter().zip(0..).filter_map(|(aabb, slot)| aabb.map(|aabb| (slot, aabb))).collect()
}

/// How many boxes are compared with one at once.
const LANES: usize = 16;

/// The sides of boxes, each in an array of its own, so that the compares become vector code.
struct Sides {
    min: [Vec<f32>; 3],
    max: [Vec<f32>; 3],
}

impl Sides {
    fn of(live: &[(u32, Aabb)]) -> Self {
        // At the end stands what overlaps nothing.
        let end = std::iter::repeat_n(f32::NAN, LANES);
        let side =
            |side: &dyn Fn(&Aabb) -> f32| live.iter().map(|(_, b)| side(b)).chain(end.clone()).collect();
        Self { min: [0, 1, 2].map(|k| side(&|b| b.min[k])), max: [0, 1, 2].map(|k| side(&|b| b.max[k])) }
    }

    /// Tells those between box `i` and `end` that share a point with it, ascending. Written out here although
    /// `Aabb::overlaps` exists: the oracle must not inherit a mistake of it. All six compares are made, without short cuts.
    fn meeting(&self, i: usize, end: usize, mut tell: impl FnMut(usize)) {
        for at in (i + 1..end).step_by(LANES) {
            let mut meet = [true; LANES];
            for k in 0..3 {
                let (low, high) = (self.min[k][i], self.max[k][i]);
                let (min, max) = (&self.min[k][at..at + LANES], &self.max[k][at..at + LANES]);
                for lane in 0..LANES {
                    meet[lane] &= (min[lane] <= high) & (low <= max[lane]);
                }
            }
            if meet != [false; LANES] {
                (at..end.min(at + LANES)).filter(|j| meet[j - at]).for_each(&mut tell);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    #[test]
    fn agree_on_every_scene() {
        for scene in scenes::all(700, 5) {
            let boxes = all_live(&scene.boxes);
            let pairs = brute_force(&boxes);
            assert_eq!(pairs, sweep(&boxes), "{}", scene.name);
            assert!(pairs.is_sorted() && pairs.iter().all(|[a, b]| a < b), "{}", scene.name);
            assert!(!pairs.is_empty(), "{} has no pair, so it tests nothing", scene.name);
        }
    }

    #[test]
    fn many_at_once_are_the_same_as_one_by_one() {
        for count in (0..60).chain([333]) {
            for scene in scenes::all(count, 5) {
                let mut pairs = Vec::new();
                for (b, two) in scene.boxes.iter().enumerate() {
                    for (a, one) in scene.boxes[..b].iter().enumerate() {
                        let apart = |k: usize| one.max[k] < two.min[k] || two.max[k] < one.min[k];
                        if !(apart(0) || apart(1) || apart(2)) {
                            pairs.push([a as u32, b as u32]);
                        }
                    }
                }
                pairs.sort_unstable();
                assert_eq!(brute_force(&all_live(&scene.boxes)), pairs, "{} of {count}", scene.name);
            }
        }
    }

    #[test]
    fn what_is_remembered_is_what_was_asked() {
        let boxes = all_live(&scenes::uniform(KEPT, 5));
        let mut fewer = boxes.clone();
        fewer[KEPT - 1] = None;
        let mut moved = boxes.clone();
        moved[100] = boxes[7];
        for _ in 0..3 {
            for asked in [&boxes, &fewer, &moved] {
                assert_eq!(overlaps(asked), brute_force(asked));
            }
        }
        assert_ne!(overlaps(&boxes), overlaps(&moved));
    }

    #[test]
    fn skip_dead_slots() {
        let unit = Some(Aabb::new([0.0; 3], [1.0; 3]));
        for oracle in [brute_force, sweep] {
            assert_eq!(oracle(&[unit, None, unit, None]), [[0, 2]]);
            assert_eq!(oracle(&[None, unit]), [] as [SlotPair; 0]);
        }
    }

    #[test]
    fn touching_boxes_overlap_and_an_ulp_apart_they_do_not() {
        let left = Some(Aabb::new([-1.0; 3], [0.0; 3]));
        let touching = Some(Aabb::new([-0.0; 3], [1.0; 3]));
        let apart = Some(Aabb::new([f32::from_bits(1), 0.0, 0.0], [1.0; 3]));
        for oracle in [brute_force, sweep] {
            assert_eq!(oracle(&[left, touching]), [[0, 1]]);
            assert_eq!(oracle(&[left, apart]), [] as [SlotPair; 0]);
        }
    }
}
