//! Sweeps boxes for overlaps (paper, section IV), and makes one list of the pairs of many workers.
//!
//! Work is cut into blocks by counts alone. One worker writes pairs straight to their places. Several workers
//! write them to chunks, which are then copied in the order of their blocks, so the bytes are the same.

pub(crate) mod bucket;
pub(crate) mod kinds;
pub(crate) mod leaves;
pub(crate) mod movers;
mod scan;
pub(crate) mod small;

use crate::access::Access;
use crate::geometry::record::Record;
use crate::id::{Index, Pair};
use crate::memory::layout::Sizes;
use crate::memory::limits::{CHUNK, PAIR_BLOCKS, PAIRS_PER_BLOCK};
use crate::memory::scratch::{self, Scratch, Work};
use crate::pairs::pair_filter::PairFilter;
use crate::parallel::block_queue::{BlockQueue, Chunks};
use crate::parallel::context::StepContext;
use crate::parallel::executor;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Sweeps one block of leaves.
type BlockWork<'w, I> = dyn Fn(usize, &mut Scratch<'_, I>, &mut Sink<'_, I>) + Sync + 'w;
/// Chunks of staged pairs, and for each where its block ends, the next chunk of its block or 0, its length.
type StagedChunks<'s, I> = (Chunks<'s, Pair<I>>, Chunks<'s, [u32; 3]>);

/// Takes pairs, and writes what the filter lets through to its final place, or to chunks.
pub(crate) struct Sink<'s, I> {
    pair_filter: Option<PairFilter<'s>>,
    /// What is left of the pair buffer, or of the last chunk.
    room: &'s mut [Pair<I>],
    /// Pairs so far, whether there was room or not.
    count: u64,
    staging: Option<Staging<'s, I>>,
}

/// Where the pairs of one block of a shared sweep go.
struct Staging<'s, I> {
    /// All chunks but the first ones of blocks, and how many these are.
    chunks: &'s BlockQueue<StagedChunks<'s, I>>,
    blocks: usize,
    /// The entry of the last chunk, whose length is right when the block is done.
    entry: &'s mut [[u32; 3]],
    /// Whether the chunks do not suffice.
    full: &'s AtomicBool,
}

impl<I: Index> Sink<'_, I> {
    /// Appends pairs.
    pub(crate) fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut kept = pairs.len();
        if let Some(pair_filter) = &self.pair_filter {
            kept = 0;
            for index in 0..pairs.len() {
                let pair = pairs.at(index);
                pairs.put(kept, pair);
                kept += usize::from(pair_filter.lets_through(pair));
            }
        }
        let mut pairs = pairs.span(0, kept);
        self.count += kept as u64;
        loop {
            let fitting = pairs.len().min(self.room.len());
            let (now, room) = core::mem::take(&mut self.room).split_at_mut(fitting);
            now.copy_in(pairs);
            (self.room, pairs) = (room, pairs.get(fitting..).unwrap_or_default());
            let Some(Staging { chunks, blocks, entry, full }) = &mut self.staging else { return };
            if pairs.is_empty() {
                return;
            }
            let Some((index, (room, next))) = chunks.claim_from(&mut 0) else {
                return full.store(true, Relaxed);
            };
            next.fill([0, 0, CHUNK as u32]);
            entry.iter_mut().for_each(|[_, next, _]| *next = (*blocks + index) as u32);
            (self.room, *entry) = (room, next);
        }
    }

    /// Whether more pairs are of no use.
    pub(crate) fn is_full(&self) -> bool {
        self.staging.as_ref().is_some_and(|staging| staging.full.load(Relaxed))
    }
}

/// Collects the pairs of a sweep.
pub(crate) struct Collector<'o, I> {
    pub(crate) pairs: &'o mut [Pair<I>],
    pub(crate) staged: &'o mut [Pair<I>],
    pub(crate) chunks: &'o mut [[u32; 3]],
    pub(crate) scratch: &'o mut [Record],
    pub(crate) sizes: &'o Sizes,
    /// Asked about each pair.
    pub(crate) pair_filter: Option<PairFilter<'o>>,
    /// Pairs before those of the sweep.
    pub(crate) from: u64,
    /// The blocks whose pairs are in chunks.
    pub(crate) blocks: usize,
}

