//! The few numbers of a world that are not arrays.

use super::limits::{LEAVES_PER_BLOCK, SUB_LEVELS};
use super::stats::{Path, Progress, Reason, Route, Stats};
use crate::config::{Capacity, Choice, Config, Margin, Mode};
use crate::error::Field;
use crate::geometry::extent::Extent;
use bytemuck::{Pod, Zeroable};

/// See the module. Plain bytes, as it lives in the slab.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct State {
    magic: u32,
    index_bytes: u32,
    // The configuration.
    objects: u32,
    leaf_refs: u32,
    pairs_capacity: u32,
    margin: [f32; 3],
    /// All that is a choice between two or three: see the constants.
    flags: u32,
    workers: u32,

    /// Living objects.
    pub(crate) live: u32,
    /// Slots that have ever been in use.
    pub(crate) slots: u32,
    /// The free slot that was freed last, plus one; each free slot holds the next.
    pub(crate) free: u32,

    /// Slots in the sorted lists.
    pub(crate) listed: u32,

    /// Living objects when the planes were made, or zero where there are none.
    pub(crate) built: u32,
    /// The depth that full steps use the planes to; less than planned where copies would take too much room.
    pub(crate) depth: u32,
    /// Zero where the leaves are those of the last full step; else one more than how many of those are divided, the first ones
    /// first.
    pub(crate) subdivided: u32,
    /// Movers so far, of the many that it takes to make the boxes of all leaves tight.
    pub(crate) moved_since_refit: u32,
    /// First large object among the straddlers, and how many there are.
    pub(crate) large_start: u32,
    pub(crate) large: u32,
    /// Bounds of the minima.
    pub(crate) low: [i32; 3],
    pub(crate) high: [i32; 3],
    /// The sum of squares of the leaves' counts when their planes were new: what new planes can achieve.
    pub(crate) baseline: u64,
    /// Candidates that were no pairs in the first full step with these planes: the work that new planes leave.
    pub(crate) baseline_work: u64,
    /// Candidates that tied when all leaves were filled from the boxes.
    pub(crate) baseline_ties: u64,

    /// Overlaps of swept boxes in the pair buffer: those parked, the persisting ones, the found ones, then, in exact
    /// mode with a margin, the surplus.
    pub(crate) swept_pairs: u64,
    /// Pairs of two resting objects at the front of the pair buffer, which steps need not look at: see `persistent`. The
    /// surplus among them comes first.
    pub(crate) parked: u32,
    pub(crate) surplus_parked: u32,
    /// All but the surplus: see [`result`](Self::result).
    pub(crate) result_pairs: u64,
    pub(crate) found: u64,
    pub(crate) lost: u64,
    /// With events: pairs of the last complete result in the other buffer, all but those parked.
    pub(crate) previous_result: u64,
    /// Steps in a row in which few objects have moved.
    pub(crate) calm: u32,
    /// How many objects are active, or more.
    pub(crate) active: u32,
    /// Boxes since the last complete step that outran their object's margin.
    pub(crate) outran: u32,
    /// Leaves with members, and the members of the fullest one, when all leaves were filled last.
    pub(crate) leaves_in_use: u32,
    pub(crate) fullest_leaf: u32,

    // Statistics of the last step that are nowhere else.
    moved: u32,
    last_outran: u32,
    /// The path, eight bits above it the reason, and eight bits above that whether the step was shared.
    chosen: u32,
    leaves: u32,
    rebalanced: u32,
    copies: u64,
    candidates: u64,
    tied: u64,

    /// Indices out of range that the last step knew of: see [`access`](crate::access).
    pub(crate) faults: u32,

    /// Objects that have changed their leaf since all leaves were filled from the boxes: their records are not in the order of slots.
    pub(crate) strays: u32,

    // Small numbers, and what is so or not.
    /// Whether an object may differ from what the last complete step has seen.
    pub(crate) dirty: u8,
    /// Whether the caller has ever put an object to rest.
    pub(crate) resting: u8,
    /// Whether the lists do not hold the living objects any more.
    pub(crate) stale_lists: u8,
    /// Whether records, places and reaches are those of the last step.
    pub(crate) filled: u8,
    /// Whether the last step ended with all its pairs.
    pub(crate) complete: u8,
    coarse: u8,
    /// Whether an object has come since the last complete step.
    pub(crate) has_inserted: u8,
    /// Whether a tight box has changed inside its fat box since the last complete step.
    pub(crate) moved_inside_margin: u8,
    /// The axis that a small world is swept along.
    pub(crate) list_axis: u8,
    /// The axis across which its stripes lie.
    pub(crate) stripe_axis: u8,
    /// Steps until the axes are chosen anew.
    pub(crate) scan_in: u8,
    /// Whether the last step swept the boxes as given though there are fat ones: its pairs cannot be carried over.
    pub(crate) without_surplus: u8,
    /// Whether the planes could not part the objects well when they were made.
    pub(crate) poor: u8,
    /// Whether the planes leave together what new ones would part.
    pub(crate) divisible: u8,
    /// Full steps until new planes are tried again after they were not good, and how many it will be the next time.
    pub(crate) planes_in: u8,
    pub(crate) planes_after: u8,
    /// The same for more levels of the planes after there were too many copies.
    pub(crate) deeper_in: u8,
    pub(crate) deeper_after: u8,
    /// Full steps in a row with far more such candidates.
    pub(crate) heavy: u8,
    /// Whether the next intake is to bring boxes to the records: most objects have stayed in their leaves in the last full step.
    pub(crate) settles: u8,
    /// Full steps in a row that have kept the leaves as they were.
    pub(crate) kept: u8,
    reserved: [u8; 2],
    /// Whether the pairs were loaded, and no step has seen yet that they are all: see `recount`.
    pub(crate) unproven: u8,
}

