//! Sorts slots by their minima with a radix sort, in blocks that workers share (erratum E13).

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::SORTED_PER_BLOCK;
use crate::parallel::block_queue::{BlockQueue, Chunks};
use crate::parallel::executor::{self, Executor};
use crate::parallel::shared::Shared;

/// How many entries of a block have each value of a byte; then where the next one of them goes.
pub(crate) type Histogram = [u32; 256];

/// Who sorts.
#[derive(Clone, Copy)]
pub(crate) struct Sharing<'e> {
    pub(crate) executor: &'e dyn Executor,
    pub(crate) workers: usize,
}

#[cfg(test)]
impl Sharing<'static> {
    /// The calling thread alone.
    pub(crate) const NONE: Self = Self { executor: &executor::Serial, workers: 1 };
}

/// A key in the order of unsigned integers, and its slot.
type Entry = [u32; 2];

/// Sorts slots by their minima on an axis, equal ones by slot. `spare` has 4 words a slot; there are as many blocks
/// as `histograms`, at least one. O(n).
pub(crate) fn sort<I: Index>(
    order: &mut [I],
    boxes: &[KeyBox],
    axis: usize,
    spare: &mut [u32],
    histograms: &mut [Histogram],
    sharing: Sharing<'_>,
) {
    let count = order.len();
    let len = count.div_ceil(histograms.len().max(1)).max(SORTED_PER_BLOCK);
    let mut passes = Passes { histograms: histograms.span_mut(0, count.div_ceil(len)), len, sharing };
    let (from, to) = spare.split_at_mut_checked(2 * count).unwrap_or_default();
    let to = to.span_mut(0, 2 * count);
    let (mut from, _) = from.as_chunks_mut::<2>();
    let (mut to, _) = to.as_chunks_mut::<2>();
    passes.each_block(from, order, &|entries, slots| {
        for (entry, slot) in entries.iter_mut().zip(slots) {
            // With the sign bit flipped, keys have the order of unsigned integers.
            let low = boxes.get(slot.at()).map_or(0, |bounds| bounds.min[axis % 3]);
            *entry = [low as u32 ^ 1 << 31, slot.slot()];
        }
    });
    // The sort by key keeps the order of equal keys, so entries are sorted by slot first.
    if !from.is_sorted_by_key(|entry| entry[1]) {
        for shift in [0, 8, 16, 24] {
            (from, to) = passes.distribute(from, to, 1, shift);
        }
    }
    for shift in [0, 8, 16, 24] {
        (from, to) = passes.distribute(from, to, 0, shift);
    }
    passes.each_block(from, order, &|entries, slots| {
        for (slot, entry) in slots.iter_mut().zip(entries) {
            *slot = I::from_slot(entry[1]);
        }
    });
}

struct Passes<'s> {
    /// One for each block.
    histograms: &'s mut [Histogram],
    /// The length of a block.
    len: usize,
    sharing: Sharing<'s>,
}

impl Passes<'_> {
    /// Calls `job` with each block of both slices.
    fn each_block<A: Send, B: Send>(
        &self,
        a: &mut [A],
        b: &mut [B],
        job: &(impl Fn(&mut [A], &mut [B]) + Sync),
    ) {
        let Sharing { executor, workers } = self.sharing;
        let queue = BlockQueue::new((Chunks::new(a, self.len), Chunks::new(b, self.len)));
        executor::run(executor, workers, self.histograms.len(), &|| {
            while let Some((_, (a, b))) = queue.claim() {
                job(a, b);
            }
        });
    }

    /// Calls `job` with each block of entries and its histogram.
    fn each_histogram(
        &mut self,
        entries: &mut [Entry],
        job: &(impl Fn(&mut [Entry], &mut Histogram) + Sync),
    ) {
        let Sharing { executor, workers } = self.sharing;
        let blocks = self.histograms.len();
        let queue = BlockQueue::new((Chunks::new(entries, self.len), Chunks::new(self.histograms, 1)));
        executor::run(executor, workers, blocks, &|| {
            while let Some((_, (entries, histograms))) = queue.claim() {
                histograms.iter_mut().for_each(|histogram| job(entries, histogram));
            }
        });
    }

    /// One stable pass over a byte of word `word`. Returns the sorted entries, and the other buffer.
    fn distribute<'s>(
        &mut self,
        from: &'s mut [Entry],
        to: &'s mut [Entry],
        word: usize,
        shift: u32,
    ) -> (&'s mut [Entry], &'s mut [Entry]) {
        let byte = |entry: &Entry| (entry[word & 1] >> shift & 0xff) as usize;
        self.each_histogram(from, &|entries, histogram| {
            histogram.fill(0);
            for entry in entries {
                histogram[byte(entry)] += 1;
            }
        });
        let mut start = 0;
        for value in 0..256 {
            let first = start;
            for histogram in &mut *self.histograms {
                start += core::mem::replace(&mut histogram[value], start);
            }
            if (start - first) as usize == from.len() {
                return (from, to);
            }
        }
        let target = Shared::new(to);
        self.each_histogram(from, &|entries, histogram| {
            for entry in entries {
                let at = &mut histogram[byte(entry)];
                target.store(*at as usize, entry);
                *at += 1;
            }
        });
        (to, from)
    }
}
