//! Fat boxes: an object has moved when its box leaves the fat box around an earlier one (paper, V; E2).
//!
//! A fat box is the box and a margin; or predicted: it also holds the next boxes of an object that goes on.
//! A fat world reports boxes with margins, and its fat boxes are predicted around these.
//! All are made anew at once when some objects have left theirs, so that most steps are quiet. Where they do
//! not last even so, the boxes as given are swept: see [`renew`](crate::step::policy::renew).

use crate::access::{Access, bits};
use crate::config::{EVENTS, MARGINS, Margin, TREE};
use crate::geometry::key::KeyBox;
use crate::simd::Simd;
use crate::simd::scalar::Scalar;

/// The fat boxes of some consecutive slots; none if there are none in use.
pub(crate) struct FatBoxes<'o> {
    pub(crate) boxes: &'o mut [KeyBox],
    /// What the caller has put around each box; none if no margins were given.
    pub(crate) margins: &'o [f32],
    pub(crate) rule: FatRule,
}

/// How boxes get others around them, and how many left these.
#[derive(Clone, Copy)]
pub(crate) struct FatRule {
    /// Whether margins are part of the boxes that are reported, not of fat boxes alone.
    pub(crate) reports_margins: bool,
    /// Whether fat boxes are predicted, not only grown by the margin.
    pub(crate) predicted: bool,
    /// Whether each new box gets a new fat box.
    pub(crate) renews: bool,
    /// In a fat world: whether it gets a new one that is reported.
    pub(crate) regrows: bool,
    /// Boxes that left their fat boxes, or got new ones with all others.
    pub(crate) outran: u32,
}

impl FatRule {
    /// In a fat world: of the boxes `given` to some objects, who were reported as `old` and given `last`: who
    /// are reported as or get anything else, a bit each, and what all are reported as.
    #[inline(always)]
    pub(crate) fn report<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        margins: &[f32; N],
        old: &[KeyBox; N],
        last: &[KeyBox; N],
        given: &[KeyBox; N],
    ) -> (u32, [KeyBox; N]) {
        let mut others = 0;
        for (bit, (last, given)) in last.iter().zip(given).enumerate() {
            others |= u32::from(last != given) << bit;
        }
        let left = others & !simd.inside(old, given);
        self.outran += left.count_ones();
        let (mut to, grows) = (*old, if self.regrows { others } else { left });
        if grows != 0 {
            let mut grown = *old;
            simd.predicted(given, given, margins, false, &mut grown);
            bits::of_word(grows).for_each(|bit| to.put(bit, grown.at(bit)));
        }
        (if self.renews { others } else { grows }, to)
    }

    /// Gives some objects other boxes, whose bit is set, and new fat boxes to those that leave theirs. Returns
    /// who stays in the fat box.
    #[inline(always)]
    pub(crate) fn follow<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        margins: &[f32; N],
        (old, new): (&[KeyBox; N], &[KeyBox; N]),
        others: u32,
        fat: &mut [KeyBox; N],
    ) -> u32 {
        let stay = if self.renews { 0 } else { others & simd.inside(fat, new) };
        self.outran += if self.reports_margins { 0 } else { (others & !stay).count_ones() };
        if others != stay {
            let (were, around) = (*fat, if self.reports_margins { &[0.0; N] } else { margins });
            simd.predicted(new, old, around, TREE && self.predicted, fat);
            let kept = !(others & !stay) & (u32::MAX >> (32 - N));
            bits::of_word(kept).for_each(|bit| fat.put(bit, were.at(bit)));
        }
        stay
    }
}

impl FatBoxes<'_> {
    /// Whether there are fat boxes in use.
    pub(crate) fn exist(&self) -> bool {
        TREE && !self.boxes.is_empty()
    }

    pub(crate) fn margin(&self, at: usize) -> f32 {
        self.margins.get(at).copied().unwrap_or_default()
    }

    /// Makes the fat box of an object whose motion nobody knows.
    pub(crate) fn anchor(&mut self, at: usize, bounds: &KeyBox) {
        if self.exist() {
            let around = if self.rule.reports_margins { 0.0 } else { self.margin(at) };
            self.boxes.put(at, bounds.grown(around));
        }
    }

    /// Takes in the box given to an object that is reported as `now`: keeps that, if there is a place for it,
    /// and makes of it what is reported from now on. Returns whether the object stays in its fat box; `None`
    /// if nothing changes.
    #[inline(never)]
    pub(crate) fn replace(
        &mut self,
        given: &mut [KeyBox],
        at: usize,
        now: &mut KeyBox,
        new: &KeyBox,
        before: Option<&mut KeyBox>,
    ) -> Option<bool> {
        let (mut to, mut last, mut others) = ([*new], None, u32::from(!new.is_same(now)));
        let margins = [self.margin(at)];
        if MARGINS && let Some(given) = given.get_mut(at) {
            let was = core::mem::replace(given, *new);
            (others, to) = self.rule.report(Scalar, &margins, &[*now], &[was], &[*new]);
            last = Some(was);
        }
        if others == 0 {
            return None;
        }
        let from = last.map_or([*now], |last| to.map(|to| to.came_from(&last, new)));
        if EVENTS
            && TREE
            && let Some(before) = before
        {
            *before = *now;
        }
        [*now] = to;
        let fat = self.boxes.get_mut(at..).and_then(|boxes| boxes.first_chunk_mut()).filter(|_| TREE);
        Some(fat.is_some_and(|fat| self.rule.follow(Scalar, &margins, (&from, &to), 1, fat) != 0))
    }
}

/// The most that the size of a box counts, in its smallest sides: a wide plane needs no wide margin.
const FLATTEST: f32 = 8.0;

/// The length of a margin for a box (erratum E2). An unbounded box counts as size zero.
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    let (largest, smallest) = (bounds.largest_extent(), bounds.smallest_extent());
    let size = if largest > f32::MAX { 0.0 } else { largest.min(FLATTEST * smallest) };
    (margin.per_extent * size).max(margin.min).min(margin.max)
}
