//! Brings new boxes to the records of the tree as they are taken in: most objects stay in their leaf, and
//! then the record is where it was.

use crate::access::bits;
use crate::geometry::key::KeyBox;
use crate::geometry::record::{Frame, Record};
use crate::id::Index;
use crate::memory::leaf::{Cell, Leaf};
use crate::parallel::shared::Shared;
use crate::simd::Simd;

/// The leaves, and where the records of some consecutive slots stand in them.
pub(crate) struct Records<'b, 's, I> {
    /// The first of these slots.
    pub(crate) first: usize,
    pub(crate) homes: &'b [I],
    pub(crate) places: &'b [I],
    pub(crate) cells: &'b [Cell],
    pub(crate) frames: &'b [Frame],
    pub(crate) leaves: &'b [Leaf],
    pub(crate) records: Shared<'s, Record>,
    /// Those that have left their leaf, or have none, are noted here.
    pub(crate) left: &'b mut [I],
    pub(crate) noted: u32,
}

impl<I: Index> Records<'_, '_, I> {
    /// Some objects of a word of the bit sets have other swept boxes: `swept`, from the word's first on.
    #[inline(always)]
    pub(crate) fn settle<S: Simd>(&mut self, simd: S, word: usize, moved: u32, swept: &[KeyBox]) {
        let Self { first, homes, places, cells, frames, leaves, records, .. } = *self;
        let (homes, places) =
            (homes.get(word * 32..).unwrap_or_default(), places.get(word * 32..).unwrap_or_default());
        // Of one length, so that one check of an index serves all. Fat boxes are more: one for each slot.
        let (count, leaf_count) = (homes.len().min(32), cells.len());
        let (Some(homes), Some(places), Some(swept)) =
            (homes.get(..count), places.get(..count), swept.get(..count))
        else {
            return;
        };
        let (Some(frames), Some(leaves)) = (frames.get(..leaf_count), leaves.get(..leaf_count)) else {
            return;
        };
        for bit in bits::of_word(moved) {
            let (Some(&home), Some(&place), Some(bounds)) = (homes.get(bit), places.get(bit), swept.get(bit))
            else {
                return;
            };
            let slot = (first + word * 32 + bit) as u32;
            let mut stays = false;
            if let (Some(cell), Some(frame), Some(leaf)) =
                (cells.get(home.at()), frames.get(home.at()), leaves.get(home.at()))
            {
                let keys = simd.keys(bounds);
                let classified = cell.classify(simd, keys);
                // Also of one that leaves: it is moved anyway.
                let record = simd.record(frame, keys, slot | classified.marks());
                records.store(leaf.start as usize + place.at(), &record);
                stays = classified.is_member();
            }
            // Written always, kept or not, so that nothing depends on a guess of the branch predictor.
            if let Some(left) = self.left.get_mut(self.noted as usize) {
                *left = I::from_slot(slot);
            }
            self.noted += u32::from(!stays);
        }
    }
}
