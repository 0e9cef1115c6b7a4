//! Sweeps boxes for overlaps (paper, section IV), and makes one list of the pairs of many workers.
//!
//! Work is cut into blocks by counts alone. One worker writes pairs straight to their places. Several workers write
//! them to chunks, which are then put in the order of their blocks, so the bytes are the same.

pub(crate) mod bucket;
mod flat;
pub(crate) mod kinds;
pub(crate) mod leaves;
pub(crate) mod movers;
mod rounds;
mod scan;
pub(crate) mod small;

use crate::access::Access;
use crate::id::{Index, Pair};
use crate::memory::layout::Sizes;
use crate::memory::limits::{CHUNK, MERGED};
use crate::memory::scratch::{self, Scratch, Work};
use crate::memory::slab::OutputParts;
pub(crate) use crate::pairs::pair_filter::Sink;
use crate::pairs::pair_filter::{Filtered, PairFilter};
use crate::parallel::block_queue::{BlockQueue, Chunks, Pool};
use crate::parallel::executor::{self, Executor};
use crate::tree::Record;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Writes pairs in their final order. Goes on counting when it is full.
struct Ordered<'o, I> {
    pairs: &'o mut [Pair<I>],
    /// Pairs taken, whether there was room or not.
    count: u64,
}

impl<I: Index> Sink<I> for Ordered<'_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let start = usize::try_from(self.count).unwrap_or(usize::MAX);
        if let Some(room) = self.pairs.get_mut(start..) {
            room.copy_in(pairs);
        }
        self.count += pairs.len() as u64;
    }
}

/// Sweeps one block of leaves.
type BlockWork<'w, I> = dyn Fn(usize, &mut Scratch<'_, I>, &mut dyn Sink<I>) + Sync + 'w;
/// A chunk of staged pairs and its entry in the table.
type StagedChunk<'s, I> = (&'s mut [Pair<I>], &'s mut [[u32; 3]]);
/// All chunks and their entries.
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
    /// Asked about each pair.
    pub(crate) pair_filter: Option<PairFilter<'o>>,
}

impl<'o, I: Index> Collector<'o, I> {
    pub(crate) fn new(
        output: &'o mut OutputParts<'_, I>,
        sizes: &Sizes,
        pair_filter: Option<PairFilter<'o>>,
    ) -> Self {
        let OutputParts { pairs, staged, chunks, scratch, .. } = output;
        let (bucket, workers) = (sizes.bucket, sizes.workers);
        Self { pairs, staged, chunks, scratch, bucket, workers, pair_filter }
    }

    /// Does all blocks of work and appends their pairs, in the order of the blocks, to the first `from` pairs.
    /// Returns how many pairs there are now, whether they fit or not.
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
        let count =
            if executor::THREADS && shared { self.in_parallel(executor, from, blocks, work) } else { None };
        let count = count.unwrap_or_else(|| {
            let mut sink = Ordered { pairs: self.pairs, count: from };
            let mut scratch = Scratch::carve(self.scratch.get_mut(..area).unwrap_or_default(), self.bucket);
            (0..blocks).for_each(|block| work(block, &mut scratch, &mut sink));
            scratch.finish();
            sink.count
        });
        (count, scratch::work(self.scratch, area))
    }

    /// `None`, as soon as the chunks do not suffice, which can only be if the pairs nearly fill their buffer.
    fn in_parallel(
        &mut self,
        executor: &dyn Executor,
        from: u64,
        blocks: usize,
        work: &BlockWork<'_, I>,
    ) -> Option<u64> {
        let area = scratch::records::<I>(self.bucket);
        let full = AtomicBool::new(false);
        let queue = BlockQueue::new(blocks);
        let chunks = BlockQueue::new((Chunks::new(self.staged, CHUNK), Chunks::new(self.chunks, 1)));
        let pool = Pool::new(self.scratch, area);
        executor::run(executor, pool.count(), blocks, &|| {
            let Some(mut borrowed) = pool.borrow() else { return };
            let mut scratch = Scratch::carve(borrowed.area(), self.bucket);
            while !full.load(Relaxed)
                && let Some((block, ())) = queue.claim()
            {
                let mut sink = Staged { chunks: &chunks, full: &full, block: block as u32, chunk: None };
                work(block, &mut scratch, &mut sink);
            }
            scratch.finish();
        });
        let used = chunks.claimed();
        if full.load(Relaxed) {
            // All blocks will be swept once more: nothing must count twice.
            scratch::reset(self.scratch, area);
            return None;
        }
        Some(self.merge(executor, from, used, blocks))
    }

    /// Copies the chunks in the order of their blocks.
    fn merge(&mut self, executor: &dyn Executor, from: u64, used: usize, blocks: usize) -> u64 {
        order_by_block(self.chunks, used, blocks);
        let chunks = self.chunks.span_mut(0, used);
        // Places are no longer needed. There now: where each chunk ends among all pairs.
        let mut count = 0;
        for [place, _, len] in &mut *chunks {
            count += *len;
            *place = count;
        }
        let (chunks, staged) = (&*chunks, &*self.staged);
        let room = self.pairs.get_mut(from as usize..).unwrap_or_default();
        let fitting = room.len().min(count as usize);
        let queue = BlockQueue::new(Chunks::new(room.span_mut(0, fitting), MERGED));
        executor::run(executor, self.workers, fitting.div_ceil(MERGED), &|| {
            while let Some((block, room)) = queue.claim() {
                gather(chunks, staged, block * MERGED, room);
            }
        });
        from + u64::from(count)
    }
}

