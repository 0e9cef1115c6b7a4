//! When the planes move.

use crate::exchange::{Census, Exchange};
use crate::split::Split;

/// The planes move when the rank with most objects has more than this many times the mean.
const UNEVEN: f64 = 1.2;
/// Points that a rank contributes to find the new planes.
const SAMPLES: usize = 2048;
/// Steps until the planes may move again. Doubles, up to the second number, each time that moving them would not help much.
const PAUSE: u64 = 8;
const LONGEST_PAUSE: u64 = 512;
/// How much less the fullest cell has to hold for the planes to move at all.
const WORTH_IT: f64 = 0.95;

/// Decides when the planes move: from numbers that all ranks have, so that all decide the same.
#[derive(Clone, Debug)]
pub(crate) struct Balance {
    enabled: bool,
    /// Nobody has looked yet.
    first: bool,
    due: bool,
    pause: u64,
    /// The planes stay before this step.
    next: u64,
}

impl Balance {
    pub(crate) fn new(enabled: bool) -> Self {
        Self { enabled, first: true, due: true, pause: PAUSE, next: 0 }
    }

    /// What the last step has told.
    pub(crate) fn note(&mut self, census: &Census, ranks: usize) {
        let mean = census.objects as f64 / ranks as f64;
        self.due = census.most as f64 > UNEVEN * mean;
        self.first &= census.objects == 0;
    }

    /// The split of this step, if the planes move. `points` are the minimum corners of the boxes that this rank knows the owner
    /// of. All ranks have to call it.
    pub(crate) fn split(
        &mut self,
        step: u64,
        old: &Split,
        exchange: &Exchange,
        points: impl Fn() -> Vec<[f32; 3]>,
    ) -> Option<Split> {
        if exchange.ranks() == 1 || !self.looks(step) {
            return None;
        }
        let points = points();
        let most = exchange.highest(&[points.len() as u64])[0] as usize;
        // The rank with most points contributes all samples that it may, the others their share.
        let stride = most.div_ceil(SAMPLES).max(1);
        let places = most.div_ceil(stride);
        let mut told: Vec<f32> = points.iter().step_by(stride).flatten().copied().collect();
        told.resize(places * 3, f32::NAN);
        let heard = exchange.gather_all(&told);
        let mut samples: Vec<[f32; 3]> = heard.as_chunks::<3>().0.to_vec();
        samples.retain(|point| point.iter().all(|x| !x.is_nan()));
        self.choose(step, old, &mut samples)
    }

    /// Whether to look for better planes before a step.
    fn looks(&self, step: u64) -> bool {
        self.first || self.enabled && self.due && step >= self.next
    }

    /// Better planes for samples of all ranks, if there are any.
    fn choose(&mut self, step: u64, old: &Split, samples: &mut [[f32; 3]]) -> Option<Split> {
        let new = old.moved(samples);
        let better = new.fullest(samples) as f64 <= WORTH_IT * old.fullest(samples) as f64;
        self.pause = if better { PAUSE } else { (self.pause * 2).min(LONGEST_PAUSE) };
        self.next = step + self.pause;
        (better && new != *old).then_some(new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANKS: usize = 4;

    fn row(from: i32) -> Vec<[f32; 3]> {
        (from..from + 1000).map(|x| [x as f32, 0.0, 0.0]).collect()
    }

    /// A balance that has placed the first planes.
    fn started() -> (Balance, Split) {
        let mut balance = Balance::new(true);
        assert!(balance.looks(1), "nobody has looked yet");
        let split = balance.choose(1, &Split::first_has_all(RANKS), &mut row(0)).expect("better");
        balance.note(&Census { objects: 1000, most: 250, far: 0 }, RANKS);
        (balance, split)
    }

    #[test]
    fn planes_move_from_a_fifth_above_the_mean_on() {
        let (mut balance, _) = started();
        for (most, looks) in [(250, false), (300, false), (301, true), (1000, true), (299, false)] {
            balance.note(&Census { objects: 1000, most, far: 0 }, RANKS);
            assert_eq!(balance.looks(100), looks, "{most}");
        }
        let fixed = Balance { first: false, ..Balance::new(false) };
        assert!(!fixed.looks(100));
    }

    #[test]
    fn planes_rest_after_a_move_and_longer_where_moving_is_of_no_use() {
        let (mut balance, mut split) = started();
        let uneven = Census { objects: 1000, most: 1000, far: 0 };
        let mut looked = Vec::new();
        // First all objects go on and on, then all of them are in one place, which no planes divide.
        for step in 2..4000 {
            balance.note(&uneven, RANKS);
            if balance.looks(step) {
                let mut samples = if step < 40 { row(step as i32 * 100) } else { vec![[1.0; 3]; 1000] };
                let new = balance.choose(step, &split, &mut samples);
                assert_eq!(new.is_some(), step < 40, "step {step}");
                split = new.unwrap_or(split);
                looked.push(step);
            }
        }
        let rests: Vec<_> = looked.windows(2).map(|steps| steps[1] - steps[0]).collect();
        assert_eq!(looked[0], 1 + PAUSE);
        assert_eq!(rests, [8, 8, 8, 8, 16, 32, 64, 128, 256, 512, 512, 512, 512, 512, 512]);
    }
}