/// The version; and a bit of the feature that decides how the slab is laid out.
const MAGIC: u32 = 0x7452_0007 | if cfg!(feature = "large") { 1 << 15 } else { 0 };

// The bits of `State::flags`; a choice takes two.
const EVENTS: u32 = 1;
const LEAN: u32 = 1 << 1;
const FILTERS: u32 = 1 << 2;
const MARGIN: u32 = 1 << 3;
const FAT: u32 = 1 << 4;
const FIXED_MARGINS: u32 = 1 << 5;
const MOVERS_ONLY: u32 = 6;
const FINE_LEAVES: u32 = 8;
const SHARING: u32 = 10;

const fn flags(config: &Config) -> u32 {
    let Config { mode, margin, events, filters, lean, movers_only, fine_leaves, sharing, .. } = *config;
    flag(EVENTS, events)
        | flag(LEAN, lean)
        | flag(FILTERS, filters)
        | flag(MARGIN, margin.is_some())
        | flag(FAT, matches!(mode, Mode::Fat))
        | flag(FIXED_MARGINS, config.fixed_margins)
        | (movers_only.bits() << MOVERS_ONLY)
        | (fine_leaves.bits() << FINE_LEAVES)
        | (sharing.bits() << SHARING)
}

const fn flag(bit: u32, is_set: bool) -> u32 {
    if is_set { bit } else { 0 }
}

impl Default for State {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl State {
    /// The most blocks that a sweep may be cut into: as many as a full step has, since each may leave a chunk of staged pairs
    /// unfinished.
    pub(crate) fn most_blocks(&self) -> usize {
        (1usize << self.depth).div_ceil(LEAVES_PER_BLOCK).max(1)
    }

    /// The leaves that there are now, or those of the last step where there is no tree.
    pub(crate) const fn leaves(&self) -> u32 {
        if self.filled != 0 { 1 << (self.depth + self.sub_levels()) } else { self.leaves }
    }

    /// How many levels below `depth` leaves stand: those of the last full step are divided into that, or being divided.
    #[inline(always)]
    pub(crate) const fn sub_levels(&self) -> u32 {
        if self.subdivided == 0 { 0 } else { SUB_LEVELS }
    }

    /// Whether a leaf of the last full step is divided.
    pub(crate) const fn is_subdivided(&self, leaf: usize) -> bool {
        leaf + 1 < self.subdivided as usize
    }