/// Fills `room` with the pairs from number `from` on. `chunks` has where each chunk ends, and its
/// position.
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

/// Brings the first `used` chunks into the order of their blocks. One worker has claimed the chunks of a
/// block, so these stay as they are. Counts them by block and brings each to its place at once: O(chunks +
/// blocks), also where blocks that were swept at the same time have taken turns. Returns how many moves it
/// took.
fn order_by_block(chunks: &mut [[u32; 3]], used: usize, blocks: usize) -> usize {
    // The second number is where the chunk stands, so it is free for a while: for the count of a block, then
    // for where its next chunk goes. There are more chunks than blocks.
    chunks.span_mut(0, blocks).iter_mut().for_each(|[_, count, _]| *count = 0);
    let next_of = |chunks: &mut [[u32; 3]], at: usize| {
        let block = chunks.get_mut(chunks.at(at)[0] as usize);
        block.map_or(0, |[_, next, _]| core::mem::replace(next, *next + 1))
    };
    (0..used).for_each(|at| _ = next_of(chunks, at));
    let mut start = 0;
    for [_, count, _] in chunks.span_mut(0, blocks) {
        start += core::mem::replace(count, start);
    }
    for at in 0..used {
        let place = next_of(chunks, at);
        chunks.span_mut(at, 1).iter_mut().for_each(|[block, ..]| *block = place);
    }
    (0..).zip(chunks.span_mut(0, used)).for_each(|(at, [_, index, _])| *index = at);
    let mut moves = 0;
    for at in 0..used {
        // Each move brings a chunk to where it stays.
        while moves < used && chunks.at(at)[0] as usize != at {
            chunks.swap_at(at, chunks.at(at)[0] as usize);
            moves += 1;
        }
    }
    moves
}

/// Writes the pairs of one block to as many chunks as they need.
struct Staged<'s, 'o, I> {
    chunks: &'s BlockQueue<StagedChunks<'o, I>>,
    full: &'s AtomicBool,
    block: u32,
    chunk: Option<StagedChunk<'s, I>>,
}

impl<I: Index> Sink<I> for Staged<'_, '_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut rest = &*pairs;
        while !rest.is_empty() {
            let Some((room, [entry])) = &mut self.chunk else {
                let Some((index, (room, entry))) = self.chunks.claim() else {
                    return self.full.store(true, Relaxed);
                };
                entry.fill([self.block, index as u32, 0]);
                self.chunk = Some((room, entry));
                continue;
            };
            let len = entry[2] as usize;
            let (now, later) = rest.split_at(rest.len().min(room.len() - len));
            room.span_mut(len, now.len()).copy_in(now);
            entry[2] += now.len() as u32;
            if entry[2] as usize == room.len() {
                self.chunk = None;
            }
            rest = later;
        }
    }

    fn is_full(&self) -> bool {
        self.full.load(Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Each chunk is moved once at most, also where two blocks that were swept at the same time took turns.
    #[test]
    fn chunks_come_into_the_order_of_blocks_whoever_claimed_them() {
        for count in [1, 6, 100_000] {
            for (blocks, step) in [(1, 1), (2, 1), (7, 3), (7, 5)].into_iter().filter(|case| case.0 <= count)
            {
                let claimed: Vec<[u32; 3]> = (0..count).map(|at| [at * step % blocks, at, 9]).collect();
                let mut chunks = claimed.clone();
                chunks.push([1; 3]);
                let moves = order_by_block(&mut chunks, count as usize, blocks as usize);
                assert!(moves < count as usize, "{moves} moves");
                let mut expected: Vec<_> = claimed.iter().map(|[block, at, _]| [*block, *at]).collect();
                expected.sort_unstable();
                let told = chunks[..count as usize].iter().map(|chunk| chunk[1]);
                assert!(told.eq(expected.iter().map(|chunk| chunk[1])));
            }
        }
    }
}
