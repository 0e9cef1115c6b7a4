//! The one table of what a world stores and where.
//!
//! [`Sizes`] says how many items of each kind a configuration needs; [`Plan`] walks them in order, once to add up
//! the bytes and once to carve the slab, so that the two cannot disagree.

use super::leaf::{Cell, Leaf, Straddler};
use super::limits::{
    CHUNK, LEAF_TARGET, LEAVES_PER_BLOCK, SLOT_BLOCKS, SMALL, SUB_LEVELS, TINY, histogram_row,
};
use super::scratch;
use super::slot_set::SlotSet;
use super::state::State;
use super::stripes::{Member, Planes};
use crate::access::bits;
use crate::config::{Config, Mode};
use crate::error::{Error, Field};
use crate::filter::{CLASSES, FILTERS, Filter};
use crate::geometry::key::KeyBox;
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use crate::simd::{CACHE_LINE, EIGHT};

/// The memory that a world needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The length of the slab in bytes.
    pub bytes: usize,
    /// The boundary that the slab starts on.
    pub align: usize,
}

/// Whether there can be values. A lean program does without their code.
pub(crate) const VALUES: bool = cfg!(feature = "large");

/// A cache line; also more than any item asks for.
pub(crate) const ALIGN: usize = CACHE_LINE;

/// The bytes of a world with this configuration, for slots of width `I`. `None` where the index width, the address
/// space or the number of workers (1 to 32) does not allow it, or where the margin is not valid.
///
/// Constant, so that a static can be sized by it. The size grows linearly with objects, leaf references and pairs.
#[must_use]
pub const fn layout<I: Index>(config: &Config) -> Option<Layout> {
    match Sizes::of::<I>(config) {
        Some(sizes) => match sizes.bytes::<I>() {
            Some(bytes) => Some(Layout { bytes, align: ALIGN }),
            None => None,
        },
        None => None,
    }
}

/// What a configuration has too much of that has no layout, though its margin is valid.
pub(crate) const fn beyond<I: Index>(config: &Config) -> Error {
    let objects = if config.lean {
        SMALL as u32
    } else if cfg!(feature = "large") {
        I::MAX_OBJECTS
    } else {
        TINY as u32
    };
    let (field, most) = if config.workers == 0 || config.workers > 32 {
        (Field::Workers, 32)
    } else if config.capacity.objects > objects {
        (Field::Objects, objects as u64)
    } else if config.filters && !FILTERS {
        (Field::Filters, 0)
    } else if config.values && !VALUES {
        (Field::Values, 0)
    } else {
        (Field::Bytes, isize::MAX as u64)
    };
    Error::CapacityTooLarge { field, most }
}

/// How many items of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sizes {
    pub(crate) objects: usize,
    /// Objects with a fat box.
    pub(crate) fat: usize,
    /// Objects whose last box is kept for the events.
    pub(crate) before: usize,
    /// Bits that tell whether a reported box has changed, one an object. Events need them. So does an exact world with margins
    /// and a tree: a pair may be parked only if both boxes stay, also inside their fat boxes.
    pub(crate) changed: usize,
    /// Objects with a filter, and rows of the class matrix.
    pub(crate) filters: usize,
    pub(crate) classes: usize,
    /// Objects with a value, and those whose value is kept for the events.
    pub(crate) values: usize,
    pub(crate) former_values: usize,
    /// Objects in the tree: all, or none where the world is swept box by box.
    pub(crate) tree: usize,
    pub(crate) records: usize,
    pub(crate) straddlers: usize,
    /// The depth of the deepest tree.
    pub(crate) depth: u32,
    pub(crate) leaves: usize,
    /// Leaves of a full step, which the others are parts of.
    pub(crate) whole_leaves: usize,
    pub(crate) pairs: usize,
    /// Pairs of the last step, kept for the events.
    pub(crate) previous: usize,
    /// Blocks of leaves in a full step, where events are told block by block: see
    /// [`Segments`](super::slab::Segments).
    pub(crate) event_blocks: usize,
    /// Pairs of parallel workers before they are put in order.
    pub(crate) staged: usize,
    pub(crate) workers: usize,
    /// Objects of a world that is swept in stripes.
    pub(crate) members: usize,
    /// Records in one worker's scratch.
    pub(crate) bucket: usize,
}

