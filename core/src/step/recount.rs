//! Checks whether the pairs of a snapshot are all that there are. The first step that would keep them does it, not
//! the load, since a step has kernels, workers and the rule. If some are missing, the step finds all pairs anew.
//!
//! Each pair was checked when it was loaded. Whether one is missing or double is seen from a sum over all pairs and
//! one over all overlaps, 64 mixed bits each: there is no memory to write them down twice.

use super::policy;
use crate::access::{Access, bits};
use crate::filter::Rule;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::memory::limits::{LEAF_TARGET, MOVERS_PER_BLOCK};
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Route};
use crate::pairs::pair_filter::{Filtered, PairFilter};
use crate::pairs::persistent::is_clear_of;
use crate::parallel::context::StepContext;
use crate::sweep::leaves::TreeView;
use crate::sweep::movers::SweepMovers;
use crate::sweep::{Collector, Sink};
use crate::tree::Leaf;

/// A sum over pairs, the same in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sum {
    count: u64,
    /// Sums of the halves of 64 bits, which cannot overflow.
    low: u64,
    high: u64,
}

impl Sum {
    /// Adds a pair, the lower slot first.
    #[inline(always)]
    pub(crate) fn add(&mut self, [a, b]: [u32; 2]) {
        // SplitMix64: each bit of a number changes each bit of the result for half of all numbers.
        let mut bits = (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        self.count += 1;
        self.low += bits & 0xffff_ffff;
        self.high += bits >> 32;
    }
}

/// The path of the first step after a load.
// Not inline, so that other steps need no stack for it.
#[cold]
#[inline(never)]
pub(crate) fn prove<I: Index>(
    parts: &mut Parts<'_, I>,
    route: Route,
    moved: u32,
    context: StepContext<'_>,
) -> Route {
    parts.state.pairs.unproven = 0;
    if !matches!(route.path, Path::Unchanged | Path::Movers | Path::MoversByLeaf) || is_all(parts, context) {
        return route;
    }
    // As after a step whose pairs cannot be kept.
    parts.state.pairs.without_surplus = 1;
    policy::choose(parts, moved)
}

/// The same at once, for small builds, which have no rule. So steps need no code for it.
pub(crate) fn prove_at_once<I: Index>(parts: &mut Parts<'_, I>) {
    parts.state.pairs.unproven = 0;
    let known = kept(parts);
    if one_by_one(parts, None) != known {
        parts.state.pairs.without_surplus = 1;
    }
}

/// The sum over the pairs that a step would keep.
pub(crate) fn kept<I: Index>(parts: &Parts<'_, I>) -> Sum {
    let mut sum = Sum::default();
    for pair in parts.output.pairs.span(0, parts.state.pairs.swept as usize) {
        if is_clear_of(parts.moved.words, pair) {
            sum.add(pair.map(Index::slot));
        }
    }
    sum
}

/// Whether the pairs that a step would keep are all that there are.
fn is_all<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> bool {
    let known = kept(parts);
    if !context.is_small() && parts.state.tree.filled != 0 {
        return in_tree(parts, context) == known;
    }
    // After a move to another configuration there is no tree. Then a step of more objects finds all pairs anew.
    parts.state.objects.live as usize <= LEAF_TARGET && one_by_one(parts, context.rule) == known
}

/// The sum over all overlaps of a few objects that have not moved.
fn one_by_one<I: Index>(parts: &mut Parts<'_, I>, rule: Option<&Rule<'_>>) -> Sum {
    let Parts { state, boxes, moved, order, filters, .. } = parts;
    // A loaded world has no lists: here they are scratch memory.
    state.lists.stale = 1;
    let boxes = boxes.swept();
    let list = &mut *order[0];
    let mut count = 0;
    for slot in 0..state.objects.slots as usize {
        if !boxes.at(slot).is_empty() && !bits::test(moved.words, slot) {
            list.put(count, I::from_slot(slot as u32));
            count += 1;
        }
    }
    let pair_filter = PairFilter::new(filters, rule);
    let mut sum = Sum::default();
    let mut rest = list.span(0, count);
    while let Some((a, others)) = rest.split_first() {
        let bounds = KeyBox::of(boxes, a.at());
        for b in others {
            let pair: Pair<I> = pair(a.slot(), b.slot());
            let overlaps = KeyBox::of(boxes, b.at()).overlaps(bounds);
            if overlaps && pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(&pair)) {
                sum.add(pair.map(Index::slot));
            }
        }
        rest = others;
    }
    sum
}

