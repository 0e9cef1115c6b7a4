//! Reads a snapshot in the caller's bytes, of any alignment, so that all of it can be checked before a world changes.

use crate::access::{Access, bits};
use crate::filter::Filter;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::layout::Sizes;
use crate::memory::state::State;
use crate::tree::{Frame, Record};
use crate::validate::content::{Content, LeafCounts, Place, Set};
use crate::validate::{pairs, tree};
use bytemuck::Pod;
use core::marker::PhantomData;

/// Items in bytes of any alignment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packed<'b, T> {
    bytes: &'b [u8],
    items: PhantomData<T>,
}

impl<'b, T: Pod + Default> Packed<'b, T> {
    /// The items in order.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = T> + use<'b, T> {
        // Each chunk has the length of an item.
        let item = |bytes| bytemuck::try_pod_read_unaligned(bytes).unwrap_or_default();
        self.bytes.chunks_exact(size_of::<T>()).map(item)
    }

    /// The item, or the default: see [`Access`].
    #[inline(always)]
    pub(super) fn at(&self, index: usize) -> T {
        debug_assert!(index < self.len(), "read {index} of {}", self.len());
        self.get(index).unwrap_or_default()
    }

    #[inline(always)]
    fn get(&self, index: usize) -> Option<T> {
        let bytes = self.bytes.chunks_exact(size_of::<T>()).nth(index)?;
        bytemuck::try_pod_read_unaligned(bytes).ok()
    }

    pub(super) const fn len(&self) -> usize {
        self.bytes.len() / size_of::<T>()
    }

    /// Copies the items to the front of a slice and gives the rest of it another value.
    pub(super) fn copy_to(&self, to: &mut [T], rest: T) {
        let (to, behind) = to.split_at_mut_checked(self.len()).unwrap_or_default();
        bytemuck::try_cast_slice_mut::<T, u8>(to).unwrap_or_default().copy_in(self.bytes);
        behind.fill(rest);
    }
}

/// Cuts sections off the bytes.
struct Cutter<'b> {
    rest: &'b [u8],
}

impl<'b> Cutter<'b> {
    fn cut<T: Pod>(&mut self, count: usize) -> Option<Packed<'b, T>> {
        let (bytes, rest) = self.rest.split_at_checked(count.checked_mul(size_of::<T>())?)?;
        self.rest = rest;
        Some(Packed { bytes, items: PhantomData })
    }
}

/// The sections of a snapshot, in this order. The state comes before them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored<'b, I> {
    pub(super) now: Packed<'b, KeyBox>,
    pub(super) fat: Packed<'b, KeyBox>,
    pub(super) margins: Packed<'b, f32>,
    pub(super) filters: Packed<'b, Filter>,
    pub(super) classes: Packed<'b, u32>,
    pub(super) refiltered: Packed<'b, u32>,
    pub(super) values: Packed<'b, u64>,
    pub(super) generations: Packed<'b, u32>,
    pub(super) moved: Packed<'b, u32>,
    pub(super) resting: Packed<'b, u32>,
    pub(super) changed: Packed<'b, u32>,
    pub(super) active: Packed<'b, u32>,
    pub(super) planes: Packed<'b, i32>,
    pub(super) leaves: Packed<'b, LeafCounts>,
    /// Of each whole leaf: from where on a box is a large object.
    pub(super) far: Packed<'b, [i32; 3]>,
    /// The origin and the scale of its frame.
    pub(super) frames: Packed<'b, [[f32; 3]; 2]>,
    /// The lanes of [`TreeParts::bounds`](crate::memory::slab::TreeParts::bounds).
    pub(super) bounds: Packed<'b, [u16; 6]>,
    /// From the root on.
    pub(super) nodes: Packed<'b, KeyBox>,
    /// The slots of all records, and those of the large objects.
    pub(super) members: Packed<'b, I>,
    pub(super) large: Packed<'b, I>,
    pub(super) pairs: Packed<'b, Pair<I>>,
    pub(super) previous: Packed<'b, Pair<I>>,
    /// See [`Segments::ends`](crate::memory::slab::Segments::ends).
    pub(super) segments: Packed<'b, u32>,
    pub(super) before: Packed<'b, KeyBox>,
    pub(super) reused: Packed<'b, u32>,
    /// Of the reused slots: the generations and values of former objects.
    pub(super) former: Packed<'b, u32>,
    pub(super) former_values: Packed<'b, u64>,
}

