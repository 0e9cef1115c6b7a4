//! Sweeps leaves: each its members, and the ghosts that it gathers from the straddlers of other leaves.
//!
//! So pairs across leaves are found (erratum E7): every box that touches the cell of a leaf takes part in its
//! sweep, wherever it is at home, moved or resting. A pair is reported in the one cell that holds the
//! component-wise maximum of its two minimum corners (erratum E9). If one box is at home here, that is this
//! cell. If both are ghosts, there must be no axis on which both minima are below the cell.

use super::kinds::{CODES, Counts, Kinds, LONE, Pass, Plan};
use super::{Sink, bucket};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::{LeafScratch, Scratch};
use crate::memory::slab::TreeParts;
use crate::memory::state::TreeState;
use crate::simd::{MINIMA, Simd, call};
use crate::tree::large::Large;
use crate::tree::visit::Visit;
use crate::tree::{Frame, Leaf, Nodes, Record, Straddler, Straddling};
use core::ops::Range;

/// What sweeps read of the tree.
#[derive(Clone, Copy)]
pub(crate) struct TreeView<'g> {
    /// The boxes of all slots that are in use, at least.
    pub(crate) boxes: &'g [KeyBox],
    pub(crate) nodes: Nodes<'g>,
    pub(crate) tree: &'g TreeParts<'g>,
    pub(crate) state: &'g TreeState,
    pub(crate) large: Large<'g>,
}

impl<'g> TreeView<'g> {
    pub(crate) fn new(state: &'g TreeState, boxes: &'g [KeyBox], tree: &'g TreeParts<'_>) -> Self {
        Self { boxes, nodes: tree.nodes(), tree, state, large: Large::new(state, tree.straddlers) }
    }

    /// Writes the ghosts of a leaf: the records of boxes that touch its cell and are not its members. Leaves
    /// out the first `skip` of them, and writes as many as fit. Returns how many there are in all.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, index: usize, skip: usize, ghosts: &mut [Record]) -> usize {
        call!(simd, {
            let cell = self.tree.cells.at(index);
            let [low, entrance] = cell.entrance(simd);
            let mut gathered =
                Gathered { simd, low, entrance, frame: self.tree.frames.at(index), skip, count: 0, ghosts };
            // The cell is half-open: minima at its high side are in the next cell.
            let mut visit = Visit::new(self.nodes, cell.inside());
            visit.start(simd, index);
            while let Some(other) = visit.next(simd) {
                if other != index {
                    let Straddling { start, len } = self.tree.straddling.at(other);
                    gathered.add(self.tree.straddlers.span(start as usize, len as usize));
                }
            }
            // Asked first, since it takes less than a walk.
            if !self.large.list.is_empty() {
                let mut visit = self.large.visit(cell.inside());
                while let Some(group) = visit.next(simd) {
                    gathered.add(self.large.group(group));
                }
            }
            gathered.count
        })
    }
}

/// The ghosts of a leaf so far.
struct Gathered<'v, S: Simd> {
    simd: S,
    low: S::Keys,
    entrance: S::Keys,
    frame: Frame,
    skip: usize,
    count: usize,
    ghosts: &'v mut [Record],
}

impl<S: Simd> Gathered<'_, S> {
    /// Adds the boxes that touch the cell.
    #[inline(always)]
    fn add(&mut self, straddlers: &[Straddler]) {
        let simd = self.simd;
        for straddlers in straddlers.chunks(64) {
            // Noted for all of them first, since which ones touch the cell is hard to predict.
            let mut touching = 0u64;
            for (bit, Straddler { bounds, .. }) in straddlers.iter().enumerate() {
                // Its minima are below the high sides, its maxima not below the low sides.
                let touches = simd.above(self.entrance, simd.keys(bounds)) == MINIMA;
                touching |= u64::from(touches) << bit;
            }
            while touching != 0 {
                let straddler = straddlers.at(touching.trailing_zeros() as usize);
                touching &= touching - 1;
                let place = self.count.checked_sub(self.skip).and_then(|at| self.ghosts.get_mut(at));
                if let Some(place) = place {
                    let keys = simd.keys(&straddler.bounds);
                    let marks = Record::BELOW * (simd.above(self.low, keys) & MINIMA);
                    *place = simd.record(&self.frame, keys, straddler.slot | marks);
                }
                self.count += 1;
            }
        }
    }
}

/// A leaf, and who in it is compared with whom.
#[derive(Clone, Copy)]
struct Swept<'g, 'k> {
    tree_view: &'k TreeView<'g>,
    kinds: &'k Kinds<'k>,
    index: usize,
    leaf: Leaf,
    /// Which one it is swept along.
    axis: usize,
}

