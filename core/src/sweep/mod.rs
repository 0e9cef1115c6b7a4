//! Sweep-and-prune (paper, section IV), and how the pairs of many workers become one list.
//!
//! Work is cut into blocks by counts alone. One worker writes pairs straight to where they belong; several write
//! them to chunks, which are then put in the order of their blocks, so that the bytes are the same.

pub(crate) mod bucket;
pub(crate) mod leaves;
pub(crate) mod list;
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
pub(crate) use crate::pairs::pair_filter::Sink;
use crate::pairs::pair_filter::{Filtered, PairFilter};
use crate::parallel::block_queue::{BlockQueue, Chunks, Indices, Pool};
use crate::parallel::executor::{self, Executor};
use crate::tree::Record;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Pairs in their final order. Counts on when it is full.
pub(crate) struct Ordered<'o, I> {
    pairs: &'o mut [Pair<I>],
    /// Pairs that were taken, whether they fitted or not.
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
}

impl<'o, I: Index> Collector<'o, I> {
    pub(crate) fn new(
        output: &'o mut OutputParts<'_, I>,
        sizes: &Sizes,
        pair_filter: Option<PairFilter<'o>>,
    ) -> Self {
        let OutputParts { pairs, staged, chunks, scratch, .. } = output;
        Self { pairs, staged, chunks, scratch, bucket: sizes.bucket, workers: sizes.workers, pair_filter }
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
            let mut sink = Ordered { pairs: self.pairs, count: from };
            let mut scratch = Scratch::carve(self.scratch.get_mut(..area).unwrap_or_default(), self.bucket);
            for block in 0..blocks {
                work(block, &mut scratch, &mut sink);
            }
            scratch.finish();
            sink.count
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
        let next = Indices::new(blocks);
        let chunks = BlockQueue::new((Chunks::new(self.staged, CHUNK), Chunks::new(self.chunks, 1)));
        let pool = Pool::new(self.scratch, area);
        executor::run(executor, pool.count(), blocks, &|| {
            let Some(mut borrowed) = pool.borrow() else { return };
            let mut scratch = Scratch::carve(borrowed.area(), self.bucket);
            while let Some(block) = next.claim() {
                let mut sink = Staged { chunks: &chunks, full: &full, block: block as u32, chunk: None };
                work(block, &mut scratch, &mut sink);
            }
            scratch.finish();
        });
        let used = chunks.claimed();
        if full.load(Relaxed) {
            // The blocks are swept once more, so what was counted must not count twice.
            scratch::reset(self.scratch, area);
            return None;
        }
        Some(self.merge(executor, from, used))
    }

    /// Puts the staged chunks in the order of their blocks. A block's chunks were claimed by one worker, so they
    /// stand in the order in which it filled them.
    fn merge(&mut self, executor: &dyn Executor, from: u64, used: usize) -> u64 {
        let chunks = self.chunks.span_mut(0, used);
        insertion_sort(chunks);
        // The block has done its duty; from here on its place has where the chunk ends.
        let mut end = 0;
        for [block, _, len] in &mut *chunks {
            end += *len;
            *block = end;
        }
        let (chunks, staged) = (&*chunks, &*self.staged);
        let room = self.pairs.get_mut(from as usize..).unwrap_or_default();
        let count = room.len().min(end as usize);
        let claims = BlockQueue::new(Chunks::new(room.span_mut(0, count), MERGED));
        executor::run(executor, self.workers, count.div_ceil(MERGED), &|| {
            while let Some((block, room)) = claims.claim() {
                gather(chunks, staged, block * MERGED, room);
            }
        });
        from + u64::from(end)
    }
}

/// Pairs that a worker puts in order at a time.
const MERGED: usize = 16 * CHUNK;

/// Fills `room` with the pairs from number `from` on: `chunks` has where each chunk ends, its position and its length.
fn gather<I: Index>(chunks: &[[u32; 3]], staged: &[Pair<I>], mut from: usize, mut room: &mut [Pair<I>]) {
    let first = chunks.partition_point(|chunk| chunk[0] as usize <= from);
    for &[end, index, len] in chunks.get(first..).unwrap_or_default() {
        let left = end as usize - from;
        let pairs = staged.span(index as usize * CHUNK + len as usize - left, left.min(room.len()));
        let (now, later) = core::mem::take(&mut room).split_at_mut(pairs.len());
        now.copy_in(pairs);
        from += pairs.len();
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

/// The staged pairs of one block, in as many chunks as they need.
struct Staged<'s, 'o, I> {
    chunks: &'s BlockQueue<StagedChunks<'o, I>>,
    full: &'s AtomicBool,
    block: u32,
    chunk: Option<StagedChunk<'s, I>>,
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
            let filled = entry[2] as usize;
            let (now, later) = pairs.split_at(pairs.len().min(room.len() - filled));
            room.span_mut(filled, now.len()).copy_in(now);
            entry[2] += now.len() as u32;
            pairs = later;
            if entry[2] as usize == room.len() {
                self.chunk = None;
            }
        }
    }
}