impl Sizes {
    pub(crate) const fn of<I: Index>(config: &Config) -> Option<Self> {
        let capacity = &config.capacity;
        if capacity.objects > I::MAX_OBJECTS || config.workers == 0 || config.workers > 32 {
            return None;
        }
        if let Some(margin) = &config.margin
            && !margin.is_valid()
        {
            return None;
        }
        // Slots, chunks and counts of a 16-bit host would not fit; there is none that this is built for.
        let objects = capacity.objects as usize;
        let small = objects <= TINY || config.lean;
        if small && objects > SMALL || !small && !cfg!(feature = "large") {
            return None;
        }
        if config.filters && !FILTERS || config.values && !VALUES {
            return None;
        }
        let pairs = capacity.pairs as usize;
        let tree = if small { 0 } else { objects };
        let mut depth = 0;
        while tree > LEAF_TARGET << depth {
            depth += 1;
        }
        let blocks = if tree > 0 { (1usize << depth).div_ceil(LEAVES_PER_BLOCK) } else { 0 };
        if tree > 0 {
            depth += SUB_LEVELS;
        }
        let leaves = if tree > 0 { 1 << depth } else { 0 };
        let moves_inside_margin = config.margin.is_some() && matches!(config.mode, Mode::Exact);
        Some(Self {
            objects,
            fat: if config.margin.is_some() { objects } else { 0 },
            before: if config.events { objects } else { 0 },
            changed: if config.events || moves_inside_margin && tree > 0 { objects } else { 0 },
            filters: if config.filters { objects } else { 0 },
            classes: if config.filters { CLASSES } else { 0 },
            values: if config.values { objects } else { 0 },
            former_values: if config.values && config.events { objects } else { 0 },
            tree,
            // Casts look at whole groups of records, also of the last leaf's.
            records: if tree > 0 { tree + tree / 8 + 4 * leaves + EIGHT } else { 0 },
            straddlers: if tree > 0 { capacity.leaf_refs as usize } else { 0 },
            depth,
            leaves,
            whole_leaves: leaves >> SUB_LEVELS,
            pairs,
            previous: if config.events { pairs } else { 0 },
            event_blocks: if config.events { blocks } else { 0 },
            // Every block may leave a chunk unfinished.
            staged: if config.workers > 1 && !small { pairs.div_ceil(CHUNK) + blocks + 1 } else { 0 },
            workers: config.workers as usize,
            members: if small && objects > TINY { objects } else { 0 },
            bucket: if small { 0 } else { scratch::bucket(objects) },
        })
    }

    /// Whether the world is swept box by box.
    pub(crate) const fn is_small(&self) -> bool {
        !cfg!(feature = "large") || self.bucket == 0
    }

    /// Entries of the histogram at the greatest depth of a full step.
    pub(crate) const fn histogram(&self) -> usize {
        if self.tree > 0 { SLOT_BLOCKS * histogram_row(self.depth - SUB_LEVELS) } else { 0 }
    }

    /// Whether the world is swept in stripes, as a count.
    pub(crate) const fn striped(&self) -> usize {
        (self.members > 0) as usize
    }

    const fn bytes<I: Index>(&self) -> Option<usize> {
        let objects = self.objects;
        let mut plan = Plan::new();
        plan.add::<State>(1);
        plan.add::<KeyBox>(objects);
        plan.add::<KeyBox>(self.fat);
        plan.add::<f32>(self.fat);
        plan.add::<KeyBox>(self.before);
        plan.add::<u32>(self.before);
        plan.add::<u32>(SlotSet::len(self.before));
        plan.add::<Filter>(self.filters);
        plan.add::<u32>(self.classes);
        plan.add::<u32>(SlotSet::len(self.filters));
        plan.add::<u64>(self.values + self.former_values);
        plan.add::<u32>(objects);
        plan.add::<u32>(2 * bits::words(objects) + SlotSet::len(objects));
        plan.add::<u32>(SlotSet::len(self.changed) + SlotSet::len(self.before));
        plan.add::<u32>(bits::words(self.tree));
        plan.add::<I>(3 * objects);
        plan.add::<I>(2 * self.tree);
        plan.add::<Record>(self.records);
        plan.add::<Straddler>(self.straddlers);
        plan.add::<i32>(self.leaves);
        plan.add::<Cell>(self.leaves);
        plan.add::<Frame>(self.whole_leaves);
        plan.add::<Leaf>(self.leaves);
        plan.add::<Record>(self.leaves);
        plan.add::<KeyBox>(2 * self.whole_leaves);
        plan.add::<u32>(self.histogram());
        plan.add::<[u32; 2]>(3 * self.event_blocks);
        plan.add::<u32>((self.event_blocks > 0) as usize);
        plan.add::<Pair<I>>(self.pairs);
        plan.add::<Pair<I>>(self.previous);
        match self.staged.checked_mul(CHUNK) {
            Some(pairs) => plan.add::<Pair<I>>(pairs),
            None => return None,
        }
        plan.add::<[u32; 3]>(self.staged);
        plan.add::<Member>(self.members);
        plan.add::<Planes>(self.striped());
        plan.add::<Record>(self.workers * scratch::records::<I>(self.bucket));
        plan.bytes
    }
}

/// Adds up sections, each on its own cache line.
struct Plan {
    bytes: Option<usize>,
}

impl Plan {
    const fn new() -> Self {
        Self { bytes: Some(0) }
    }

    const fn add<T>(&mut self, count: usize) {
        self.bytes = match (self.bytes, section::<T>(count)) {
            // Slices end at `isize::MAX`.
            (Some(sum), Some(more)) if more <= isize::MAX as usize - sum => Some(sum + more),
            _ => None,
        };
    }
}

/// The bytes of a section of `count` items, to the next cache line.
pub(crate) const fn section<T>(count: usize) -> Option<usize> {
    match count.checked_mul(size_of::<T>()) {
        Some(bytes) => bytes.checked_next_multiple_of(ALIGN),
        None => None,
    }
}
