//! Sweep-and-prune (paper, section IV), and how the pairs of many workers become one list.
//!
//! Work is cut into blocks by counts alone. One worker writes pairs straight to where they belong; several write
//! them to chunks, which are then put in the order of their blocks, so that the bytes are the same.

pub(crate) mod bucket;
mod flat;
pub(crate) mod leaves;
pub(crate) mod movers;
mod rounds;
mod scan;
pub(crate) mod small;
pub(crate) mod stripes;

use crate::access::Access;
use crate::id::{Index, Pair};
use crate::memory::layout::Sizes;
use crate::memory::limits::CHUNK;
use crate::memory::scratch::{self, Scratch, Work};
use crate::memory::slab::OutputParts;
use crate::memory::state::State;
use crate::pairs::events::{Block, Blocks, Boxes, Events};
pub(crate) use crate::pairs::pair_filter::Sink;
use crate::pairs::pair_filter::{Filtered, PairFilter};
use crate::parallel::block_queue::{BlockQueue, Chunks, Indices, Pool};
use crate::parallel::executor::{self, Executor};
use crate::tree::Record;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Pairs in their final order, but that found ones come from the end of the buffer, backwards. Counts on when it is full.
struct Ordered<'o, I> {
    pairs: &'o mut [Pair<I>],
    /// Pairs that were taken, whether they fitted or not.
    count: u64,
    /// What tells found pairs.
    boxes: Option<Boxes<'o>>,
    /// Persisting pairs and found ones; none where nothing tells them.
    told: [usize; 2],
}

impl<I: Index> Sink<I> for Ordered<'_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        if let Some(boxes) = self.boxes {
            let [persisting, found] = &mut self.told;
            let room = self.pairs.get_mut(*persisting..self.pairs.len() - *found).unwrap_or_default();
            let fitting = pairs.len().min(room.len());
            let stay = boxes.divide(pairs.span(0, fitting), room);
            *persisting += stay;
            *found += fitting - stay;
        } else {
            let start = usize::try_from(self.count).unwrap_or(usize::MAX);
            if let Some(room) = self.pairs.get_mut(start..) {
                room.copy_in(pairs);
            }
        }
        self.count += pairs.len() as u64;
    }
}

/// The blocks of a sweep, in the order in which they are claimed.
enum Claims<'b, I> {
    Plain(Indices),
    /// With events that are told block by block.
    Told(Blocks<'b, I>),
}

impl<I: Index> Claims<'_, I> {
    fn claim(&self) -> Option<(usize, Option<Block<'_, I>>)> {
        match self {
            Self::Plain(indices) => indices.claim().map(|index| (index, None)),
            Self::Told(blocks) => blocks.claim().map(|(index, block)| (index, Some(block))),
        }
    }
}

/// Sweeps one block of leaves.
type BlockWork<'w, I> = dyn Fn(usize, &mut Scratch<'_, I>, &mut dyn Sink<I>) + Sync + 'w;
/// A chunk of staged pairs and its entry in the table.
type StagedChunk<'s, I> = (&'s mut [Pair<I>], &'s mut [[u32; 3]]);
/// All of them.
type StagedChunks<'o, I> = (Chunks<'o, Pair<I>>, Chunks<'o, [u32; 3]>);

/// The buffers that pairs are collected in.
pub(crate) struct Collector<'o, I> {
    pub(crate) pairs: &'o mut [Pair<I>],
    pub(crate) staged: &'o mut [Pair<I>],
    /// Block, position and length of each chunk.
    pub(crate) chunks: &'o mut [[u32; 3]],
    pub(crate) scratch: &'o mut [Record],
    pub(crate) bucket: usize,
    workers: usize,
    /// Asked about every pair.
    pub(crate) pair_filter: Option<PairFilter<'o>>,
    /// What tells the events, where that is done block by block.
    events: Option<Events<'o, I>>,
    /// How many pairs are found then.
    pub(crate) found: u64,
}

impl<'o, I: Index> Collector<'o, I> {
    pub(crate) fn new(
        output: &'o mut OutputParts<'_, I>,
        sizes: &Sizes,
        pair_filter: Option<PairFilter<'o>>,
    ) -> Self {
        let OutputParts { pairs, staged, chunks, scratch, .. } = output;
        let (bucket, workers) = (sizes.bucket, sizes.workers);
        Self { pairs, staged, chunks, scratch, bucket, workers, pair_filter, events: None, found: 0 }
    }

    /// The same for a step that tells its events block by block: found pairs stand behind the others.
    pub(crate) fn with_events(
        output: &'o mut OutputParts<'_, I>,
        sizes: &Sizes,
        pair_filter: Option<PairFilter<'o>>,
        boxes: Boxes<'o>,
        state: &State,
    ) -> Self {
        let OutputParts { pairs, previous, segments, staged, chunks, scratch, .. } = output;
        let (bucket, workers) = (sizes.bucket, sizes.workers);
        let events = Some(Events::new(boxes, previous, segments, state));
        Self { pairs, staged, chunks, scratch, bucket, workers, pair_filter, events, found: 0 }
    }

