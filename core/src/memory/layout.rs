//! Computes how many items of each kind a world has.

use super::limits::{
    CHUNK, LEAVES_PER_BLOCK, SLOT_BLOCKS, SMALL, SUB_LEVELS, TINY, depth_for, histogram_row,
};
use super::scratch;
use crate::config::{Config, Mode};
use crate::error::{Error, Field};
use crate::filter::{CLASSES, FILTERS};
use crate::id::Index;
use crate::simd::{CACHE_LINE, EIGHT};

/// The memory that a world needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Layout {
    /// The length of the slab in bytes.
    pub bytes: usize,
    /// The alignment of the slab in bytes.
    pub align: usize,
}

/// For an allocator.
impl TryFrom<Layout> for core::alloc::Layout {
    type Error = core::alloc::LayoutError;

    fn try_from(layout: Layout) -> Result<Self, Self::Error> {
        Self::from_size_align(layout.bytes, layout.align)
    }
}

/// Whether there can be values. Small builds leave out their code.
pub(crate) const VALUES: bool = cfg!(feature = "large");

/// A cache line, which is at least the alignment of every item.
pub(crate) const ALIGN: usize = CACHE_LINE;

/// The memory of a world with this configuration, for slots of width `I`. `None` if the index width, the address
/// space or the features of the build do not allow it, if the number of workers is not from 1 to 32, or if the margin
/// is not valid.
///
/// A constant function, so a static can be sized by it. The size is linear in objects, leaf references and pairs.
///
/// ```
/// use trisap_core::{Capacity, Config, layout};
///
/// let layout = layout::<u32>(&Config::new(Capacity::for_objects(1000))).unwrap();
/// let memory = std::alloc::Layout::try_from(layout)?; // for an allocator of your own
/// assert_eq!((memory.size(), memory.align()), (layout.bytes, layout.align));
/// # Ok::<(), std::alloc::LayoutError>(())
/// ```
#[must_use]
pub const fn layout<I: Index>(config: &Config) -> Option<Layout> {
    match Sizes::of::<I>(config) {
        Some(sizes) => match sizes.bytes::<I>() {
            // Below `isize::MAX`, which is no multiple.
            Some(bytes) => Some(Layout { bytes: bytes.next_multiple_of(ALIGN), align: ALIGN }),
            None => None,
        },
        None => None,
    }
}

/// Why a configuration with a valid margin has no layout.
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

/// How many items of each kind a world has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sizes {
    pub(crate) objects: usize,
    /// Objects with a fat box, and with a margin of their own.
    pub(crate) fat: usize,
    pub(crate) margins: usize,
    /// Objects whose last box is kept for the events.
    pub(crate) before: usize,
    /// Bits that tell whether a reported box has changed, one an object. Events need them. An exact world with
    /// margins and a tree needs them too: it may park a pair only while both boxes stay, also inside their fat boxes.
    pub(crate) changed: usize,
    /// Objects with a filter, and rows of the class matrix.
    pub(crate) filters: usize,
    pub(crate) classes: usize,
    /// Objects with a value, and those whose value is kept for the events.
    pub(crate) values: usize,
    pub(crate) former_values: usize,
    /// Objects in the tree: all, or none in a world without a tree.
    pub(crate) tree: usize,
    pub(crate) records: usize,
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
    config.capacity.objects as usize <= TINY || config.lean
}

/// Whether objects have a fat box.
pub(crate) const fn has_fat(config: &Config) -> bool {
    config.margin.is_some() || config.predicted && matches!(config.mode, Mode::Exact) && !is_small(config)
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
        // On a 16-bit host these would not fit; no such target is supported.
        let objects = capacity.objects as usize;
        let small = is_small(config);
        if small && objects > SMALL || !small && !cfg!(feature = "large") {
            return None;
        }
        if config.filters && !FILTERS || config.values && !VALUES {
            return None;
        }
        let pairs = capacity.pairs as usize;
        let tree = if small { 0 } else { objects };
        let made = 1usize << depth_for(tree);
        let whole_leaves = if tree == 0 {
            0
        } else if made == 1 {
            1
        } else {
            made + made / 2 + 2
        };
        let (blocks, leaves) = (whole_leaves.div_ceil(LEAVES_PER_BLOCK), whole_leaves << SUB_LEVELS);
        let has_fat = has_fat(config);
        let moves_inside_margin = has_fat && matches!(config.mode, Mode::Exact);
        Some(Self {
            objects,
            fat: if has_fat { objects } else { 0 },
            margins: if config.margin.is_some() { objects } else { 0 },
            before: if config.events { objects } else { 0 },
            changed: if config.events || moves_inside_margin && tree > 0 { objects } else { 0 },
            filters: if config.filters { objects } else { 0 },
            classes: if config.filters { CLASSES } else { 0 },
            values: if config.values { objects } else { 0 },
            former_values: if config.values && config.events { objects } else { 0 },
            tree,
            // Records are read in groups of eight, also behind the last leaf.
            records: if tree > 0 { tree + tree / 8 + 4 * leaves + EIGHT } else { 0 },
            straddlers: if tree > 0 { capacity.leaf_refs as usize } else { 0 },
            leaves,
            whole_leaves,
            pairs,
            previous: if config.events { pairs } else { 0 },
            // Each block may leave its last chunk unfinished.
            staged: if config.workers > 1 && !small { pairs.div_ceil(CHUNK) + blocks + 1 } else { 0 },
            workers: config.workers as usize,
            bucket: if small { 0 } else { scratch::bucket(objects) },
        })
    }

    /// Whether the world has no tree.
    pub(crate) const fn is_small(&self) -> bool {
        !cfg!(feature = "large") || self.bucket == 0
    }

    /// Entries of the histogram.
    pub(crate) const fn histogram(&self) -> usize {
        if self.tree > 0 { SLOT_BLOCKS * histogram_row(self.whole_leaves) } else { 0 }
    }

    /// Where sections start: on a cache line, or in worlds without a tree, which are small, where any item may.
    const fn align(&self) -> usize {
        if self.tree > 0 { ALIGN } else { 16 }
    }
}

/// The bytes of so many before and a section of `count` items, to where the next section starts.
pub(super) const fn section<T>(count: usize, before: Option<usize>, sizes: &Sizes) -> Option<usize> {
    let (Some(before), Some(bytes)) = (before, count.checked_mul(size_of::<T>())) else { return None };
    let Some(bytes) = bytes.checked_next_multiple_of(sizes.align()) else { return None };
    // No slice is longer than `isize::MAX`.
    if bytes > isize::MAX as usize - before { None } else { Some(before + bytes) }
}
