//! From overlaps of swept boxes to the result: the exact test, and which pairs are new or gone.
//!
//! A pair is new exactly if its boxes did not overlap when the last complete step reported them, and gone exactly if
//! it stood in that step's result and does not overlap now. That needs no search: the boxes from then are kept, and an
//! object that is new or gone has the empty box. A reused slot follows by itself, since the empty box is between
//! the two objects.

use crate::access::{Access, bits};
use crate::config::Mode;
use crate::filter::FILTERS;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::limits::block_len;
use crate::memory::slab::{BoxParts, Parts};
use crate::memory::slot_set::SlotSet;
use crate::pairs::persistent::is_clear_of;
use crate::parallel::block_queue::{BlockQueue, Chunks};
use crate::parallel::context::StepContext;
use crate::parallel::executor;
use crate::simd::{Phase, Simd};
use crate::sort::heapsort;
use core::cell::Cell;

/// Orders the first `swept` pairs of the buffer, but for those parked: persisting, found, surplus; and finds the lost
/// ones. Events only where the pairs are complete: of a part nobody can tell what is lost.
pub(crate) fn sort_out<I: Index>(
    parts: &mut Parts<'_, I>,
    swept: usize,
    complete: bool,
    context: StepContext<'_>,
) {
    let events = parts.sizes.previous > 0 && complete;
    let mode = parts.state.setup.mode();
    let (now, before) = (parts.boxes.reported(mode), &*parts.boxes.before);
    let parked = parts.state.pairs.parked as usize;
    let pairs = parts.output.pairs.span_mut(parked, swept - parked);
    let margins = !parts.boxes.fat.is_empty();
    let result =
        if mode == Mode::Exact && margins { partition(context, pairs, Overlap(now)) } else { pairs.len() };
    let mut persisting = result;
    parts.state.pairs.lost = 0;
    if events {
        let previous = parts.output.previous.span_mut(0, parts.state.pairs.previous as usize);
        let pairs = pairs.span_mut(0, result);
        persisting = partition(context, pairs, Overlap(before));
        // What overlapped then and does not now; where slots may have new objects, they did not overlap then.
        let asked = &*parts.filters.changed.words;
        let lost = if FILTERS && parts.filters.changed.count() > 0 {
            let staying = staying(context, pairs.span_mut(0, persisting), previous, asked);
            persisting = staying.end;
            let staying = pairs.span(staying.start, staying.len());
            partition(context, previous, Dropped { now, before, asked, staying })
        } else if parts.state.objects.has_inserted != 0 {
            partition(context, previous, Ended { now, before })
        } else {
            partition(context, previous, Apart(now))
        };
        parts.state.pairs.lost = lost as u64;
    }
    parts.state.pairs.swept = swept as u64;
    parts.state.pairs.reported = (parked + result) as u64 - u64::from(parts.state.pairs.surplus_parked);
    parts.state.pairs.found = (result - persisting) as u64;
}

/// Keeps the boxes that a complete step reports, for the events of the next one.
pub(crate) fn remember<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let mode = parts.state.setup.mode();
    let BoxParts { now, fat, before, .. } = &mut parts.boxes;
    let boxes = if mode == Mode::Fat && !fat.is_empty() { &**fat } else { &**now };
    if context.is_small() {
        return remember_block(boxes, before, parts.changed.reborrow());
    }
    if before.is_empty() {
        return parts.changed.clear();
    }
    let len = block_len(before.len());
    let claims = BlockQueue::new((Chunks::new(before, len), parts.changed.blocks(len)));
    executor::run(context.executor, context.workers, claims.count(), &|| {
        while let Some((block, (before, changed))) = claims.claim() {
            remember_block(boxes.span(block * len, before.len()), before, changed.into());
        }
    });
}

fn remember_block(boxes: &[KeyBox], before: &mut [KeyBox], mut changed: SlotSet<'_>) {
    changed.for_each_word(|word, bits| {
        let first = word * 32;
        if bits == u32::MAX {
            before.span_mut(first, 32).copy_in(boxes.span(first, 32));
        } else {
            for bit in bits::of_word(bits) {
                before.put(first + bit, boxes.at(first + bit));
            }
        }
    });
    changed.clear();
}

/// Which pairs stay whose boxes overlapped before and do now. Where a filter may answer differently than before, only the
/// pairs of then can tell: the range of those that they tell stay, in order, behind all the others that stay.
fn staying<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    previous: &mut [Pair<I>],
    asked: &[u32],
) -> core::ops::Range<usize> {
    let others = partition(context, pairs, ClearOf(asked));
    let known = partition(context, previous, Touch(asked));
    let known = previous.span_mut(0, known);
    heapsort(known, |a, b| a < b);
    let open = pairs.len() - others;
    let open = pairs.span_mut(others, open);
    let stay = partition(context, open, Among(known));
    heapsort(open.span_mut(0, stay), |a, b| a < b);
    others..others + stay
}

/// Blocks that pairs are divided in. Fixed, so that the order does not depend on the number of workers.
const BLOCKS: usize = 32;
/// The fewest pairs in a block.
const PAIRS_PER_BLOCK: usize = 8192;

