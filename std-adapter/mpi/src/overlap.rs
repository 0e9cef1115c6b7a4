//! Whether a rank sweeps while messages travel.

use crate::stats::{Stage, Stats};

/// From so many objects on a sweep is worth doing while messages travel.
const FROM: usize = 4096;
/// The second sweep of a step takes this share of the time of a step's only sweep: 0.25 to 0.33 were measured where all boxes
/// move.
const SECOND_SWEEP: f64 = 0.3;
/// After so many steps with two sweeps there is one with a single sweep, to see how long the wait is.
const PROBE: u32 = 32;

/// Chooses from the times of the steps before, each rank for itself: the answer is the same with one sweep and with two.
#[derive(Clone, Debug)]
pub(crate) struct Overlap {
    choice: Option<bool>,
    /// The last step with one sweep waited longer than a second sweep takes.
    pays: bool,
    /// Steps with two sweeps since then.
    since: u32,
}

impl Overlap {
    pub(crate) fn new(choice: Option<bool>) -> Self {
        Self { choice, pays: false, since: 0 }
    }

    /// Whether to sweep early in a step. Never by itself where planes have moved, since much has to be swept again then.
    pub(crate) fn sweeps_early(&self, objects: usize, planes_moved: bool) -> bool {
        match self.choice {
            Some(always) => always,
            None => objects >= FROM && !planes_moved && self.pays && self.since < PROBE,
        }
    }

    /// What a step took.
    pub(crate) fn note(&mut self, stats: &Stats) {
        let seconds = |stage: Stage| stats.times[stage as usize].as_secs_f64();
        if stats.overlapped {
            self.since += 1;
        } else if !stats.planes_moved {
            self.pays = seconds(Stage::Exchange) > SECOND_SWEEP * seconds(Stage::LastSweep);
            self.since = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn step(wait: u64, sweep: u64, overlapped: bool) -> Stats {
        let mut stats = Stats { overlapped, ..Stats::default() };
        stats.times[Stage::Exchange as usize] = Duration::from_millis(wait);
        stats.times[Stage::LastSweep as usize] = Duration::from_millis(sweep);
        stats
    }

    #[test]
    fn a_second_sweep_needs_a_long_wait() {
        let mut overlap = Overlap::new(None);
        assert!(!overlap.sweeps_early(FROM, false), "nothing is known yet");
        overlap.note(&step(20, 100, false));
        assert!(!overlap.sweeps_early(FROM, false));
        overlap.note(&step(40, 100, false));
        assert!(overlap.sweeps_early(FROM, false));
        assert!(!overlap.sweeps_early(FROM - 1, false) && !overlap.sweeps_early(FROM, true));
        // The wait is hidden now, so that it is looked at again from time to time.
        let mut times = 0;
        while overlap.sweeps_early(FROM, false) {
            overlap.note(&step(0, 30, true));
            times += 1;
        }
        assert_eq!(times, PROBE);
        overlap.note(&step(1, 100, false));
        assert!(!overlap.sweeps_early(FROM, false));
    }

    #[test]
    fn who_is_told_does_so() {
        for (choice, sweeps) in [(Some(false), false), (Some(true), true)] {
            let mut overlap = Overlap::new(choice);
            for wait in [0, 1000] {
                overlap.note(&step(wait, 10, false));
                assert_eq!(overlap.sweeps_early(1, true), sweeps);
            }
        }
    }
}