#[inline(always)]
pub(crate) fn sweep_leaf<S: Simd, I: Index>(
    simd: S,
    tree_view: &TreeView<'_>,
    index: usize,
    kinds: &Kinds<'_>,
    scratch: &mut Scratch<'_, I>,
    sink: &mut Sink<'_, I>,
) {
    let axis = tree_view.tree.frames.get(index).map_or(0, Frame::longest_axis);
    let swept = Swept { tree_view, kinds, index, leaf: tree_view.tree.leaves.at(index), axis };
    let members = swept.leaf.members(tree_view.tree.records);
    let ghosts = tree_view.gather(simd, index, 0, scratch.ghosts);
    scratch.leaf_scratch.work.copies += ghosts as u64;
    let count = members.len() + ghosts;
    if count > scratch.leaf_scratch.sorted.len() {
        call!(simd, sweep_tiles(simd, swept, count, scratch, sink));
        return;
    }
    let buckets = [members, scratch.ghosts.span(0, ghosts)];
    if !kinds.are_one() {
        let plan = kinds.plan(&kinds.count(buckets.iter().copied().flatten()));
        scratch.leaf_scratch.work.spared += plan.spared;
        if !plan.whole {
            sweep_passes(simd, swept, (&plan, false), buckets, &mut scratch.leaf_scratch, sink);
            return;
        }
    }
    let (all, along) = ((|_, _: &_| 0, true), (swept.axis, tree_view.boxes));
    // Its runs take no stack below tiles.
    let leaf_scratch = &mut scratch.leaf_scratch;
    call!(simd, bucket::sweep::<{ bucket::WHOLE }, S, I>(simd, buckets, all, along, leaf_scratch, sink));
}

/// Does the passes of a plan; if `across`, records of the first bucket meet records of the second alone.
#[inline(always)]
fn sweep_passes<S: Simd, I: Index>(
    simd: S,
    swept: Swept<'_, '_>,
    (plan, across): (&Plan, bool),
    buckets: [&[Record]; 2],
    leaf_scratch: &mut LeafScratch<'_, I>,
    sink: &mut Sink<'_, I>,
) {
    let Swept { tree_view: TreeView { boxes, .. }, kinds, axis, .. } = swept;
    call!(simd, {
        for number in 0..LONE {
            let Some(Pass { sides, within }) = plan.pass(number, across) else { continue };
            let side = |bucket: usize, record: &Record| {
                sides.as_flattened().at(bucket * CODES + kinds.code(record)).into()
            };
            let (parts, along) = ((side, within), (axis, *boxes));
            bucket::sweep::<{ bucket::PARTS }, S, I>(simd, buckets, parts, along, leaf_scratch, sink);
        }
    });
}

/// Sweeps a leaf with too many records for the bucket: tiles of half a bucket, each alone and each with each.
#[inline(always)]
fn sweep_tiles<S: Simd, I: Index>(
    simd: S,
    swept: Swept<'_, '_>,
    count: usize,
    scratch: &mut Scratch<'_, I>,
    sink: &mut Sink<'_, I>,
) {
    let kinds = swept.kinds;
    let half = (scratch.ghosts.len() / 2).max(1);
    let (left, right) = scratch.ghosts.split_at_mut(half.min(scratch.ghosts.len()));
    let fill = |rest: &mut Range<usize>, plan: Option<&Plan>, tile: &mut [Record]| {
        call!(simd, fill_tile(simd, swept, rest, plan, tile))
    };
    // First only to count.
    let (mut rest, mut counts) = (0..count, Counts::default());
    while !rest.is_empty() && !kinds.are_one() {
        let len = fill(&mut rest, None, left);
        let tile = kinds.count(left.span(0, len).iter());
        counts.iter_mut().zip(tile).for_each(|(sum, count)| *sum += count);
    }
    let plan = &kinds.plan(&counts);
    scratch.leaf_scratch.work.spared += plan.spared;
    rest = 0..count;
    while !rest.is_empty() {
        let len = fill(&mut rest, Some(plan), left);
        let (mut next, mut other, mut across) = (rest.clone(), 0, false);
        loop {
            let buckets = [left.span(0, len), right.span(0, other)];
            sweep_passes(simd, swept, (plan, across), buckets, &mut scratch.leaf_scratch, sink);
            // One tile after another may have millions of pairs.
            if sink.is_full() {
                return;
            }
            if next.is_empty() {
                break;
            }
            (other, across) = (fill(&mut next, Some(plan), right), true);
        }
    }
}

/// Fills a tile with the members and ghosts of these numbers that a plan takes, or all. Returns
/// how many there are; `numbers` are then what is left for the next tiles.
#[inline(always)]
fn fill_tile<S: Simd>(
    simd: S,
    swept: Swept<'_, '_>,
    numbers: &mut Range<usize>,
    plan: Option<&Plan>,
    tile: &mut [Record],
) -> usize {
    let members = swept.leaf.members(swept.tree_view.tree.records);
    let mut kept = 0;
    while kept < tile.len() && !(*numbers).is_empty() {
        let start = kept;
        let rest = tile.span_mut(start, (tile.len() - start).min(numbers.len()));
        let own = members.get(numbers.start..).unwrap_or_default();
        let (inside, outside) = rest.split_at_mut(own.len().min(rest.len()));
        inside.copy_in(own);
        if !outside.is_empty() {
            let skip = numbers.start.saturating_sub(members.len());
            swept.tree_view.gather(simd, swept.index, skip, outside);
        }
        let len = rest.len();
        numbers.start += len;
        for at in start..start + len {
            let record = tile.at(at);
            tile.put(kept, record);
            kept += usize::from(plan.is_none_or(|plan| plan.takes(swept.kinds.code(&record))));
        }
    }
    kept
}