/// The lengths of sections that follow from the state alone.
pub(super) struct Lengths {
    pub(super) slots: usize,
    pub(super) words: usize,
    pub(super) planes: usize,
    pub(super) leaves: usize,
    pub(super) whole_leaves: usize,
    pub(super) bounds: usize,
    pub(super) nodes: usize,
    pub(super) large: usize,
    pub(super) pairs: usize,
    pub(super) previous: usize,
}

impl Lengths {
    /// From a state whose numbers have been checked.
    pub(super) fn of(state: &State, sizes: &Sizes) -> Self {
        let filled = |count: usize| if state.tree.filled != 0 { count } else { 0 };
        let slots = state.objects.slots as usize;
        Self {
            slots,
            words: bits::words(slots),
            planes: tree::planes(state, sizes.depth),
            leaves: tree::leaves(state),
            whole_leaves: filled(1 << state.tree.depth),
            bounds: if state.tree.subdivided != 0 { filled(tree::leaves(state)) } else { 0 },
            nodes: filled((2 << state.tree.depth) - 1),
            large: filled(state.tree.large as usize),
            pairs: state.pairs.swept as usize,
            previous: pairs::previous(state) as usize,
        }
    }
}

impl<'b, I: Index> Stored<'b, I> {
    /// Cuts the bytes behind a state whose numbers have been checked. `None` if there are too few bytes, or too many.
    pub(super) fn cut(state: &State, sizes: &Sizes, body: &'b [u8]) -> Option<Self> {
        let mut body = Cutter { rest: body };
        let lengths = Lengths::of(state, sizes);
        let Lengths { slots, words, .. } = lengths;
        let kept = |room: usize, count: usize| if room > 0 { count } else { 0 };
        let now = body.cut(slots)?;
        let fat = body.cut(kept(sizes.fat, slots))?;
        let margins = body.cut(kept(sizes.fat, slots))?;
        let filters = body.cut(kept(sizes.filters, slots))?;
        let classes = body.cut(sizes.classes)?;
        let refiltered = body.cut(kept(sizes.filters, words))?;
        let values = body.cut(kept(sizes.values, slots))?;
        let generations = body.cut(slots)?;
        let moved = body.cut(words)?;
        let resting = body.cut(words)?;
        let changed: Packed<'b, u32> = body.cut(kept(sizes.changed, words))?;
        let active = body.cut(kept(sizes.tree, words))?;
        let planes = body.cut(lengths.planes)?;
        let leaves: Packed<'b, LeafCounts> = body.cut(lengths.leaves)?;
        let far = body.cut(lengths.whole_leaves)?;
        let frames = body.cut(lengths.whole_leaves)?;
        let bounds = body.cut(lengths.bounds)?;
        let nodes = body.cut(lengths.nodes)?;
        let members = leaves.iter().map(|leaf| u64::from(leaf.len)).sum::<u64>();
        // No slot has two records.
        let members = usize::try_from(members).ok().filter(|members| *members <= slots)?;
        let (members, large) = (body.cut(members)?, body.cut(lengths.large)?);
        let (pairs, previous) = (body.cut(lengths.pairs)?, body.cut(kept(sizes.previous, lengths.previous))?);
        let blocks: Packed<'b, u32> = body.cut(kept(sizes.event_blocks, 1))?;
        let blocks = blocks.get(0).unwrap_or_default() as usize;
        let segments = if blocks <= sizes.event_blocks { body.cut(2 * blocks)? } else { return None };
        let ones = |words: &Packed<'b, u32>| words.iter().map(|word| word.count_ones() as usize).sum();
        let before = body.cut(kept(sizes.before, ones(&changed)))?;
        let reused: Packed<'b, u32> = body.cut(kept(sizes.before, words))?;
        let former = body.cut(ones(&reused))?;
        let former_values = body.cut(kept(sizes.former_values, ones(&reused)))?;
        let stored = Self {
            now,
            fat,
            margins,
            filters,
            classes,
            refiltered,
            values,
            generations,
            moved,
            resting,
            changed,
            active,
            planes,
            leaves,
            far,
            frames,
            bounds,
            nodes,
            members,
            large,
            pairs,
            previous,
            segments,
            before,
            reused,
            former,
            former_values,
        };
        body.rest.is_empty().then_some(stored)
    }
}

