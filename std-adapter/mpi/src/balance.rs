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
        let ranks = exchange.ranks();
        let moves = self.first || self.enabled && self.due && step >= self.next;
        if ranks == 1 || !moves {
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
        let new = old.moved(&mut samples);
        let better = new.fullest(&samples) as f64 <= WORTH_IT * old.fullest(&samples) as f64;
        self.pause = if better { PAUSE } else { (self.pause * 2).min(LONGEST_PAUSE) };
        self.next = step + self.pause;
        (better && new != *old).then_some(new)
    }
}
