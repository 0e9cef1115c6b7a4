//! Tells found and lost pairs block by block of leaves, in steps that sweep all leaves, while the boxes are in the
//! cache.
//!
//! The pairs of a block of leaves are divided at once: persisting ones go to the front of a buffer, found ones to its
//! end. Then the pairs that the last complete result has near these leaves are tested against the new boxes. Any
//! division of that result would give the same events; the division by leaves has the boxes in the cache.

use crate::access::Access;
use crate::filter::FILTERS;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::prefetch::EVENT_BOXES_NEAR;
use crate::memory::slab::{BoxParts, Parts, Segments};
use crate::memory::state::{PairState, State};
use crate::pairs::partition::{Apart, Ended, ToFront};
use crate::parallel::block_queue::{BlockQueue, Chunks, Mirrored};
use crate::simd::kernels::Kernels;

/// The boxes that tell found and lost pairs.
#[derive(Clone, Copy)]
pub(crate) struct Boxes<'b> {
    kernels: Kernels,
    /// The boxes that this step reports.
    pub(crate) now: &'b [KeyBox],
    /// The boxes that the last complete step reported.
    pub(crate) before: &'b [KeyBox],
    /// Whether slots may have new objects.
    has_inserted: bool,
}

impl<'b> Boxes<'b> {
    pub(crate) fn new(parts: &'b BoxParts<'_>, state: &State, kernels: Kernels) -> Self {
        let (now, before) = (parts.reported(state.setup.mode()), &*parts.before);
        Self { kernels, now, before, has_inserted: state.objects.has_inserted != 0 }
    }

    /// The boxes to prefetch before a leaf is swept; none if the world is so small that all are in the cache.
    pub(crate) fn far(&self) -> [&'b [KeyBox]; 2] {
        if self.now.len() > EVENT_BOXES_NEAR { [self.before, self.now] } else { [&[], &[]] }
    }

    /// Brings the found pairs among some new ones to the front. Returns how many there are.
    pub(crate) fn found<I: Index>(&self, pairs: &mut [Pair<I>]) -> usize {
        self.kernels.run(ToFront { pairs, test: Apart(self.before) })
    }

    /// Brings the lost pairs among some pairs of the last result to the front. Returns how many there are.
    fn lost<I: Index>(&self, pairs: &mut [Pair<I>]) -> u32 {
        let Self { kernels, now, before, has_inserted } = *self;
        let count = if has_inserted {
            kernels.run(ToFront { pairs, test: Ended { now, before } })
        } else {
            kernels.run(ToFront { pairs, test: Apart(now) })
        };
        count as u32
    }
}

/// Divides the last result among so many blocks of leaves. Returns `false` if this step has to look at all pairs in
/// the end: if not all overlaps are pairs of the result, if filters may answer differently, or if more than three of
/// four pairs were new in the last step, since objects so fast have left their leaf.
pub(crate) fn share_out<I: Index>(parts: &mut Parts<'_, I>, blocks: usize) -> bool {
    let asked = FILTERS && parts.filters.changed.count() > 0;
    let PairState { found, reported, .. } = parts.state.pairs;
    let fast = found / 3 > reported / 4;
    if parts.sizes.event_blocks == 0 || parts.has_surplus() || asked || fast {
        return false;
    }
    let count = parts.state.pairs.previous;
    let segments = &mut parts.output.segments;
    let ends = segments.ends.span(0, 2 * blocks);
    let known = segments.blocks() == blocks
        && ends.is_sorted_by(|a, b| a <= b)
        && ends.last() == Some(&(count as u32));
    if !known {
        // There were other leaves, or the pairs have another order.
        let shares = 2 * blocks as u64;
        for (end, number) in segments.ends.iter_mut().zip(1..=shares) {
            *end = (count * number).checked_div(shares).unwrap_or_default() as u32;
        }
        segments.set_blocks(blocks);
    }
    true
}

/// The last complete result, divided by blocks of leaves.
pub(crate) struct Events<'e, I> {
    pub(crate) boxes: Boxes<'e>,
    previous: &'e mut [Pair<I>],
    // See `Segments`.
    ends: &'e [u32],
    counts: &'e mut [[u32; 2]],
    lost: &'e mut [[u32; 2]],
}

impl<'e, I: Index> Events<'e, I> {
    /// Takes a result that is [divided](share_out).
    pub(crate) fn new(
        boxes: Boxes<'e>,
        previous: &'e mut [Pair<I>],
        segments: &'e mut Segments<'_>,
        state: &State,
    ) -> Self {
        let previous = previous.span_mut(0, state.pairs.previous as usize);
        let ends = segments.ends.span(0, 2 * segments.blocks());
        Self { boxes, previous, ends, counts: segments.counts, lost: segments.lost }
    }

    /// The blocks of leaves.
    pub(crate) fn blocks(&mut self) -> Blocks<'_, I> {
        let Self { boxes, previous, ends, counts, lost } = self;
        let parts = (Mirrored::new(previous, ends), Chunks::new(counts, 1), Chunks::new(lost, 1));
        Blocks { boxes: *boxes, queue: BlockQueue::new(parts) }
    }
}

/// The parts of each block: the segments of the last result, and counts.
type BlockParts<'b, I> = (Mirrored<'b, Pair<I>>, Chunks<'b, [u32; 2]>, Chunks<'b, [u32; 2]>);

/// The queue of all blocks of leaves.
pub(crate) struct Blocks<'b, I> {
    boxes: Boxes<'b>,
    queue: BlockQueue<BlockParts<'b, I>>,
}

impl<I: Index> Blocks<'_, I> {
    /// The next block, and its number.
    pub(crate) fn claim(&self) -> Option<(usize, Block<'_, I>)> {
        let (index, (last, counts, lost)) = self.queue.claim()?;
        Some((index, Block { boxes: self.boxes, last, counts, lost }))
    }
}

/// A block of leaves.
pub(crate) struct Block<'b, I> {
    boxes: Boxes<'b>,
    last: [&'b mut [Pair<I>]; 2],
    counts: &'b mut [[u32; 2]],
    lost: &'b mut [[u32; 2]],
}

impl<I: Index> Block<'_, I> {
    /// Notes how many pairs persist and are found, and looks for lost ones.
    pub(crate) fn finish(self, counts: [u32; 2]) {
        self.counts.fill(counts);
        self.lost.fill(self.last.map(|pairs| self.boxes.lost(pairs)));
    }
}

/// After a complete step whose events were told block by block: brings the lost pairs of all blocks together, and
/// notes how the new result is divided. Returns how many pairs are lost.
pub(crate) fn conclude<I: Index>(parts: &mut Parts<'_, I>) -> usize {
    let blocks = parts.output.segments.blocks();
    let Segments { ends, counts, lost, .. } = &mut parts.output.segments;
    let previous = &mut *parts.output.previous;
    let (mut start, mut end, mut all_lost) = (0, 0, 0);
    for index in 0..2 * blocks {
        // The segments of found pairs are in descending order.
        let found = usize::from(index >= blocks);
        let block = if found == 0 { index } else { 2 * blocks - 1 - index };
        let count = lost.at(block)[found] as usize;
        if start > all_lost {
            // None is overwritten, in case that the step is given up.
            for offset in 0..count {
                previous.swap_at(all_lost + offset, start + offset);
            }
        }
        all_lost += count;
        start = ends.at(index) as usize;
        end += counts.at(block)[found];
        ends.put(index, end);
    }
    all_lost
}
