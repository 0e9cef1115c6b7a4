//! Computes how many items of each kind a world has.

use super::limits::{
    BUCKET, CHUNK, FEW, SMALL, SUB_LEVELS, TINY, depth_for, histogram_row, row_of_bits, slot_blocks,
};
use super::scratch;
use crate::config::{Config, EVENTS, FILTERS, LISTS, MARGINS, Mode, TREE, VALUES};
use crate::error::{Error, Field};
use crate::id::Index;
use crate::simd::EIGHT;

/// The memory that a world needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Layout {
    /// The length of the slab in bytes.
    pub bytes: usize,
    /// The alignment of the slab in bytes.
    pub align: usize,
}

/// A cache line, which is at least the alignment of every item.
pub(crate) const ALIGN: usize = 64;

/// The memory of a world with this configuration, for slots of width `I`. `None` if the index width, the
/// address space or the features of the build do not allow it, if the number of workers is not from 1 to 32,
/// or if the margin is not valid.
///
/// A constant function, so it can size a static. The size is linear in objects, leaf references and pairs.
///
/// ```
/// use trisap_core::{Capacity, Config, layout};
///
/// let layout = layout::<u32>(&Config::new(Capacity::for_objects(1000))).unwrap();
/// let memory = std::alloc::Layout::from_size_align(layout.bytes, layout.align)?; // for your own allocator
/// # Ok::<(), std::alloc::LayoutError>(())
/// ```
#[must_use]
pub const fn layout<I: Index>(config: &Config) -> Option<Layout> {
    match Sizes::of::<I>(config) {
        Ok(sizes) => Some(Layout { bytes: sizes.bytes, align: ALIGN }),
        Err(_) => None,
    }
}

/// How many items of each kind a world has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    pub(crate) config: Config,
    /// All of them.
    pub(crate) bytes: usize,
    pub(crate) objects: usize,
    /// Objects with a fat box.
    pub(crate) fat: usize,
    /// Objects in the tree: all, or none in a world without a tree.
    pub(crate) tree: usize,
    /// Objects in the sorted list: all of a world without a tree, or none if that tests every two boxes.
    pub(crate) list: usize,
    pub(crate) straddlers: usize,
    pub(crate) leaves: usize,
    /// Leaves of a full step: half as many again as new planes make. The others are their sub-leaves.
    pub(crate) whole_leaves: usize,
    pub(crate) pairs: usize,
    /// Pairs of the last step, kept for the events.
    pub(crate) previous: usize,
    /// Chunks of pairs that workers write before they are put in order.
    pub(crate) staged: usize,
    pub(crate) workers: usize,
    /// Records in one worker's scratch.
    pub(crate) bucket: usize,
}

/// Whether a world has no tree.
pub(crate) const fn is_small(config: &Config) -> bool {
    !TREE || config.capacity.objects as usize <= config.forced.leaf_target() / 8 || config.lean
}

/// Whether boxes with margins stand beside the boxes as given, and are reported.
pub(crate) const fn reports_margins(config: &Config) -> bool {
    MARGINS && config.margin.is_some() && matches!(config.mode, Mode::Fat)
}

/// Whether boxes with margins are swept, and not reported.
pub(crate) const fn sweeps_margins(config: &Config) -> bool {
    MARGINS && config.margin.is_some() && matches!(config.mode, Mode::Exact)
}

/// Whether objects have a fat box.
pub(crate) const fn has_fat(config: &Config) -> bool {
    TREE && !is_small(config) && (sweeps_margins(config) || config.predicted)
}

/// So many, if there are any.
pub(crate) const fn if_so(there_are: bool, count: usize) -> usize {
    if there_are { count } else { 0 }
}

