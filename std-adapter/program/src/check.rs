//! Finds the pairs of a frame without trisap, and compares.

use crate::drive::Frame;
use trisap::{Aabb, Boxes, Mode, Pair};

/// Up to here, every box is compared with every other one.
const BRUTE_FORCE: usize = 4000;

/// Compares one frame after another.
pub(crate) struct Checker {
    mode: Mode,
    events: bool,
    /// The boxes as they should count: the last good one of every object.
    boxes: Vec<Aabb>,
    /// The pairs that the last frame reported.
    reported: Vec<Pair>,
    /// Pairs that were compared.
    pub(crate) compared: u64,
}

impl Checker {
    pub(crate) fn new(mode: Mode, events: bool) -> Self {
        Self { mode, events, boxes: Vec::new(), reported: Vec::new(), compared: 0 }
    }

    /// How the pairs of `objects` boxes are found for comparison.
    pub(crate) fn method(objects: u32) -> &'static str {
        if objects as usize <= BRUTE_FORCE { "brute force" } else { "an independent sweep" }
    }

    /// What is wrong with a frame, if anything is.
    pub(crate) fn compare(&mut self, frame: &Frame<'_>) -> Result<(), String> {
        let bad = take_in(&mut self.boxes, frame.boxes);
        let told = frame.rejected.map_or(0, |rejected| rejected.count);
        if bad != told {
            return Err(format!("{bad} boxes are bad, {told} were refused"));
        }
        let expected = pairs(&self.boxes);
        let reported = frame.pairs.all.sorted();
        self.compared += expected.len() as u64;

        let (missing, surplus) = differences(&expected, &reported);
        if let Some([a, b]) = missing.first() {
            return Err(format!(
                "{} of {} pairs are missing, the first is {a} {b}",
                missing.len(),
                expected.len()
            ));
        }
        if let Some([a, b]) = reported.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]) {
            return Err(format!("the pair {a} {b} is reported twice"));
        }
        if let Some([a, b]) = reported.iter().find(|[a, b]| a >= b) {
            return Err(format!("the pair {a} {b} is reported in the wrong order"));
        }
        match (self.mode, surplus.first()) {
            (Mode::Exact, Some([a, b])) => {
                return Err(format!("{} pairs do not overlap, the first is {a} {b}", surplus.len()));
            }
            (Mode::Fat, _) if surplus.len() as u64 != frame.surplus => {
                return Err(format!("{} pairs are surplus, {} were counted", surplus.len(), frame.surplus));
            }
            _ => {}
        }
        if self.events {
            let (lost, found) = differences(&self.reported, &reported);
            for (name, expected, told) in
                [("found", found, frame.pairs.found.sorted()), ("lost", lost, frame.pairs.lost.sorted())]
            {
                if expected != told {
                    return Err(format!(
                        "{} pairs are {name}, {} were reported so",
                        expected.len(),
                        told.len()
                    ));
                }
            }
        }
        self.reported = reported;
        Ok(())
    }
}

/// Replaces boxes by those of the next frame, as far as they are good. Tells how many are not.
fn take_in(boxes: &mut Vec<Aabb>, next: Boxes<'_>) -> u32 {
    boxes.resize(next.len(), Aabb::default());
    let mut bad = 0;
    for (index, kept) in boxes.iter_mut().enumerate() {
        match next.get(index).filter(Aabb::is_valid) {
            Some(aabb) => *kept = aabb,
            None => bad += 1,
        }
    }
    bad
}

/// What is in `a` alone and what is in `b` alone, both being sorted.
pub(crate) fn differences(a: &[Pair], b: &[Pair]) -> (Vec<Pair>, Vec<Pair>) {
    let only = |a: &[Pair], b: &[Pair]| {
        let mut rest = b.iter().peekable();
        let mut only = a.to_vec();
        only.retain(|pair| {
            while rest.next_if(|other| *other < pair).is_some() {}
            rest.peek() != Some(&pair)
        });
        only
    };
    (only(a, b), only(b, a))
}

/// All overlapping pairs, ascending.
pub(crate) fn pairs(boxes: &[Aabb]) -> Vec<Pair> {
    if boxes.len() <= BRUTE_FORCE { brute_force(boxes) } else { sweep(boxes) }
}

