//! Sets of slots. The time to find the members depends on their number, and hardly on the number of slots.

use crate::access::{Access, bits};
use crate::config::TREE;
use crate::id::Index;
use crate::parallel::block_queue::Chunks;

/// Slots in a group. Workers of a pass get whole groups.
pub(crate) const GROUP: usize = 32 * 32;

/// A set of slots, or of some consecutive slots, counted from the first of them.
pub(crate) struct SlotSet<'m> {
    /// One bit a slot.
    pub(crate) words: &'m mut [u32],
    /// One bit for each word, set if the word has bits: 1,024 slots without members are passed over at once.
    pub(crate) groups: &'m mut [u32],
}

impl<'m> SlotSet<'m> {
    /// The words of memory for so many slots.
    pub(crate) const fn len(slots: usize) -> usize {
        bits::words(slots) + if TREE { slots.div_ceil(GROUP) } else { 0 }
    }

    /// The same set, borrowed.
    pub(crate) fn reborrow(&mut self) -> SlotSet<'_> {
        SlotSet { words: self.words, groups: self.groups }
    }

    /// The same set in parts of so many slots: whole groups.
    pub(crate) fn blocks(&mut self, slots: usize) -> (Chunks<'_, u32>, Chunks<'_, u32>) {
        (Chunks::optional(self.words, slots / 32), Chunks::optional(self.groups, slots / GROUP))
    }

    /// Adds a slot.
    pub(crate) fn set(&mut self, slot: usize) {
        self.add(slot / 32, 1 << (slot % 32));
    }

    /// Adds slots of one word. Does nothing if the world does not keep this set.
    pub(crate) fn add(&mut self, word: usize, bits: u32) {
        if let Some(to) = self.words.get_mut(word) {
            *to |= bits;
        }
        if TREE && let Some(group) = self.groups.get_mut(word / 32) {
            *group |= u32::from(bits != 0) << (word % 32);
        }
    }

    /// Takes all slots out.
    pub(crate) fn clear(&mut self) {
        if !TREE {
            // Few words, most of which are clear: less than a call.
            return self.words.iter_mut().filter(|word| **word != 0).for_each(|word| *word = 0);
        }
        for (group, words) in self.groups.iter_mut().zip(self.words.chunks_mut(32)) {
            if *group != 0 {
                *group = 0;
                words.fill(0);
            }
        }
    }

    /// Takes all slots out and adds them to another set, if the world keeps that.
    pub(crate) fn move_to(&mut self, other: &mut SlotSet<'_>) {
        let to = other.groups.iter_mut().zip(other.words.chunks_mut(32));
        for ((group, words), to) in self.groups.iter_mut().zip(self.words.chunks_mut(32)).zip(to) {
            if *group != 0 {
                *to.0 |= core::mem::take(group);
                to.1.iter_mut().zip(words).for_each(|(to, word)| *to |= core::mem::take(word));
            }
        }
        self.clear();
    }

    /// Calls a function with the number and the bits of each word that has some, and maybe of others.
    #[inline(always)]
    pub(crate) fn for_each_word(&self, mut each: impl FnMut(usize, u32)) {
        if !TREE {
            return (0..).zip(&*self.words).for_each(|(index, word)| each(index, *word));
        }
        for (group, (bits, words)) in self.groups.iter().zip(self.words.chunks(32)).enumerate() {
            if *bits == u32::MAX {
                // No look at single bits where nearly all slots are members.
                words.iter().enumerate().for_each(|(bit, word)| each(group * 32 + bit, *word));
            } else {
                bits::of_word(*bits).for_each(|bit| each(group * 32 + bit, words.at(bit)));
            }
        }
    }

    /// Writes the slots in ascending order to the front of `list` and returns how many there are.
    #[inline(always)]
    pub(crate) fn list<I: Index>(&self, list: &mut [I]) -> usize {
        let mut count = 0;
        self.for_each_word(|index, word| {
            for bit in bits::of_word(word) {
                list.put(count, I::from_slot((index * 32 + bit) as u32));
                count += 1;
            }
        });
        count
    }

    /// The first slot from one on.
    #[inline(never)]
    pub(crate) fn first_from(&self, slot: usize) -> Option<usize> {
        let mut word = slot / 32;
        let mut bits = self.words.get(word)? & u32::MAX << (slot % 32);
        while bits == 0 {
            word += 1;
            while word.is_multiple_of(32) && self.groups.get(word / 32) == Some(&0) {
                word += 32;
            }
            bits = *self.words.get(word)?;
        }
        Some(word * 32 + bits.trailing_zeros() as usize)
    }

    /// How many slots there are.
    // Not inline: its loop would take registers from the loops around it, 3 % of a step on a Cortex-M4.
    #[inline(never)]
    pub(crate) fn count(&self) -> u32 {
        let mut count = 0;
        self.for_each_word(|_, word| count += word.count_ones());
        count
    }
}
