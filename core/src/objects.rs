//! What happens to one object when it comes, gets another box, or goes (paper, section III.B; errata E1 to E6).

use crate::access::{Access, bits};
use crate::config::{Margin, Mode};
use crate::key::KeyBox;

/// The arrays of some consecutive slots; positions count from the first of them.
pub(crate) struct Objects<'o> {
    pub(crate) now: &'o mut [KeyBox],
    pub(crate) fat: &'o mut [KeyBox],
    pub(crate) margins: &'o [f32],
    pub(crate) moved: &'o mut [u32],
    pub(crate) changed: &'o mut [u32],
    pub(crate) mode: Mode,
}

impl Objects<'_> {
    fn has_margins(&self) -> bool {
        !self.fat.is_empty()
    }

    /// A new object. It counts as moved once (erratum E6), and as overlapping nothing before.
    pub(crate) fn enter(&mut self, at: usize, bounds: KeyBox) {
        self.now.put(at, bounds);
        if self.has_margins() {
            self.fat.put(at, bounds.grown(self.margins.at(at)));
        }
        bits::set(self.moved, at);
        self.note_change(at);
    }

    /// A new box. Returns whether the object crept.
    pub(crate) fn accept(&mut self, at: usize, bounds: KeyBox) -> bool {
        if bounds == self.now.at(at) {
            return false;
        }
        self.now.put(at, bounds);
        self.follow(at / 32, 1 << (at % 32))
    }

    /// Notes that some objects of a word of the bit sets have other boxes now. Returns whether one of them crept: its box
    /// changed inside the fat box, which then stays.
    #[inline(always)]
    pub(crate) fn follow(&mut self, word: usize, changed: u32) -> bool {
        let mut moved = changed;
        if self.has_margins() {
            for bit in bits::ones(&[changed]) {
                let at = word * 32 + bit;
                let bounds = self.now.at(at);
                if self.fat.at(at).contains(&bounds) {
                    moved &= !(1 << bit);
                } else {
                    self.fat.put(at, bounds.grown(self.margins.at(at)));
                }
            }
        }
        let reported = if self.mode == Mode::Exact { changed } else { moved };
        for (words, bits) in [(&mut *self.moved, moved), (self.changed, reported)] {
            if let Some(word) = words.get_mut(word) {
                *word |= bits;
            }
        }
        moved != changed
    }

    /// Anchors the fat box at the current box anew, as after a move.
    pub(crate) fn anchor(&mut self, at: usize, bounds: KeyBox) {
        if self.mode == Mode::Fat {
            self.note_change(at);
        }
        self.fat.put(at, bounds.grown(self.margins.at(at)));
        bits::set(self.moved, at);
    }

    /// The object goes; `next` is the free slot behind it.
    pub(crate) fn leave(&mut self, at: usize, next: u32) {
        self.note_change(at);
        self.now.put(at, KeyBox::free(next));
        if self.has_margins() {
            self.fat.put(at, KeyBox::EMPTY);
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