    /// What tells found pairs, and the blocks of a sweep.
    fn claims<'e>(
        events: &'e mut Option<Events<'o, I>>,
        blocks: usize,
    ) -> (Option<Boxes<'o>>, Claims<'e, I>) {
        match events {
            Some(events) => (Some(events.boxes), Claims::Told(events.blocks())),
            None => (None, Claims::Plain(Indices::new(blocks))),
        }
    }

    /// Does `blocks` blocks of work and appends their pairs in block order to the first `from` pairs. Returns
    /// how many pairs there are now, whether they fit or not.
    pub(crate) fn collect(
        &mut self,
        executor: &dyn Executor,
        from: u64,
        blocks: usize,
        work: &BlockWork<'_, I>,
    ) -> (u64, Work) {
        let area = scratch::records::<I>(self.bucket);
        scratch::reset(self.scratch, area);
        let pair_filter = self.pair_filter;
        let work = &|block: usize, scratch: &mut Scratch<'_, I>, sink: &mut dyn Sink<I>| match &pair_filter {
            Some(pair_filter) => work(block, scratch, &mut Filtered { pair_filter, sink }),
            None => work(block, scratch, sink),
        };
        let countable = self.pairs.len() <= i32::MAX as usize;
        let shared = executor.workers() > 1 && blocks > 1 && countable && !self.staged.is_empty();
        let count = if shared { self.in_parallel(executor, from, blocks, work) } else { None };
        let count = count.unwrap_or_else(|| {
            let (boxes, claims) = Self::claims(&mut self.events, blocks);
            let mut sink = Ordered { pairs: self.pairs, count: from, boxes, told: [0; 2] };
            let mut scratch = Scratch::carve(self.scratch.get_mut(..area).unwrap_or_default(), self.bucket);
            while let Some((index, block)) = claims.claim() {
                let [persisting, found] = sink.told;
                work(index, &mut scratch, &mut sink);
                if let Some(block) = block {
                    block.finish([(sink.told[0] - persisting) as u32, (sink.told[1] - found) as u32]);
                }
            }
            scratch.finish();
            let (count, [persisting, found]) = (sink.count, sink.told);
            self.found = found as u64;
            close_gap(self.pairs, persisting, found);
            count
        });
        (count, scratch::work(self.scratch, area))
    }

    /// `None` where the chunks did not suffice, which can only be when the pairs nearly fill their buffer.
    fn in_parallel(
        &mut self,
        executor: &dyn Executor,
        from: u64,
        blocks: usize,
        work: &BlockWork<'_, I>,
    ) -> Option<u64> {
        let area = scratch::records::<I>(self.bucket);
        let full = AtomicBool::new(false);
        let (boxes, claims) = Self::claims(&mut self.events, blocks);
        let chunks = BlockQueue::new((Chunks::new(self.staged, CHUNK), Chunks::new(self.chunks, 1)));
        let pool = Pool::new(self.scratch, area);
        executor::run(executor, pool.count(), blocks, &|| {
            let Some(mut borrowed) = pool.borrow() else { return };
            let mut scratch = Scratch::carve(borrowed.area(), self.bucket);
            while let Some((index, block)) = claims.claim() {
                let (chunks, full, told) = (&chunks, &full, [0; 2]);
                let mut sink = Staged { chunks, full, block: index as u32, chunk: None, boxes, told };
                work(index, &mut scratch, &mut sink);
                let told = sink.told;
                if let Some(block) = block {
                    block.finish(told);
                }
            }
            scratch.finish();
        });
        let used = chunks.claimed();
        let merged = if full.load(Relaxed) { None } else { self.merge(executor, from, used) };
        if merged.is_none() {
            // The blocks are swept once more, so what was counted must not count twice.
            scratch::reset(self.scratch, area);
        }
        merged
    }

    /// Puts the staged chunks in the order of their blocks. A block's chunks were claimed by one worker, so they
    /// stand in the order in which it filled them. `None` where there are found pairs and not all fit: it takes the order of
    /// all pairs to tell which ones do.
    fn merge(&mut self, executor: &dyn Executor, from: u64, used: usize) -> Option<u64> {
        let chunks = self.chunks.span_mut(0, used);
        insertion_sort(chunks);
        // The block and the counts are not needed any more. These places now have where the two ends of the chunk end among all
        // pairs.
        let [mut persisting, mut found] = [0; 2];
        for [block, _, counts] in &mut *chunks {
            let [stay, come] = two_counts(*counts);
            persisting += stay as u32;
            found += come as u32;
            (*block, *counts) = (persisting, found);
        }
        let (chunks, staged) = (&*chunks, &*self.staged);
        let room = self.pairs.get_mut(from as usize..).unwrap_or_default();
        let count = persisting as usize + found as usize;
        if found > 0 && count > room.len() {
            return None;
        }
        let persisting = room.len().min(persisting as usize);
        let (room, behind) = room.split_at_mut_checked(persisting).unwrap_or_default();
        let claims = BlockQueue::new(Chunks::new(room, MERGED));
        executor::run(executor, self.workers, persisting.div_ceil(MERGED), &|| {
            while let Some((block, room)) = claims.claim() {
                gather(chunks, staged, block * MERGED, room);
            }
        });
        let mut rest = behind.span_mut(0, found as usize);
        let mut end = found as usize;
        for (at, &[_, index, _]) in chunks.iter().enumerate().rev() {
            let start = at.checked_sub(1).map_or(0, |last| chunks.at(last)[2]) as usize;
            let (now, later) =
                core::mem::take(&mut rest).split_at_mut_checked(end - start).unwrap_or_default();
            now.copy_in(staged.span((index as usize + 1) * CHUNK - (end - start), end - start));
            (rest, end) = (later, start);
        }
        self.found = u64::from(found);
        Some(from + count as u64)
    }
}