fn brute_force(boxes: &[Aabb]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (a, low) in boxes.iter().enumerate() {
        for (b, high) in boxes.iter().enumerate().skip(a + 1) {
            if low.overlaps(high) {
                pairs.push([a as u32, b as u32]);
            }
        }
    }
    pairs
}

/// Cuts the y axis into strips, puts each box into every strip that it touches, and sweeps each strip along x. A pair
/// counts in the strip of the higher one of its two lower y bounds, which both boxes touch.
fn sweep(boxes: &[Aabb]) -> Vec<Pair> {
    let ends = boxes.iter().flat_map(|aabb| [aabb.min[1], aabb.max[1]]).filter(|y| y.is_finite());
    let (low, high) = ends.fold((f32::MAX, f32::MIN), |(low, high), y| (low.min(y), high.max(y)));
    let count = (boxes.len() as f32).sqrt() / 16.0 + 1.0;
    let scale = count / (high - low).max(f32::MIN_POSITIVE);
    // Any function that never falls will do, so rounding does no harm; `as` saturates.
    let strip = |y: f32| (((y - low) * scale) as usize).min(count as usize - 1);

    let mut strips = vec![Vec::new(); count as usize];
    for (index, aabb) in boxes.iter().enumerate() {
        for members in &mut strips[strip(aabb.min[1])..=strip(aabb.max[1])] {
            members.push((*aabb, index as u32));
        }
    }
    let mut pairs = Vec::new();
    for (here, mut members) in strips.into_iter().enumerate() {
        members.sort_by(|(a, _), (b, _)| a.min[0].total_cmp(&b.min[0]));
        for (k, (aabb, a)) in members.iter().enumerate() {
            for (other, b) in members[k + 1..].iter().take_while(|(other, _)| other.min[0] <= aabb.max[0]) {
                if aabb.overlaps(other) && strip(aabb.min[1].max(other.min[1])) == here {
                    pairs.push([*a.min(b), *a.max(b)]);
                }
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap::scene::{Kind, Objects, Setup, Synthetic};

    #[test]
    fn the_sweep_agrees_with_brute_force() {
        for objects in Objects::ALL {
            for count in [1, 2, 300, 3000] {
                let mut scene = Synthetic::new(Setup { kind: Kind::Gravity, objects, count, seed: 4 });
                for _ in 0..3 {
                    scene.advance();
                    assert_eq!(sweep(scene.boxes()), brute_force(scene.boxes()));
                }
            }
        }
    }

    #[test]
    fn hard_boxes() {
        let infinite = f32::INFINITY;
        let mut boxes = vec![
            Aabb::new([-infinite; 3], [infinite; 3]),
            Aabb::new([-infinite, 0.0, -infinite], [infinite, 0.0, infinite]),
            Aabb::new([1.0; 3], [1.0; 3]),
            Aabb::new([1.0, -0.0, 1.0], [2.0, 1.0, 1.0]),
            Aabb::new([2.0, 1.0, 1.0], [2.0, 3.0, 1.0]),
            Aabb::new([0.0; 3], [-0.0; 3]),
            Aabb::new([f32::MIN; 3], [f32::MIN; 3]),
            Aabb::new([f32::MAX; 3], [f32::MAX; 3]),
        ];
        assert_eq!(sweep(&boxes), brute_force(&boxes));
        boxes = vec![Aabb::new([3.0; 3], [4.0; 3]); 600];
        assert_eq!(sweep(&boxes).len(), 600 * 599 / 2);
        assert!(sweep(&[]).is_empty());
    }

    #[test]
    fn differences_of_sorted_lists() {
        let (a, b) = ([[0, 1], [0, 3], [2, 4]], [[0, 2], [0, 3], [2, 4], [5, 6]]);
        assert_eq!(differences(&a, &b), (vec![[0, 1]], vec![[0, 2], [5, 6]]));
        assert_eq!(differences(&a, &a), (vec![], vec![]));
    }

    #[test]
    fn bad_boxes_keep_the_last_good_one() {
        let good = Aabb::new([0.0; 3], [1.0; 3]);
        let mut kept = vec![good; 3];
        let next = [good, Aabb::new([f32::NAN; 3], [1.0; 3]), Aabb::new([2.0; 3], [1.0; 3])];
        assert_eq!(take_in(&mut kept, Boxes::new(&next)), 2);
        assert_eq!(kept, [good; 3]);
    }
}