/// The sum over all overlaps of objects in the tree that have not moved. Each is tested as if it had.
fn in_tree<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Sum {
    let [list, _, homes] = &mut parts.order;
    let mut count = 0;
    let mut add = |slot: u32, home: I| {
        if !bits::test(parts.moved.words, slot as usize) {
            list.put(count, I::from_slot(slot));
            homes.put(count, home);
            count += 1;
        }
    };
    for leaf in 0..parts.state.leaves() {
        let Leaf { start, len, .. } = parts.tree.leaves.at(leaf as usize);
        for record in parts.tree.records.span(start as usize, len as usize) {
            add(record.slot(), I::from_slot(leaf));
        }
    }
    for straddler in
        parts.tree.straddlers.span(parts.state.tree.large_start as usize, parts.state.tree.large as usize)
    {
        add(straddler.slot, I::LARGE);
    }
    // A loaded world has no lists, so the set of listed slots is free: here it is the set of all slots.
    parts.state.lists.stale = 1;
    parts.listed.fill(u32::MAX);
    let per_block = count.div_ceil(parts.state.tree.most_blocks()).max(MOVERS_PER_BLOCK);
    let [list, _, homes] = &parts.order;
    let (list, homes) = (list.span(0, count), homes.span(0, count));
    let (all_slots, moved) = (&*parts.listed, &*parts.moved.words);
    let tree_view = TreeView::new(parts.state, parts.boxes.swept(), &parts.tree);
    let pair_filter = PairFilter::new(&parts.filters, context.rule);
    let from = parts.output.pairs.len() as u64;
    let mut collector = Collector::new(&mut parts.output, &parts.sizes, None);
    // Appended at the end of the full buffer, pairs are only counted.
    let blocks = count.div_ceil(per_block);
    let (end, work) = collector.collect(context.executor, from, blocks, &|block, scratch, sink| {
        let start = block * per_block;
        let len = per_block.min(count - start);
        let (movers, homes) = (list.span(start, len), homes.span(start, len));
        let mut summing = Summing { moved, sum: Sum::default(), sink };
        let sink: &mut dyn Sink<I> = match &pair_filter {
            Some(pair_filter) => &mut Filtered { pair_filter, sink: &mut summing },
            None => &mut summing,
        };
        context.kernels.run(SweepMovers {
            tree_view: &tree_view,
            moved: all_slots,
            movers,
            homes,
            scratch,
            sink,
        });
        // These two counters carry the sum. Nobody reads what else they count.
        scratch.copies += summing.sum.low;
        scratch.leaf_scratch.tied += summing.sum.high;
    });
    parts.listed.fill(0);
    Sum { count: end - from, low: work.copies, high: work.tied }
}

/// Adds up the pairs of objects that have not moved, and passes them on.
struct Summing<'s, I> {
    moved: &'s [u32],
    sum: Sum,
    sink: &'s mut dyn Sink<I>,
}

impl<I: Index> Sink<I> for Summing<'_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut kept = 0;
        for index in 0..pairs.len() {
            let pair = pairs.at(index);
            pairs.put(kept, pair);
            if is_clear_of(self.moved, &pair) {
                self.sum.add(pair.map(Index::slot));
                kept += 1;
            }
        }
        self.sink.take(pairs.span_mut(0, kept));
    }
}
