//! Sweep-and-prune (paper, section IV), and how the pairs of many workers become one list.
//!
//! Work is cut into blocks by counts alone. One worker writes pairs straight to where they belong; several write
//! them to chunks, which are then put in the order of their blocks, so that the bytes are the same.

pub(crate) mod bag;
pub(crate) mod leaves;
pub(crate) mod list;
pub(crate) mod movers;
pub(crate) mod scratch;
pub(crate) mod small;

use crate::access::Access;
use crate::arch::claim::{Chunks, Claims, Indices, Pool};
use crate::exec::{self, Executor};
use crate::id::{Index, Pair};
use crate::layout::CHUNK;
use crate::storage::OutputParts;
use crate::tree::Record;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use scratch::{Scratch, Work};

/// Where pairs go.
pub(crate) trait Sink<I> {
    /// Appends pairs.
    fn take(&mut self, pairs: &[Pair<I>]);
}

/// Pairs in their final order. Counts on when it is full.
pub(crate) struct Ordered<'o, I> {
    pairs: &'o mut [Pair<I>],
    /// Pairs that were taken, whether they fitted or not.
    count: u64,
}

impl<I: Index> Sink<I> for Ordered<'_, I> {
    fn take(&mut self, pairs: &[Pair<I>]) {
        let start = usize::try_from(self.count).unwrap_or(usize::MAX);
        if let Some(room) = self.pairs.get_mut(start..) {
            for (to, from) in room.iter_mut().zip(pairs) {
                *to = *from;
            }
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
    pub(crate) bag: usize,
}

impl<'o, I: Index> Collector<'o, I> {
    pub(crate) fn new(output: &'o mut OutputParts<'_, I>, bag: usize) -> Self {
        let OutputParts { pairs, staged, chunks, scratch, .. } = output;
        Self { pairs, staged, chunks, scratch, bag }
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
        let area = scratch::records::<I>(self.bag);
        scratch::reset(self.scratch, area);
        let shared = executor.workers() > 1 && blocks > 1 && !self.staged.is_empty();
        let count = if shared { self.in_parallel(executor, from, blocks, work) } else { None };
        let count = count.unwrap_or_else(|| {
            let mut sink = Ordered { pairs: self.pairs, count: from };
            let mut scratch = Scratch::carve(self.scratch.get_mut(..area).unwrap_or_default(), self.bag);
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
        let area = scratch::records::<I>(self.bag);
        let full = AtomicBool::new(false);
        let next = Indices::new(blocks);
        let chunks = Claims::new((Chunks::new(self.staged, CHUNK), Chunks::new(self.chunks, 1)));
        let pool = Pool::new(self.scratch, area);
        exec::run(executor, pool.count(), blocks, &|| {
            let Some(mut borrowed) = pool.borrow() else { return };
            let mut scratch = Scratch::carve(borrowed.area(), self.bag);
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
        Some(self.merge(from, used))
    }

    /// Puts the staged chunks in the order of their blocks. A block's chunks were claimed by one worker, so they
    /// stand in the order in which it filled them.
    fn merge(&mut self, from: u64, used: usize) -> u64 {
        let mut sink = Ordered { pairs: self.pairs, count: from };
        let chunks = self.chunks.span_mut(0, used);
        insertion_sort(chunks);
        for &[_, index, len] in &*chunks {
            sink.take(self.staged.span(index as usize * CHUNK, len as usize));
        }
        sink.count
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
    chunks: &'s Claims<StagedChunks<'o, I>>,
    full: &'s AtomicBool,
    block: u32,
    chunk: Option<StagedChunk<'s, I>>,
}

impl<I: Index> Sink<I> for Staged<'_, '_, I> {
    fn take(&mut self, mut pairs: &[Pair<I>]) {
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