impl Sizes {
    /// # Errors
    /// Those of [`World::new_in`](crate::World::new_in) that are due to the configuration.
    pub(crate) const fn of<I: Index>(config: &Config) -> Result<Self, Error> {
        let capacity = &config.capacity;
        let most_objects = if config.lean && LISTS {
            SMALL as u32
        } else if config.lean || !TREE {
            TINY as u32
        } else {
            I::MAX_OBJECTS
        };
        let (field, most) = if config.workers == 0 || config.workers > 32 {
            (Field::Workers, 32)
        } else if capacity.objects > most_objects {
            (Field::Objects, most_objects as u64)
        } else if config.events && !EVENTS {
            (Field::Events, 0)
        } else if config.margin.is_some() && !MARGINS {
            (Field::Margin, 0)
        } else if config.filters && !FILTERS {
            (Field::Filters, 0)
        } else if config.values && !VALUES {
            (Field::Values, 0)
        } else {
            (Field::Bytes, isize::MAX as u64)
        };
        let too_large = Err(Error::CapacityTooLarge { field, most });
        if let Some(margin) = &config.margin
            && !margin.is_valid()
        {
            return Err(Error::BadMargin);
        }
        if !matches!(field, Field::Bytes) {
            return too_large;
        }
        // On a 16-bit host these would not fit; no such target is supported.
        let (objects, small) = (capacity.objects as usize, is_small(config));
        let pairs = capacity.pairs as usize;
        let tree = if_so(!small, objects);
        let made = 1usize << depth_for(tree, config.forced.leaf_target());
        let whole_leaves = if_so(tree > 0, if made == 1 { 1 } else { made + made / 2 + 2 });
        let mut sizes = Self {
            config: *config,
            bytes: 0,
            objects,
            fat: if_so(has_fat(config), objects),
            tree,
            list: if_so(LISTS && small && objects > FEW, objects),
            straddlers: if_so(tree > 0, capacity.leaf_refs as usize),
            leaves: whole_leaves << SUB_LEVELS,
            whole_leaves,
            pairs,
            previous: if_so(config.events, pairs),
            // The block of each leaf may leave its last chunk unfinished.
            staged: if_so(config.workers > 1 && !small, pairs.div_ceil(CHUNK) + whole_leaves + 1),
            workers: config.workers as usize,
            bucket: if_so(!small, scratch::bucket(objects)),
        };
        match sizes.sum::<I>() {
            // Below `isize::MAX`, which is no multiple.
            Some(bytes) => sizes.bytes = bytes.next_multiple_of(ALIGN),
            None => return too_large,
        }
        Ok(sizes)
    }

    pub(crate) const fn is_small(&self) -> bool {
        !TREE || self.bucket == 0
    }

    /// One item for each object of a world that has some.
    pub(crate) const fn by_object(&self, has: bool) -> usize {
        if_so(has, self.objects)
    }

    /// Bits that tell whether a reported box has changed, one an object, for events. A world with fat boxes
    /// and a tree needs them, too: it parks a pair only while both boxes stay, also inside fat boxes.
    pub(crate) const fn changed(&self) -> usize {
        if_so(self.keeps_boxes() || TREE && self.fat > 0, self.objects)
    }

    /// Whether events are told by the boxes of the last complete step; if not, by a bit for each two slots.
    pub(crate) const fn keeps_boxes(&self) -> bool {
        EVENTS && self.config.events && !self.is_small()
    }

    /// Words with a bit for each two slots, for events.
    pub(crate) const fn met(&self) -> usize {
        // Not told for others: 32 bits do not suffice for so many slots.
        if EVENTS && self.config.events && self.is_small() { row_of_bits(self.objects) } else { 0 }
    }

    /// Records of all leaves. They are read in groups of eight, also behind the last leaf.
    pub(crate) const fn records(&self) -> usize {
        if_so(TREE && self.tree > 0, self.tree + self.tree / 8 + 4 * self.leaves + EIGHT)
    }

    /// Slots in the scratch memory of a step: a byte for each object, but at least as many slots as objects, up
    /// to those of a [`BUCKET`].
    pub(crate) const fn spare<I>(&self) -> usize {
        let (some, few) =
            (self.tree.div_ceil(size_of::<I>()), if self.tree < BUCKET { self.tree } else { BUCKET });
        if_so(TREE, if some < few { few } else { some })
    }

    pub(crate) const fn histogram(&self) -> usize {
        let (counts, ends) = (slot_blocks(self.workers) * histogram_row(self.whole_leaves), self.leaves + 2);
        if_so(TREE && self.tree > 0, if counts > ends { counts } else { ends })
    }

    /// Where sections start: on a cache line, or in small worlds, which have no tree, where any item may.
    const fn align(&self) -> usize {
        if TREE && self.tree > 0 { ALIGN } else { 16 }
    }
}

/// The bytes of so many before and a section of `count` items, to where the next section starts.
pub(super) const fn section<T>(count: usize, before: Option<usize>, sizes: &Sizes) -> Option<usize> {
    let (Some(before), Some(bytes)) = (before, count.checked_mul(size_of::<T>())) else { return None };
    let Some(bytes) = bytes.checked_next_multiple_of(sizes.align()) else { return None };
    // No slice is longer than `isize::MAX`.
    if bytes > isize::MAX as usize - before { None } else { Some(before + bytes) }
}