    pub(crate) fn new(config: &Config, index_bytes: usize) -> Self {
        let margin = config.margin.unwrap_or(Margin::length(0.0));
        Self {
            magic: MAGIC,
            index_bytes: index_bytes as u32,
            objects: config.capacity.objects,
            leaf_refs: config.capacity.leaf_refs,
            pairs_capacity: config.capacity.pairs,
            margin: [margin.per_extent, margin.min, margin.max],
            flags: flags(config),
            workers: config.workers,
            complete: 1,
            ..Self::zeroed()
        }
    }

    /// The configuration of a slab that holds a world of this index width.
    pub(crate) fn config(&self, index_bytes: usize) -> Option<Config> {
        if self.magic != MAGIC || self.index_bytes != index_bytes as u32 {
            return None;
        }
        Some(Config {
            capacity: Capacity {
                objects: self.objects,
                leaf_refs: self.leaf_refs,
                pairs: self.pairs_capacity,
            },
            mode: self.mode(),
            margin: self.margin(),
            events: self.flags & EVENTS != 0,
            lean: self.flags & LEAN != 0,
            filters: self.flags & FILTERS != 0,
            workers: self.workers,
            movers_only: Choice::from_bits(self.flags >> MOVERS_ONLY)?,
            fine_leaves: Choice::from_bits(self.flags >> FINE_LEAVES)?,
            sharing: Choice::from_bits(self.flags >> SHARING)?,
            fixed_margins: self.has_fixed_margins(),
        })
    }

    // Of no choice, which no world has, the automatic one.

    pub(crate) fn movers_only(&self) -> Choice {
        Choice::from_bits(self.flags >> MOVERS_ONLY).unwrap_or_default()
    }

    pub(crate) fn fine_leaves(&self) -> Choice {
        Choice::from_bits(self.flags >> FINE_LEAVES).unwrap_or_default()
    }

    pub(crate) fn sharing(&self) -> Choice {
        Choice::from_bits(self.flags >> SHARING).unwrap_or_default()
    }

    pub(crate) fn has_fixed_margins(&self) -> bool {
        self.flags & FIXED_MARGINS != 0
    }

