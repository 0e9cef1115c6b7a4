//! What happens to one object when it comes, gets another box, or goes (paper, section III.B; errata E1 to E6).

use crate::access::{Access, bits};
use crate::config::{Margin, Mode};
use crate::key::KeyBox;

/// The arrays of some consecutive slots; positions count from the first of them.
pub(crate) struct Objects<'o> {
    pub(crate) now: &'o mut [KeyBox],
    pub(crate) fat: FatBoxes<'o>,
    pub(crate) moved: &'o mut [u32],
    pub(crate) changed: &'o mut [u32],
    pub(crate) mode: Mode,
}

/// The fat boxes of some consecutive slots; none in a world without margins.
pub(crate) struct FatBoxes<'o> {
    pub(crate) boxes: &'o mut [KeyBox],
    pub(crate) margins: &'o [f32],
    pub(crate) fixed_margins: bool,
    pub(crate) told: Motions,
}

/// What new boxes meant to objects with margins.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motions {
    /// Whether a box changed inside its fat box, which then stays.
    pub(crate) crept: bool,
    /// Boxes that were farther from the last one than the margin.
    pub(crate) outran: u32,
}

impl FatBoxes<'_> {
    /// Follows an object from one box to another one. Returns whether it stays in its fat box, as no object without a
    /// margin does.
    #[inline(always)]
    pub(crate) fn hold(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        !self.boxes.is_empty() && self.follow(at, old, bounds)
    }

    /// As [`hold`](Self::hold), of an object with a margin. Not inline: it is as long as the rest of an intake.
    #[inline(never)]
    fn follow(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        let (fat, margin) = (self.boxes.at(at), self.margins.at(at));
        if fat.contains(bounds) && (self.fixed_margins || !fat.dwarfs(bounds, margin)) {
            self.told.crept = true;
            return true;
        }
        // The last box says how fast the object is: a margin around it would not have held this one either.
        let outran = !self.fixed_margins && !old.grown(margin).contains(bounds);
        self.told.outran += u32::from(outran);
        self.boxes.put(at, bounds.grown(if outran { 0.0 } else { margin }));
        false
    }
}

impl Objects<'_> {
    fn has_margins(&self) -> bool {
        !self.fat.boxes.is_empty()
    }

    /// A new object. It counts as moved once (erratum E6), and as overlapping nothing before.
    pub(crate) fn enter(&mut self, at: usize, bounds: KeyBox) {
        self.now.put(at, bounds);
        if self.has_margins() {
            self.fat.boxes.put(at, bounds.grown(self.fat.margins.at(at)));
        }
        bits::set(self.moved, at);
        self.note_change(at);
    }

    /// A new box.
    pub(crate) fn accept(&mut self, at: usize, bounds: KeyBox) {
        let old = self.now.at(at);
        if bounds != old {
            self.now.put(at, bounds);
            let held = self.fat.hold(at, &old, &bounds);
            self.note(at / 32, 1 << (at % 32), u32::from(held) << (at % 32));
        }
    }

    /// Notes that some objects of a word of the bit sets have other boxes now, and that fat boxes have held some of them.
    #[inline(always)]
    pub(crate) fn note(&mut self, word: usize, changed: u32, held: u32) {
        let moved = changed & !held;
        let reported = if self.mode == Mode::Exact { changed } else { moved };
        for (words, bits) in [(&mut *self.moved, moved), (self.changed, reported)] {
            if let Some(word) = words.get_mut(word) {
                *word |= bits;
            }
        }
    }

    /// Anchors the fat box at the current box anew, as after a move.
    pub(crate) fn anchor(&mut self, at: usize, bounds: KeyBox, margin: f32) {
        if self.mode == Mode::Fat {
            self.note_change(at);
        }
        self.fat.boxes.put(at, bounds.grown(margin));
        bits::set(self.moved, at);
    }

    /// The object goes; `next` is the free slot behind it.
    pub(crate) fn leave(&mut self, at: usize, next: u32) {
        self.note_change(at);
        self.now.put(at, KeyBox::free(next));
        if self.has_margins() {
            self.fat.boxes.put(at, KeyBox::EMPTY);
        }
        bits::set(self.moved, at);
    }

    /// Notes, where there are events, that the reported box is another one.
    #[inline(always)]
    fn note_change(&mut self, at: usize) {
        if !self.changed.is_empty() {
            bits::set(self.changed, at);
        }
    }
}

/// The length that a margin means for a box (erratum E2).
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    (margin.per_extent * bounds.largest_extent()).max(margin.min).min(margin.max)
}