/// A snapshot while it is checked.
pub(super) struct Image<'b, 'm, I> {
    pub(super) sizes: &'b Sizes,
    pub(super) state: &'b State,
    pub(super) stored: Stored<'b, I>,
    /// One bit a slot: a place in the tree has been seen.
    pub(super) placed: &'m mut [u32],
}

impl<I: Index> Content<I> for Image<'_, '_, I> {
    fn sizes(&self) -> &Sizes {
        self.sizes
    }

    fn state(&self) -> &State {
        self.state
    }

    #[inline(always)]
    fn now(&self, slot: usize) -> KeyBox {
        self.stored.now.at(slot)
    }

    #[inline(always)]
    fn fat(&self, slot: usize) -> KeyBox {
        self.stored.fat.at(slot)
    }

    fn margin(&self, slot: usize) -> f32 {
        self.stored.margins.at(slot)
    }

    fn before(&self, _: usize, rank: usize) -> KeyBox {
        self.stored.before.at(rank)
    }

    fn former(&self, _: usize, rank: usize) -> u32 {
        self.stored.former.at(rank)
    }

    fn former_value(&self, _: usize, rank: usize) -> u64 {
        self.stored.former_values.at(rank)
    }

    fn value(&self, slot: usize) -> u64 {
        self.stored.values.at(slot)
    }

    fn filter(&self, slot: usize) -> Filter {
        self.stored.filters.at(slot)
    }

    fn class(&self, class: usize) -> u32 {
        self.stored.classes.at(class)
    }

    fn generation(&self, slot: usize) -> u32 {
        self.stored.generations.at(slot)
    }

    #[inline(always)]
    fn word(&self, set: Set, index: usize) -> Option<u32> {
        match set {
            Set::Moved => &self.stored.moved,
            Set::Resting => &self.stored.resting,
            Set::Changed => &self.stored.changed,
            Set::Active => &self.stored.active,
            Set::Refiltered => &self.stored.refiltered,
            Set::Reused => &self.stored.reused,
        }
        .get(index)
    }

    fn plane(&self, node: usize) -> i32 {
        self.stored.planes.at(node)
    }

    fn leaf(&self, index: usize) -> LeafCounts {
        self.stored.leaves.at(index)
    }

    fn frame(&self, whole: usize) -> Frame {
        let [origin, scale] = self.stored.frames.at(whole);
        Frame::new(origin, scale)
    }

    fn bounds(&self, leaf: usize) -> Record {
        Record { lanes: self.stored.bounds.get(leaf).unwrap_or_default(), tag: 0 }
    }

    fn node(&self, node: usize) -> KeyBox {
        self.stored.nodes.at(node - 1)
    }

    #[inline(always)]
    fn member(&self, _: usize, packed: usize) -> usize {
        self.stored.members.at(packed).at()
    }

    fn large(&self, at: usize) -> usize {
        self.stored.large.at(at).at()
    }

    #[inline(always)]
    fn pair(&self, at: usize) -> Pair<I> {
        self.stored.pairs.at(at)
    }

    fn previous(&self, at: usize) -> Pair<I> {
        self.stored.previous.at(at)
    }

    fn segments(&self) -> usize {
        self.stored.segments.len()
    }

    fn segment(&self, at: usize) -> u32 {
        self.stored.segments.at(at)
    }

    #[inline(always)]
    fn is_at(&mut self, slot: usize, _: Place) -> bool {
        bits::set(self.placed, slot)
    }
}