/// How many persisting pairs a chunk has at its front, and how many found ones at its end: one number, as neither is above
/// [`CHUNK`].
const fn two_counts(counts: u32) -> [usize; 2] {
    [(counts & 0xffff) as usize, (counts >> 16) as usize]
}

/// Brings the found pairs at the end of a buffer to those at its front.
fn close_gap<I: Index>(pairs: &mut [Pair<I>], persisting: usize, found: usize) {
    let start = pairs.len() - found;
    if start > persisting {
        for offset in 0..found {
            pairs.put(persisting + offset, pairs.at(start + offset));
        }
    }
}

/// Pairs that a worker puts in order at a time.
const MERGED: usize = 16 * CHUNK;

/// Fills `room` with the pairs from number `from` on, found ones apart: `chunks` has where each chunk ends, and its position.
fn gather<I: Index>(chunks: &[[u32; 3]], staged: &[Pair<I>], mut from: usize, mut room: &mut [Pair<I>]) {
    let first = chunks.partition_point(|chunk| chunk[0] as usize <= from);
    let mut start = first.checked_sub(1).map_or(0, |last| chunks.at(last)[0]) as usize;
    for &[end, index, _] in chunks.get(first..).unwrap_or_default() {
        let left = end as usize - from;
        let pairs = staged.span(index as usize * CHUNK + from - start, left.min(room.len()));
        let (now, later) = core::mem::take(&mut room).split_at_mut_checked(pairs.len()).unwrap_or_default();
        now.copy_in(pairs);
        from += pairs.len();
        start = end as usize;
        room = later;
        if room.is_empty() {
            return;
        }
    }
}

/// Sorts what is nearly in order: workers claim blocks and chunks in ascending order.
fn insertion_sort(chunks: &mut [[u32; 3]]) {
    for index in 1..chunks.len() {
        let chunk = chunks.at(index);
        let mut to = index;
        while to > 0 && chunks.at(to - 1) > chunk {
            chunks.put(to, chunks.at(to - 1));
            to -= 1;
        }
        chunks.put(to, chunk);
    }
}

/// The staged pairs of one block, in as many chunks as they need. In each, found pairs come from its end, backwards.
struct Staged<'s, 'o, I> {
    chunks: &'s BlockQueue<StagedChunks<'o, I>>,
    full: &'s AtomicBool,
    block: u32,
    chunk: Option<StagedChunk<'s, I>>,
    /// What tells found pairs.
    boxes: Option<Boxes<'s>>,
    /// Persisting pairs of the block and found ones; all persist where nothing tells them.
    told: [u32; 2],
}

impl<I: Index> Sink<I> for Staged<'_, '_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut pairs = &*pairs;
        while !pairs.is_empty() {
            let Some((room, [entry])) = &mut self.chunk else {
                let Some((index, (room, entry))) = self.chunks.claim() else {
                    return self.full.store(true, Relaxed);
                };
                entry.fill([self.block, index as u32, 0]);
                self.chunk = Some((room, entry));
                continue;
            };
            let [stay, come] = two_counts(entry[2]);
            let free = room.len() - stay - come;
            let (now, later) = pairs.split_at(pairs.len().min(free));
            let room = room.span_mut(stay, free);
            let stay = match self.boxes {
                Some(boxes) => boxes.divide(now, room),
                None => {
                    room.copy_in(now);
                    now.len()
                }
            };
            let come = now.len() - stay;
            entry[2] += (stay | come << 16) as u32;
            self.told[0] += stay as u32;
            self.told[1] += come as u32;
            pairs = later;
            if now.len() == free {
                self.chunk = None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn chunks_come_into_the_order_of_blocks_whoever_claimed_them() {
        // All orders of six chunks, of which two are of one block.
        for number in 0..720 {
            let (mut left, mut chunks, mut rest) = (
                Vec::from([[0, 1, 7], [0, 3, 0], [1, 0, 9], [2, 2, 2], [5, 4, 1], [6, 5, 1]]),
                Vec::new(),
                number,
            );
            while !left.is_empty() {
                chunks.push(left.remove(rest % left.len()));
                rest /= left.len() + 1;
            }
            insertion_sort(&mut chunks);
            assert_eq!(chunks, [[0, 1, 7], [0, 3, 0], [1, 0, 9], [2, 2, 2], [5, 4, 1], [6, 5, 1]]);
        }
    }
}
