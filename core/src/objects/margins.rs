//! Fat boxes: an object has moved when its box leaves the fat box around an earlier one (paper, V; E2).
//!
//! A fat box is the box and a margin; or predicted: it also holds the next boxes of an object that goes on.
//! A fat world reports boxes with margins, and its fat boxes are predicted around these.
//! All are made anew at once when some objects have left theirs, so that most steps are quiet. Where they do
//! not last even so, the boxes as given are swept: see [`renew`](crate::step::policy::renew).

use crate::access::{Access, bits};
use crate::config::{FAT, Margin, TREE};
use crate::geometry::key::KeyBox;

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
    pub(crate) motions: Motions,
}

/// What new boxes meant to objects with fat boxes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motions {
    /// Whether a box changed inside its fat box, which stays.
    pub(crate) moved_inside_margin: bool,
    /// Boxes that left their fat boxes.
    pub(crate) outran: u32,
}

impl FatBoxes<'_> {
    /// Whether there are fat boxes in use.
    pub(crate) fn exist(&self) -> bool {
        FAT && !self.boxes.is_empty()
    }

    fn margins<const N: usize>(&self, at: usize) -> [f32; N] {
        let margins = self.margins.get(at..).and_then(|margins| margins.first_chunk());
        margins.copied().unwrap_or([0.0; N])
    }

    /// What fat boxes have around them at least.
    fn around<const N: usize>(&self, at: usize) -> [f32; N] {
        if self.reports_margins { [0.0; N] } else { self.margins(at) }
    }

    /// In a fat world: a box as it is reported.
    pub(crate) fn grown(&self, at: usize, bounds: &KeyBox) -> KeyBox {
        let [margin] = self.margins(at);
        bounds.grown(margin)
    }

    /// In a fat world: makes of the boxes given to some objects, `new`, what these are reported as, who were
    /// reported as `old` and given `last`. Returns whose bit is set among `others` and who are reported as or
    /// get anything else, and from where their reported boxes have come.
    #[inline(always)]
    pub(crate) fn report<const N: usize>(
        &mut self,
        at: usize,
        old: &[KeyBox; N],
        last: &[KeyBox; N],
        new: &mut [KeyBox; N],
        others: u32,
    ) -> (u32, [KeyBox; N]) {
        let given = core::mem::replace(new, *old);
        let grown = KeyBox::grown_by(&given, self.margins(at));
        let left = others & !held(old, &given);
        bits::of_word(left).for_each(|bit| new.put(bit, grown.at(bit)));
        self.motions.outran += left.count_ones();
        let others = if self.renews { others } else { left };
        (others, KeyBox::before(new, last, &given))
    }

    /// Makes the fat box of an object whose motion nobody knows.
    pub(crate) fn anchor(&mut self, at: usize, bounds: &KeyBox) {
        let [around] = self.around(at);
        if self.exist() {
            self.boxes.put(at, bounds.grown(around));
        }
    }

    /// Gives an object another box, which has come from an old one. Returns whether it stays in its fat box.
    /// Not inline, so that the loop around it stays in registers.
    #[inline(never)]
    pub(crate) fn follow_apart(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        self.follow(at, &[*old], &[*bounds], 1) != 0
    }

    /// The same for some objects, whose bit is set. Returns who stays in the fat box.
    #[inline(always)]
    pub(crate) fn follow<const N: usize>(
        &mut self,
        at: usize,
        old: &[KeyBox; N],
        new: &[KeyBox; N],
        others: u32,
    ) -> u32 {
        let around = self.around(at);
        let fat = self.boxes.get_mut(at..).and_then(|boxes| boxes.first_chunk_mut());
        let Some(fat) = fat.filter(|_| FAT) else { return 0 };
        let contained = others & held(fat, new);
        self.motions.outran += if self.reports_margins { 0 } else { (others & !contained).count_ones() };
        let stay = if self.renews { 0 } else { contained };
        self.motions.moved_inside_margin |= stay != 0;
        if others != stay {
            let made = KeyBox::predicted(new, old, around, TREE && self.predicted);
            bits::of_word(others & !stay).for_each(|bit| fat.put(bit, made.at(bit)));
        }
        stay
    }

    /// Whether the box of an object as it is reported in a fat world is far too wide for the one given now.
    pub(crate) fn is_wide(&self, at: usize, reported: &KeyBox, bounds: &KeyBox) -> bool {
        let [margin] = self.margins(at);
        is_wide(reported, bounds, margin)
    }

    /// Forgets a fat box that has become far too wide for a box, which is to get one around it then.
    pub(crate) fn forget_wide(&mut self, at: usize, bounds: &KeyBox) {
        let [around] = self.around(at);
        if self.exist() && is_wide(&self.boxes.at(at), bounds, around) {
            self.boxes.put(at, KeyBox::EMPTY);
        }
    }
}

/// Which of some boxes are inside others.
#[inline(always)]
fn held<const N: usize>(boxes: &[KeyBox; N], inner: &[KeyBox; N]) -> u32 {
    let each = boxes.iter().zip(inner).enumerate();
    each.fold(0, |held, (bit, (bounds, inner))| held | u32::from(bounds.contains(inner)) << bit)
}

/// A box around another one so many times as wide as that and its margin is far too wide. No predicted one
/// is at first.
const MOST_WIDTH: f32 = 16.0;

/// Whether what is around a box is far too wide.
fn is_wide(around: &KeyBox, bounds: &KeyBox, margin: f32) -> bool {
    around.largest_extent() > MOST_WIDTH * (bounds.largest_extent() + margin)
}

/// The most that the size of a box counts, in its smallest sides: a wide plane needs no wide margin.
const FLATTEST: f32 = 8.0;

/// The length of a margin for a box (erratum E2). An unbounded box counts as size zero.
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    let (largest, smallest) = (bounds.largest_extent(), bounds.smallest_extent());
    let size = if largest > f32::MAX { 0.0 } else { largest.min(FLATTEST * smallest) };
    (margin.per_extent * size).max(margin.min).min(margin.max)
}
