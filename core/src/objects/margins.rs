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
    /// Whether that is part of the boxes that are reported, not of fat boxes alone.
    pub(crate) reports_margins: bool,
    /// Whether fat boxes are predicted, not only grown by the margin.
    pub(crate) predicted: bool,
    /// Whether each new box gets a new fat box.
    pub(crate) renews: bool,
    /// In a fat world: whether it gets a new one that is reported.
    pub(crate) regrows: bool,
    /// Boxes that left their fat boxes.
    pub(crate) outran: u32,
}

impl FatBoxes<'_> {
    /// Whether there are fat boxes in use.
    pub(crate) fn exist(&self) -> bool {
        TREE && !self.boxes.is_empty()
    }

    pub(crate) fn margins<const N: usize>(&self, at: usize) -> [f32; N] {
        let margins = self.margins.get(at..).and_then(|margins| margins.first_chunk());
        margins.copied().unwrap_or([0.0; N])
    }

    /// What fat boxes have around them at least.
    fn around<const N: usize>(&self, at: usize) -> [f32; N] {
        if self.reports_margins { [0.0; N] } else { self.margins(at) }
    }

    /// In a fat world: of the boxes `given` to some objects, who were reported as `old` and given `last`: who
    /// are reported as or get anything else, a bit each, and what all are reported as.
    #[inline(always)]
    pub(crate) fn report<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        at: usize,
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
            simd.predicted(given, given, &self.margins(at), false, &mut grown);
            bits::of_word(grows).for_each(|bit| to.put(bit, grown.at(bit)));
        }
        (if self.renews { others } else { grows }, to)
    }

    /// Makes the fat box of an object whose motion nobody knows.
    pub(crate) fn anchor(&mut self, at: usize, bounds: &KeyBox) {
        let [around] = self.around(at);
        if self.exist() {
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
        if MARGINS && let Some(given) = given.get_mut(at) {
            let was = core::mem::replace(given, *new);
            (others, to) = self.report(Scalar, at, &[*now], &[was], &[*new]);
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
        Some(self.follow(Scalar, at, &from, &to, 1) != 0)
    }

    /// Gives some objects other boxes, whose bit is set. Returns who stays in the fat box.
    #[inline(always)]
    pub(crate) fn follow<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        at: usize,
        old: &[KeyBox; N],
        new: &[KeyBox; N],
        others: u32,
    ) -> u32 {
        let around = self.around(at);
        let fat = self.boxes.get_mut(at..).and_then(|boxes| boxes.first_chunk_mut());
        let Some(fat) = fat.filter(|_| TREE) else { return 0 };
        let contained = others & simd.inside(fat, new);
        self.outran += if self.reports_margins { 0 } else { (others & !contained).count_ones() };
        let stay = if self.renews { 0 } else { contained };
        if others != stay {
            let mut made = *fat;
            simd.predicted(new, old, &around, TREE && self.predicted, &mut made);
            match others & !stay {
                all if all.count_ones() as usize == N => *fat = made,
                some => bits::of_word(some).for_each(|bit| fat.put(bit, made.at(bit))),
            }
        }
        stay
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