    /// Whether this is the state of a world of the same configuration, but for the workers. Snapshots have a version of their own.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let key = |state: &Self| {
            let Self { index_bytes, objects, leaf_refs, pairs_capacity, flags, .. } = *state;
            ([index_bytes, objects, leaf_refs, pairs_capacity, flags], state.margin.map(f32::to_bits))
        };
        key(self) == key(other)
    }

    /// The state as a snapshot has it: the number of workers decides about scratch memory alone, and so does what the library
    /// was built for about the slab alone. A snapshot has no lists.
    pub(crate) fn portable(&self) -> Self {
        Self { workers: 1, magic: 0, faults: 0, listed: 0, stale_lists: 1, unproven: 0, ..*self }
    }

    /// Whether it is such a state.
    pub(crate) const fn is_portable(&self) -> bool {
        let Self { workers, magic, faults, listed, stale_lists, unproven, .. } = *self;
        workers == 1 && magic == 0 && faults == 0 && listed == 0 && stale_lists == 1 && unproven == 0
    }

    /// The configuration of the world that a [portable](Self::portable) state is of.
    pub(crate) fn portable_config(&self, index_bytes: usize) -> Option<Config> {
        Self { magic: MAGIC, ..*self }.config(index_bytes)
    }

    /// What differs from another world's configuration and cannot be changed while there are objects.
    pub(crate) fn difference(&self, to: &Self) -> Option<Field> {
        let differs = |flag: u32| (self.flags ^ to.flags) & flag != 0;
        let fields = [
            (differs(FAT), Field::Mode),
            (differs(MARGIN), Field::Margin),
            (differs(EVENTS), Field::Events),
            (differs(FILTERS), Field::Filters),
            (self.index_bytes != to.index_bytes, Field::Index),
        ];
        fields.into_iter().find(|(differs, _)| *differs).map(|(_, field)| field)
    }

    /// The state of a world into which another one has moved: with the objects and the last result of that one, without tree,
    /// lists and parked pairs. The pairs of the step before are for the caller to count.
    pub(crate) fn with_objects_of(&self, other: &Self) -> Self {
        let Self { live, slots, free, swept_pairs, result_pairs, found, lost, outran, .. } = *other;
        let Self { leaves_in_use, fullest_leaf, moved, last_outran, chosen, leaves, rebalanced, .. } = *other;
        let Self { copies, candidates, tied, dirty, resting, complete, coarse, has_inserted, .. } = *other;
        let Self { moved_inside_margin, without_surplus, unproven, .. } = *other;
        let empty = Self::zeroed();
        Self {
            live,
            slots,
            free,
            swept_pairs,
            result_pairs,
            found,
            lost,
            outran,
            leaves_in_use,
            fullest_leaf,
            moved,
            last_outran,
            chosen,
            leaves,
            rebalanced,
            copies,
            candidates,
            tied,
            dirty,
            resting,
            complete,
            coarse,
            has_inserted,
            moved_inside_margin,
            without_surplus,
            unproven,
            magic: self.magic,
            index_bytes: self.index_bytes,
            objects: self.objects,
            leaf_refs: self.leaf_refs,
            pairs_capacity: self.pairs_capacity,
            margin: self.margin,
            flags: self.flags,
            workers: self.workers,
            faults: self.faults,
            stale_lists: 1,
            // More than can be, so that the next step looks which pairs can be parked.
            active: u32::MAX,
            ..empty
        }
    }

    /// Whether the statistics of the last step are such as a step leaves, and nothing stands where nothing should.
    pub(crate) fn has_known_statistics(&self) -> bool {
        let (path, reason) = (self.chosen as usize & 0xff, (self.chosen >> 8) as usize & 0xff);
        path < Path::ALL.len() && reason < Reason::ALL.len() && self.chosen >> 16 <= 1 && self.coarse <= 1
    }

    /// Takes over what a snapshot does not have.
    pub(crate) fn adopt(&mut self, other: &Self) {
        (self.workers, self.magic, self.faults) = (other.workers, other.magic, other.faults);
    }

    pub(crate) fn mode(&self) -> Mode {
        if self.flags & FAT == 0 { Mode::Exact } else { Mode::Fat }
    }

    /// The margin of new objects.
    pub(crate) fn margin(&self) -> Option<Margin> {
        let [per_extent, min, max] = self.margin;
        (self.flags & MARGIN != 0).then_some(Margin { per_extent, min, max })
    }

    /// Where the result stands in the pair buffer.
    pub(crate) fn result(&self) -> core::ops::Range<usize> {
        let start = self.surplus_parked as usize;
        start..start + self.result_pairs as usize
    }

    pub(crate) fn extent(&self) -> Extent {
        Extent { low: self.low, high: self.high }
    }

    pub(crate) fn set_extent(&mut self, extent: &Extent) {
        (self.low, self.high) = (extent.low, extent.high);
    }

    pub(crate) fn stats(&self) -> Stats {
        Stats {
            objects: self.live,
            moved: self.moved,
            path: Path::ALL.get((self.chosen & 0xff) as usize).copied().unwrap_or_default(),
            reason: Reason::ALL.get((self.chosen >> 8 & 0xff) as usize).copied().unwrap_or_default(),
            fine_leaves: self.subdivided != 0 && self.leaves > 1,
            shared: self.chosen >> 16 != 0,
            outran: self.last_outran,
            leaves: self.leaves,
            leaves_in_use: if self.leaves > 1 { self.leaves_in_use } else { u32::from(self.live > 0) },
            fullest_leaf: if self.leaves > 1 { self.fullest_leaf } else { self.live },
            copies: self.copies,
            candidates: self.candidates,
            tied: self.tied,
            pairs: self.result_pairs,
            found: self.found,
            lost: self.lost,
            surplus: self.swept_pairs - self.result_pairs,
            large: if self.leaves > 1 { self.large } else { 0 },
            rebalanced: self.rebalanced,
            coarse_resolution: self.coarse != 0,
        }
    }

    pub(crate) fn record(&mut self, moved: u32, route: Route, shared: bool, progress: &Progress) {
        self.moved = moved;
        self.last_outran = self.outran;
        self.chosen = route.path as u32 | (route.reason as u32) << 8 | u32::from(shared) << 16;
        self.leaves = progress.leaves;
        self.rebalanced = progress.rebalanced;
        if let Some(coarse) = progress.coarse {
            self.coarse = u8::from(coarse);
        }
        self.copies = progress.work.copies;
        self.candidates = progress.work.candidates;
        self.tied = progress.work.tied;
    }
}
