//! Sweeps leaves: each its members, and the ghosts that it gathers from the straddlers of other leaves.
//!
//! So pairs across leaves are found (erratum E7): every box that touches the cell of a leaf takes part in its sweep,
//! wherever it is at home, moved or resting. A pair is reported in the one cell that holds the component-wise maximum
//! of its two minimum corners (erratum E9). If one box is at home here, that is this cell. If both are ghosts, there
//! must be no axis on which both minima are below the cell.

use super::{Sink, bucket};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::scratch::Scratch;
use crate::memory::slab::TreeParts;
use crate::memory::state::State;
use crate::pairs::persistent::is_clear_of;
use crate::simd::{MINIMA, Phase, Simd};
use crate::tree::visit::Visit;
use crate::tree::{Cell, Frame, Leaf, Record, Straddler};

/// What sweeps read of the tree.
#[derive(Clone, Copy)]
pub(crate) struct TreeView<'g> {
    pub(crate) boxes: &'g [KeyBox],
    /// By node.
    pub(crate) nodes: &'g [KeyBox],
    pub(crate) depth: u32,
    /// How many levels the leaves are below `depth`.
    pub(crate) sub_levels: u32,
    pub(crate) cells: &'g [Cell],
    pub(crate) frames: &'g [Frame],
    pub(crate) leaves: &'g [Leaf],
    pub(crate) bounds: &'g [Record],
    pub(crate) records: &'g [Record],
    pub(crate) straddlers: &'g [Straddler],
    /// The large objects.
    pub(crate) large: &'g [Straddler],
}

impl<'g> TreeView<'g> {
    pub(crate) fn new(state: &State, boxes: &'g [KeyBox], tree: &'g TreeParts<'_>) -> Self {
        Self {
            boxes,
            nodes: tree.nodes,
            depth: state.tree.depth,
            sub_levels: state.tree.sub_levels(),
            cells: tree.cells,
            frames: tree.frames,
            leaves: tree.leaves,
            bounds: tree.bounds,
            records: tree.records,
            straddlers: tree.straddlers,
            large: tree.straddlers.span(state.tree.large_start as usize, state.tree.large as usize),
        }
    }

    /// The records of a leaf.
    #[inline(always)]
    pub(crate) fn members(&self, leaf: &Leaf) -> &'g [Record] {
        self.records.span(leaf.start as usize, leaf.len as usize)
    }

    /// Writes the ghosts of a leaf: the records of boxes that touch its cell and are not its members. Leaves out the
    /// first `skip` of them, and writes as many as fit. Returns how many there are in all.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, index: usize, skip: usize, ghosts: &mut [Record]) -> usize {
        let cell = self.cells.at(index);
        let (low, entrance) = (cell.low_keys(simd), cell.entrance(simd));
        let mut gathered =
            Gathered { simd, low, entrance, frame: self.frames.at(index), skip, count: 0, ghosts };
        // The cell is half-open: minima at its high side are in the next cell.
        let mut visit = Visit::new(simd, self.nodes, self.depth, index, cell.inside());
        while let Some(other) = visit.next(simd) {
            if other != index {
                let leaf = self.leaves.at(other);
                gathered
                    .add(self.straddlers.span(leaf.straddler_start as usize, leaf.straddler_len as usize));
            }
        }
        gathered.add(self.large);
        gathered.count
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
            for (bit, straddler) in straddlers.iter().enumerate() {
                // Its minima are below the high sides, its maxima not below the low sides.
                let touches = simd.above(self.entrance, simd.keys(&straddler.bounds)) == MINIMA;
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

/// Whether steps can keep pairs while they sweep leaves. Small builds have none that do.
const KEEPS: bool = cfg!(feature = "large");

/// Sweeps some leaves.
pub(crate) struct SweepLeaves<'p, 's, 'g, I> {
    pub(crate) tree_view: &'p TreeView<'g>,
    pub(crate) leaves: core::ops::Range<usize>,
    /// The moved slots, if only their pairs are looked for.
    pub(crate) moved: Option<&'g [u32]>,
    /// The boxes that are needed right after the sweep of a leaf, for its members and ghosts.
    pub(crate) next: [&'g [KeyBox]; 2],
    pub(crate) scratch: &'p mut Scratch<'s, I>,
    pub(crate) sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for SweepLeaves<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { tree_view, leaves, moved, next, scratch, sink } = self;
        for index in leaves {
            sweep_leaf(simd, tree_view, index, moved, next, scratch, sink);
        }
    }
}

