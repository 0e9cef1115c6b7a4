//! Which ranks send each other a message in each step.

use crate::split::Split;
use std::collections::BTreeMap;

/// Links of ranks whose cells do not touch end after so many steps in which neither had to tell the other anything.
const IDLE: u32 = 32;

/// The ranks that a rank is linked with: those whose cells touch its own, and those that it told something or that told it
/// something not long ago. Both ends of a link see the same messages, so both end it in the same step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Links {
    /// By rank: whether the cells touch, and how many steps ago one of both had to tell the other something.
    linked: BTreeMap<usize, (bool, u32)>,
}

impl Links {
    /// Links to the ranks whose cells touch.
    pub(crate) fn new(split: &Split, rank: usize) -> Self {
        Self { linked: split.neighbours(rank).map(|other| (other, (true, 0))).collect() }
    }

    pub(crate) fn contains(&self, rank: usize) -> bool {
        self.linked.contains_key(&rank)
    }

    /// There has been a message to or from a rank in this step, with something in it or without.
    pub(crate) fn told(&mut self, rank: usize, something: bool) {
        let (_, idle) = self.linked.entry(rank).or_insert((false, 0));
        if something {
            *idle = 0;
        }
    }

    /// The step is over.
    pub(crate) fn conclude(&mut self) {
        self.linked.values_mut().for_each(|(_, idle)| *idle += 1);
        self.linked.retain(|_, (touches, idle)| *touches || *idle <= IDLE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_a_link_end_it_together() {
        // Cells in a row: the first and the last one do not touch.
        let mut points: Vec<_> = (0..100).map(|i| [i as f32, 0.0, 0.0]).collect();
        let split = Split::first_has_all(4).moved(&mut points);
        let mut ends = [Links::new(&split, 0), Links::new(&split, 3)];
        assert!(!ends[0].contains(3) && !ends[1].contains(0));
        let neighbours = ends.clone();
        // The first rank tells something, much later the last one, and then nobody.
        for step in 0..100 {
            let linked = ends[0].contains(3);
            assert_eq!(linked, (1..=IDLE + 20).contains(&step), "step {step}");
            assert_eq!(ends[1].contains(0), linked, "step {step}");
            let (first, last) = (step == 0, step == 20);
            if linked || first {
                ends[0].told(3, first);
                ends[1].told(0, first);
            }
            if linked {
                ends[1].told(0, last);
                ends[0].told(3, last);
            }
            ends.iter_mut().for_each(Links::conclude);
        }
        let kept = |links: &Links| links.linked.keys().copied().collect::<Vec<_>>();
        assert_eq!(
            ends.each_ref().map(kept),
            neighbours.each_ref().map(kept),
            "cells that touch stay linked"
        );
    }
}
