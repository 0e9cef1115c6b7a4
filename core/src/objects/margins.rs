//! Fat boxes: an object has moved when its box leaves the fat box around an earlier one (paper, V; E2).
//!
//! A fat box is the box and a margin; or predicted: it also holds the next boxes of an object that goes on.
//! All are made anew at once when some objects have left theirs, so that most steps are quiet. Where they do
//! not last even so, the boxes as given are swept: see [`renew`](crate::step::policy::renew).

use crate::access::{Access, bits};
use crate::config::{FAT, Margin, Mode, TREE};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;

/// The fat boxes of some consecutive slots; none if there are none in use.
pub(crate) struct FatBoxes<'o> {
    pub(crate) boxes: &'o mut [KeyBox],
    /// What is around each box at least; none if the caller has given no margin.
    pub(crate) margins: &'o [f32],
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

    /// The box of an object whose overlaps a result has; `now` is its box as given.
    pub(crate) fn reported(&self, mode: Mode, at: usize, now: &KeyBox) -> KeyBox {
        if mode == Mode::Fat && self.exist() { self.boxes.at(at) } else { *now }
    }

    fn margin(&self, at: usize) -> f32 {
        self.margins.get(at).copied().unwrap_or_default()
    }

    /// Makes the fat box of an object whose motion nobody knows.
    pub(crate) fn anchor(&mut self, at: usize, bounds: &KeyBox) {
        self.boxes.put(at, bounds.grown(self.margin(at)));
    }

    /// Gives an object another box. Returns whether it stays in its fat box.
    #[inline(always)]
    pub(crate) fn follow(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        let contained = KeyBox::of(self.boxes, at).contains(bounds);
        self.motions.outran += u32::from(!contained);
        if contained && !self.renews {
            self.motions.moved_inside_margin = true;
            return true;
        }
        self.boxes.put(at, Self::made(TREE && self.predicted, self.margin(at), old, bounds));
        false
    }

    /// The same, not inline, so that the loop around it stays in registers.
    #[inline(never)]
    pub(crate) fn follow_apart(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        self.follow(at, old, bounds)
    }

    /// The same for those of four objects whose bit is set, where all get predicted boxes. Returns whether it
    /// has done so.
    #[inline(always)]
    pub(crate) fn renew_four(
        &mut self,
        at: usize,
        old: &[KeyBox; 4],
        new: &[KeyBox; 4],
        others: u32,
    ) -> bool {
        let four = self.boxes.get_mut(at..).and_then(|boxes| boxes.first_chunk_mut::<4>());
        let Some(fat) = four.filter(|_| TREE && self.predicted && self.renews) else { return false };
        let margins = self.margins.get(at..).and_then(|margins| margins.first_chunk());
        let next = KeyBox::predicted(new, old, margins.copied().unwrap_or_default());
        for (bit, (fat, new)) in fat.iter().zip(new).enumerate() {
            self.motions.outran += others >> bit & u32::from(!fat.contains(new));
        }
        if others == 0b1111 {
            *fat = next;
        } else {
            bits::of_word(others).for_each(|bit| fat.put(bit, *KeyBox::of(&next, bit)));
        }
        true
    }

    /// Forgets a fat box that has become far too wide for a box, which is to get one around it then.
    pub(crate) fn forget_wide(&mut self, at: usize, bounds: &KeyBox) {
        let most = MOST_WIDTH * (bounds.largest_extent() + self.margin(at));
        if self.exist() && self.boxes.at(at).largest_extent() > most {
            self.boxes.put(at, KeyBox::EMPTY);
        }
    }

    /// The fat box of an object that has come from an old box.
    #[inline(always)]
    pub(crate) fn made(predicts: bool, margin: f32, old: &KeyBox, bounds: &KeyBox) -> KeyBox {
        if !predicts {
            return bounds.grown(margin);
        }
        let [fat] = KeyBox::predicted(&[*bounds], &[*old], [margin]);
        fat
    }
}

/// Leaves fat boxes unused from now on. Objects that had another one count as moved. O(slots).
pub(crate) fn leave_unused<I: Index>(parts: &mut Parts<'_, I>) {
    for slot in 0..parts.state.objects.slots as usize {
        let now = parts.boxes.now.at(slot);
        if !now.is_empty() && parts.boxes.fat.at(slot) != now {
            parts.objects().touch(slot);
        }
    }
    parts.boxes.tight = true;
    parts.state.tree.unweighed = 1;
}

/// Uses fat boxes again. An object has another one than its box from its next box on. O(slots).
pub(crate) fn use_again<I: Index>(parts: &mut Parts<'_, I>) {
    let slots = parts.state.objects.slots as usize;
    for (fat, now) in parts.boxes.fat.iter_mut().zip(parts.boxes.now.span(0, slots)) {
        *fat = if now.is_empty() { KeyBox::EMPTY } else { *now };
    }
    parts.boxes.tight = false;
    // What planes are worth is told by steps of such boxes alone, from the next one on.
    parts.state.tree.unweighed = 2;
}

/// A fat box so many times as wide as the box and its margin is far too wide. No predicted one is at first.
const MOST_WIDTH: f32 = 16.0;

/// The most that the size of a box counts, in its smallest sides: a wide plane needs no wide margin.
const FLATTEST: f32 = 8.0;

/// The length of a margin for a box (erratum E2). An unbounded box counts as size zero.
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    let (largest, smallest) = (bounds.largest_extent(), bounds.smallest_extent());
    let size = if largest > f32::MAX { 0.0 } else { largest.min(FLATTEST * smallest) };
    (margin.per_extent * size).max(margin.min).min(margin.max)
}