impl<I: Index> Collector<'_, I> {
    /// Does all blocks of work. The pairs are then to be [merged](Self::merge).
    pub(crate) fn collect(
        &mut self,
        context: StepContext<'_>,
        blocks: usize,
        work: &BlockWork<'_, I>,
    ) -> (u64, Work) {
        let area = scratch::records::<I>(self.sizes.bucket);
        scratch::reset(self.scratch, area);
        let countable = self.pairs.len() <= i32::MAX as usize;
        let may_share = executor::THREADS && context.executor.workers() > 1;
        let shared = may_share && blocks > 1 && countable && !self.staged.is_empty();
        let count = if shared { self.in_parallel(context, blocks, work) } else { None };
        self.blocks = if count.is_some() { blocks } else { 0 };
        let count = count.unwrap_or_else(|| {
            let room = self.pairs.get_mut(self.from as usize..).unwrap_or_default();
            let mut sink = Sink { pair_filter: self.pair_filter, room, count: self.from, staging: None };
            let area = self.scratch.get_mut(..area).unwrap_or_default();
            let mut scratch = Scratch::carve(area, self.sizes.bucket);
            (0..blocks).for_each(|block| work(block, &mut scratch, &mut sink));
            scratch.finish();
            sink.count
        });
        (count, scratch::work(self.scratch, area))
    }

    /// `None`, as soon as the chunks do not suffice, which can only be if the pairs nearly fill their buffer.
    fn in_parallel(
        &mut self,
        context: StepContext<'_>,
        blocks: usize,
        work: &BlockWork<'_, I>,
    ) -> Option<u64> {
        let Self { staged, chunks, scratch, sizes, pair_filter, .. } = self;
        let area = scratch::records::<I>(sizes.bucket);
        let full = AtomicBool::new(false);
        // The first chunk of each block has its number.
        let (firsts, others) = staged.split_at_mut_checked(blocks * CHUNK)?;
        let (entries, more) = chunks.split_at_mut_checked(blocks)?;
        let queue = BlockQueue::new((Chunks::new(firsts, CHUNK), Chunks::new(entries, 1)), 1);
        let chunks = BlockQueue::new((Chunks::new(others, CHUNK), Chunks::new(more, 1)), 1);
        let areas = BlockQueue::new(Chunks::new(scratch, area), 1);
        executor::run(context.executor, areas.count(), blocks, &|| {
            // A call that finds none leaves the work to calls that have one, which go on to the end.
            let Some((_, area)) = areas.claim_from(&mut 0) else { return };
            let mut scratch = Scratch::carve(area, sizes.bucket);
            // Workers share leaves. Each would look at all boxes alone.
            scratch.leaf_scratch.common_axes = Some(0);
            while !full.load(Relaxed)
                && let Some((block, (room, entry))) = queue.claim_from(&mut 0)
            {
                entry.fill([0, 0, CHUNK as u32]);
                let staging = Some(Staging { chunks: &chunks, blocks, entry, full: &full });
                let mut sink = Sink { pair_filter: *pair_filter, room, count: 0, staging };
                work(block, &mut scratch, &mut sink);
                if let Sink { room, staging: Some(Staging { entry: [[.., len]], .. }), .. } = sink {
                    *len -= room.len() as u32;
                }
            }
            scratch.finish();
        });
        if full.load(Relaxed) {
            // All blocks will be swept once more: nothing must count twice.
            scratch::reset(scratch, area);
            return None;
        }
        let mut count = 0;
        for block in 0..blocks {
            let [_, next, len] = self.chunks.at(block);
            let mut chunk = [0, next, len];
            count += len;
            while chunk[1] != 0 {
                chunk = self.chunks.at(chunk[1] as usize);
                count += chunk[2];
            }
            self.chunks.put(block, [count, next, len]);
        }
        Some(self.from + u64::from(count))
    }

    /// Copies the pairs in chunks to their places, behind the first ones, in the order of their blocks.
    pub(crate) fn merge(&mut self, context: StepContext<'_>, pairs: u64) {
        let (chunks, ends, staged) = (&*self.chunks, self.chunks.span(0, self.blocks), &*self.staged);
        let room = self.pairs.get_mut(self.from as usize..).unwrap_or_default();
        let fitting = if ends.is_empty() { 0 } else { (pairs - self.from).min(room.len() as u64) as usize };
        let len = fitting.div_ceil(PAIR_BLOCKS).max(PAIRS_PER_BLOCK);
        context.each(Chunks::new(room.span_mut(0, fitting), len), |block, mut room| {
            let mut skip = block * len;
            let first = ends.partition_point(|[end, ..]| *end as usize <= skip);
            skip -= ends.span(0, first).last().map_or(0, |[end, ..]| *end as usize);
            let (mut block, mut chunk) = (first, first);
            while !room.is_empty() {
                let [_, next, len] = chunks.at(chunk).map(|number| number as usize);
                let (skipped, count) = (skip.min(len), room.len().min(len - skip.min(len)));
                let (now, later) = room.split_at_mut_checked(count).unwrap_or_default();
                now.copy_in(staged.span(chunk * CHUNK + skipped, count));
                block += usize::from(next == 0);
                (room, skip, chunk) = (later, skip - skipped, if next == 0 { block } else { next });
            }
        });
    }
}