/// Brings the pairs that the test holds of to the straddlers and returns how many there are: block by block, and then those on
/// the wrong side of the border change places.
fn partition<I: Index>(context: StepContext<'_>, pairs: &mut [Pair<I>], test: impl Test<I>) -> usize {
    if context.is_small() {
        return context.kernels.run(PartitionBlock { pairs, test });
    }
    let count = pairs.len();
    let len = count.div_ceil(BLOCKS).max(PAIRS_PER_BLOCK);
    let blocks = count.div_ceil(len);
    let mut straddlers = [0; BLOCKS];
    let claims = BlockQueue::new((Chunks::new(pairs, len), Chunks::new(&mut straddlers, 1)));
    executor::run(context.executor, context.workers, blocks, &|| {
        while let Some((_, (pairs, straddler))) = claims.claim() {
            straddler.fill(context.kernels.run(PartitionBlock { pairs, test }));
        }
    });
    let border = straddlers.iter().sum();
    if blocks > 1 {
        let ends = || (0..blocks).map(|block| (block * len, block * len + straddlers.at(block)));
        let late = ends().flat_map(|(start, end)| start.max(border)..end);
        let early = ends().flat_map(|(start, end)| end..(start + len).min(border));
        for (late, early) in late.zip(early) {
            pairs.swap_at(late, early);
        }
    }
    border
}

struct PartitionBlock<'b, I, T> {
    pairs: &'b mut [Pair<I>],
    test: T,
}

/// How many pairs ahead boxes are asked for: a pair's boxes are anywhere in memory.
const AHEAD: usize = 12;
/// The most boxes that are not asked for, as they are near anyway.
const NEAR: usize = 4 << 10;

impl<I: Index, T: Test<I>> Phase for PartitionBlock<'_, I, T> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { pairs, test } = self;
        // So that those further on can be read while others change.
        let pairs = Cell::from_mut(pairs).as_slice_of_cells();
        let boxes = test.boxes();
        let ahead = if cfg!(feature = "large") && boxes.len() > NEAR { AHEAD } else { pairs.len() };
        let mut straddler = 0;
        let later = pairs.get(ahead..).unwrap_or_default();
        for (pair, later) in pairs.iter().zip(later) {
            let later = later.get();
            simd.prefetch(boxes, later[0].at());
            simd.prefetch(boxes, later[1].at());
            straddler += exchange(simd, pairs, straddler, pair, &test);
        }
        for pair in pairs.get(later.len()..).unwrap_or_default() {
            straddler += exchange(simd, pairs, straddler, pair, &test);
        }
        straddler
    }
}

/// Exchanges a pair with the one at `front` and returns how far the straddlers moves up: one where the test holds of the pair.
/// Exchanged always, so that nothing waits for a guess of the branch predictor: the pairs from `front` on are those that the
/// test does not hold of, in any order.
#[inline(always)]
fn exchange<S: Simd, I: Index>(
    simd: S,
    pairs: &[Cell<Pair<I>>],
    straddler: usize,
    pair: &Cell<Pair<I>>,
    test: &impl Test<I>,
) -> usize {
    let Some(first) = pairs.get(straddler) else { return 0 };
    let next = pair.get();
    pair.set(first.get());
    first.set(next);
    usize::from(test.holds(simd, &next))
}

/// Something that is true or false of a pair.
trait Test<I>: Copy + Sync {
    /// The boxes that it takes to tell, if any.
    fn boxes(&self) -> &[KeyBox] {
        &[]
    }

    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool;
}

/// The boxes overlap.
#[derive(Clone, Copy)]
struct Overlap<'b>(&'b [KeyBox]);

impl<I: Index> Test<I> for Overlap<'_> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.0
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        simd.overlap(KeyBox::of(self.0, pair[0].at()), KeyBox::of(self.0, pair[1].at()))
    }
}

/// The boxes do not overlap.
#[derive(Clone, Copy)]
struct Apart<'b>(&'b [KeyBox]);

impl<I: Index> Test<I> for Apart<'_> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.0
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        !Overlap(self.0).holds(simd, pair)
    }
}

/// The objects that overlapped are not the same any more, or do not overlap any more.
#[derive(Clone, Copy)]
struct Ended<'b> {
    now: &'b [KeyBox],
    before: &'b [KeyBox],
}

impl<I: Index> Test<I> for Ended<'_> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.now
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        !(Overlap(self.now).holds(simd, pair) && Overlap(self.before).holds(simd, pair))
    }
}

/// As [`Ended`], or no pair any more for the filters.
#[derive(Clone, Copy)]
struct Dropped<'b, I> {
    now: &'b [KeyBox],
    before: &'b [KeyBox],
    asked: &'b [u32],
    staying: &'b [Pair<I>],
}

impl<I: Index> Test<I> for Dropped<'_, I> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.now
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        let Self { now, before, asked, staying } = *self;
        let dropped = || Touch(asked).holds(simd, pair) && !Among(staying).holds(simd, pair);
        Ended { now, before }.holds(simd, pair) || dropped()
    }
}

/// Neither object is marked.
#[derive(Clone, Copy)]
struct ClearOf<'b>(&'b [u32]);

impl<I: Index> Test<I> for ClearOf<'_> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        is_clear_of(self.0, pair)
    }
}

/// One of the objects is marked.
#[derive(Clone, Copy)]
struct Touch<'b>(&'b [u32]);

impl<I: Index> Test<I> for Touch<'_> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        !is_clear_of(self.0, pair)
    }
}

/// The pair is in an ascending list.
#[derive(Clone, Copy)]
struct Among<'b, I>(&'b [Pair<I>]);

impl<I: Index> Test<I> for Among<'_, I> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        self.0.binary_search(pair).is_ok()
    }
}
