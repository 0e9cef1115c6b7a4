//! The closed overlaps of boxes in two independent ways, neither of which shares code with trisap.

use crate::SlotPair;
use trisap_core::Aabb;

/// Every pair of slots whose boxes share a point, ascending: all against all, compares only.
#[must_use]
pub fn brute_force(boxes: &[Option<Aabb>]) -> Vec<SlotPair> {
    let live = live(boxes);
    let mut pairs = Vec::new();
    for (i, (a, first)) in live.iter().enumerate() {
        for (b, second) in &live[i + 1..] {
            if share_a_point(first, second) {
                pairs.push([*a, *b]);
            }
        }
    }
    pairs
}

/// The same by sorting the minima on x and sweeping once: for scenes that are too large for all against all.
#[must_use]
pub fn sweep(boxes: &[Option<Aabb>]) -> Vec<SlotPair> {
    let mut live = live(boxes);
    live.sort_by(|(a, first), (b, second)| first.min[0].total_cmp(&second.min[0]).then(a.cmp(b)));
    let mut pairs = Vec::new();
    for (i, (a, first)) in live.iter().enumerate() {
        // Total order puts -0 before +0, plain comparison calls them equal: still ascending for `take_while`.
        for (b, second) in live[i + 1..].iter().take_while(|(_, later)| later.min[0] <= first.max[0]) {
            if share_a_point(first, second) {
                pairs.push([*a.min(b), *a.max(b)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// The cheaper of the two for this many boxes.
#[must_use]
pub fn overlaps(boxes: &[Option<Aabb>]) -> Vec<SlotPair> {
    if boxes.len() < 64 { brute_force(boxes) } else { sweep(boxes) }
}

/// All slots alive.
#[must_use]
pub fn all_live(boxes: &[Aabb]) -> Vec<Option<Aabb>> {
    boxes.iter().copied().map(Some).collect()
}

fn live(boxes: &[Option<Aabb>]) -> Vec<(u32, Aabb)> {
    boxes.iter().zip(0..).filter_map(|(aabb, slot)| aabb.map(|aabb| (slot, aabb))).collect()
}

/// Written out here although `Aabb::overlaps` exists: the oracle must not inherit a mistake of it. All six
/// compares are made, without short cuts, so that the loops above become vector code.
fn share_a_point(a: &Aabb, b: &Aabb) -> bool {
    (a.min[0] <= b.max[0])
        & (a.min[1] <= b.max[1])
        & (a.min[2] <= b.max[2])
        & (b.min[0] <= a.max[0])
        & (b.min[1] <= a.max[1])
        & (b.min[2] <= a.max[2])
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