#[inline(always)]
fn sweep_leaf<S: Simd, I: Index>(
    simd: S,
    tree_view: &TreeView<'_>,
    index: usize,
    moved: Option<&[u32]>,
    next: [&[KeyBox]; 2],
    scratch: &mut Scratch<'_, I>,
    sink: &mut dyn Sink<I>,
) {
    let leaf = tree_view.leaves.at(index);
    let members = tree_view.members(&leaf);
    let count = tree_view.gather(simd, index, 0, scratch.ghosts);
    scratch.copies += count as u64;
    if members.len() + count <= scratch.leaf_scratch.sorted.len() {
        let ghosts = scratch.ghosts.span(0, count);
        if !next[0].is_empty() {
            simd.call(AskFor { buckets: [members, ghosts], boxes: next });
        }
        let (axis, leaf_scratch) = (leaf.axis as usize, &mut scratch.leaf_scratch);
        let (buckets, boxes) = ([members, ghosts], tree_view.boxes);
        match moved {
            Some(moved) if KEEPS => {
                bucket::sweep_moved(simd, buckets, moved, axis, leaf_scratch, boxes, sink);
            }
            _ => bucket::sweep(simd, buckets, axis, leaf_scratch, boxes, sink),
        }
    } else {
        let count = members.len() + count;
        let mut of_movers;
        let sink: &mut dyn Sink<I> = match moved {
            Some(moved) if KEEPS => {
                of_movers = OfMovers { moved, sink };
                &mut of_movers
            }
            _ => sink,
        };
        rarely(simd, Tiles { tree_view, index, count, scratch, sink });
    }
}

/// Passes on the pairs with an object that has moved.
struct OfMovers<'s, I> {
    moved: &'s [u32],
    sink: &'s mut dyn Sink<I>,
}

impl<I: Index> Sink<I> for OfMovers<'_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut kept = 0;
        for index in 0..pairs.len() {
            let pair = pairs.at(index);
            pairs.put(kept, pair);
            kept += usize::from(!is_clear_of(self.moved, &pair));
        }
        self.sink.take(pairs.span_mut(0, kept));
    }

    fn is_full(&self) -> bool {
        self.sink.is_full()
    }
}

/// Prefetches the boxes of some records, so that they come while the records are swept.
struct AskFor<'a> {
    buckets: [&'a [Record]; 2],
    boxes: [&'a [KeyBox]; 2],
}

impl Phase for AskFor<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for bucket in self.buckets {
            for record in bucket {
                simd.prefetch(self.boxes[0], record.slot() as usize);
                simd.prefetch(self.boxes[1], record.slot() as usize);
            }
        }
    }
}

/// Runs a phase that is rare. A module for the web, whose bytes are loaded over a network, has it as a call, compiled once (some
/// 13,000 bytes less). Elsewhere it runs in place, as frames below each other would take more of a microcontroller's stack.
#[inline(always)]
fn rarely<S: Simd, P: Phase>(simd: S, phase: P) -> P::Output {
    if cfg!(target_family = "wasm") { simd.call(phase) } else { phase.run(simd) }
}

/// Sweeps a leaf that is too large for the bucket: tiles of half a bucket, each alone and each two against each other.
struct Tiles<'p, 's, 'g, I> {
    tree_view: &'p TreeView<'g>,
    index: usize,
    /// Members and ghosts.
    count: usize,
    scratch: &'p mut Scratch<'s, I>,
    sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for Tiles<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { tree_view, index, count, scratch, sink } = self;
        let axis = tree_view.leaves.at(index).axis as usize;
        let half = (scratch.ghosts.len() / 2).max(1);
        let (left, right) = scratch.ghosts.split_at_mut(half.min(scratch.ghosts.len()));
        for a in (0..count).step_by(half) {
            let left = left.span_mut(0, half.min(count - a));
            rarely(simd, FillTile { tree_view, index, from: a, tile: left });
            bucket::sweep(simd, [left, &[]], axis, &mut scratch.leaf_scratch, tree_view.boxes, sink);
            for b in (a + half..count).step_by(half) {
                // One tile after another may have millions of pairs.
                if sink.is_full() {
                    return;
                }
                let right = right.span_mut(0, half.min(count - b));
                rarely(simd, FillTile { tree_view, index, from: b, tile: right });
                bucket::sweep_across(
                    simd,
                    [left, right],
                    axis,
                    &mut scratch.leaf_scratch,
                    tree_view.boxes,
                    sink,
                );
            }
        }
    }
}

/// Fills a tile with the members and ghosts of a leaf from number `from` on.
struct FillTile<'p, 'g> {
    tree_view: &'p TreeView<'g>,
    index: usize,
    from: usize,
    tile: &'p mut [Record],
}

impl Phase for FillTile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { tree_view, index, from, tile } = self;
        let members = tree_view.members(&tree_view.leaves.at(index));
        let own = members.get(from..).unwrap_or_default();
        let (inside, outside) = tile.split_at_mut(own.len().min(tile.len()));
        inside.copy_in(own);
        if !outside.is_empty() {
            tree_view.gather(simd, index, from.saturating_sub(members.len()), outside);
        }
    }
}
