//! The numbers of each layer, one struct an owner.

use crate::geometry::key::KeyBox;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::scratch::Work;
use crate::memory::stats::{Path, Reason, Route};
use bytemuck::{Contiguous as _, Pod, Zeroable};

/// Which objects live, and what the caller has changed: of `objects` and `world`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct ObjectState {
    /// Living objects that are enabled, and disabled ones.
    pub(crate) live: u32,
    pub(crate) disabled: u32,
    /// Slots that have ever been in use.
    pub(crate) slots: u32,
    /// The slot that was freed last, plus one; zero if none is free. Each free slot holds the next one.
    pub(crate) free: u32,
    /// Boxes since the last complete step that were farther from the last one than the margin.
    pub(crate) outran: u32,
    /// Whether objects may have changed since the last complete step.
    pub(crate) dirty: u8,
    /// Whether the caller has ever put an object to rest.
    pub(crate) resting: u8,
    /// Whether an object has come since the last complete step: 1 if since the last step, 2 if before it alone.
    pub(crate) has_inserted: u8,
    pub(super) unused: u8,
}

/// The sorted list: of `step::lists` and `sweep::small`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct ListState {
    /// Slots in the sorted list.
    pub(crate) listed: u16,
    /// The grid on a second axis: the upper bits of its first key, and how many lower bits a step has.
    pub(crate) least: i16,
    /// Whether the list may not hold all living objects.
    pub(crate) stale: u8,
    /// The axis that a world without a tree is swept along.
    pub(crate) axis: u8,
    /// Steps until the axis is chosen anew.
    pub(crate) scan_in: u8,
    pub(crate) shift: u8,
}

/// The slot in a word of the list, in bits for [`SMALL`](crate::memory::limits::SMALL). Below it are two sides.
pub(crate) const fn slot(word: i32) -> usize {
    (word as u32 >> 24) as usize
}

/// Planes and leaves, and how good they are: of `tree`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct TreeState {
    /// Pairs tested in vain by the first full step after the whole tree was made: what new planes can reach.
    pub(crate) baseline_work: u64,
    /// The same for its ghosts.
    pub(crate) baseline_copies: u64,
    /// Leaves of full steps, or zero where there are no planes.
    pub(crate) count: u32,
    /// The depth of new planes for as many objects as there are, or were lately.
    pub(crate) depth: u32,
    /// How many times leaves are twice as large as planned, since ghosts would take too much room.
    pub(crate) coarser: u16,
    /// The most levels that a leaf is below the root, when all were last counted.
    pub(crate) height: u16,
    /// Zero while no leaf is divided; else one more than the number of divided leaves, the first ones.
    pub(crate) subdivided: u32,
    /// Movers since the boxes of the first leaf were made tight, as one leaf follows another.
    pub(crate) moved_since_refit: u32,
    /// The next leaf whose box is made tight.
    pub(crate) refit: u32,
    /// Where the straddlers end and the nodes over the large objects start, and how many objects there are.
    pub(crate) large_start: u32,
    pub(crate) large: u32,
    /// How many have changed since they were brought into order.
    pub(crate) large_changed: u32,
    /// Slots in use at the last complete step. An object in another one has no pairs yet.
    pub(crate) known: u32,
    /// The bounds of the finite minimum corners, without large objects where these are known.
    pub(crate) extent: KeyBox,
    /// When all leaves were last filled: leaves with members, and members of the fullest one.
    pub(crate) leaves_in_use: u32,
    pub(crate) fullest_leaf: u32,
    /// Whether records, homes and places are of the last step; 2 if it left none and queries needed them.
    pub(crate) filled: u8,
    /// Whether the whole tree is to be made anew: see [`Due`](crate::tree::balance::Due).
    pub(crate) due: u8,
    /// Whether a leaf is too full that planes may divide.
    pub(crate) uneven: u8,
    /// Full steps until leaves are divided again that could not be, and how many it will be the next time.
    pub(crate) wait: u8,
    pub(crate) waits: u8,
    /// Heavy sweeps in a row: see [`HEAVY`](crate::tree::limits::HEAVY).
    pub(crate) heavy: u8,
    /// The depth of the tree of large objects.
    pub(crate) large_depth: u8,
    /// Full steps that are weighed anew, after the whole tree was made or other boxes are swept.
    pub(crate) unweighed: u8,
}

impl TreeState {
    /// The next step makes new planes and fills all leaves.
    pub(crate) const fn forget(&mut self) {
        (self.count, self.filled, self.subdivided) = (0, 0, 0);
    }

    /// Where the list of large objects starts.
    pub(crate) const fn large_list(&self) -> usize {
        self.large_start as usize + large_nodes(self.large_depth)
    }

    /// The leaves that there are, filled or not.
    pub(crate) const fn leaves(&self) -> u32 {
        self.count << self.sub_levels()
    }

    /// How many levels the leaves are below `depth`: none while no leaf is divided.
    pub(crate) const fn sub_levels(&self) -> u32 {
        if self.subdivided == 0 { 0 } else { SUB_LEVELS }
    }

    /// Whether a leaf of the last full step is divided.
    pub(crate) const fn is_subdivided(&self, leaf: usize) -> bool {
        leaf + 1 < self.subdivided as usize
    }
}

/// How many straddlers are as long as the boxes of the nodes of a depth over the large objects. There are
/// none over a single group.
pub(crate) const fn large_nodes(depth: u8) -> usize {
    if depth == 0 { 0 } else { 3usize.wrapping_shl(depth as u32 - 1) }
}

/// Where in the buffers the kinds of pairs are: of `pairs`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct PairState {
    /// Overlaps of swept boxes in the pair buffer: parked, persisting, found, and, with fat boxes, surplus.
    pub(crate) swept: u64,
    /// All but the surplus: the result, at the front.
    pub(crate) reported: u64,
    pub(crate) found: u64,
    pub(crate) lost: u64,
    /// With events: pairs of the last complete result in the other buffer; in a step with few movers without
    /// the parked ones.
    pub(crate) previous: u64,
    /// Parked pairs of the result at the front of the pair buffer, and parked surplus at its end: see
    /// `persistent`.
    pub(crate) parked: u32,
    pub(crate) surplus_parked: u32,
    /// In a step that keeps pairs: where these end at the front of the pair buffer, and where pairs of the
    /// last result do among them. Surplus is between.
    pub(crate) kept: u32,
    pub(crate) kept_result: u32,
    /// At least as many as there are active objects.
    pub(crate) active: u32,
    /// Whether the last step had room for all its pairs.
    pub(crate) complete: u8,
    /// Whether the pairs cannot be kept, since they come from a snapshot: the next step finds all anew.
    pub(crate) unkept: u8,
    /// With events: whether nobody keeps the boxes of the last complete step: its pairs alone tell events.
    pub(crate) before_unknown: u8,
    /// With events: whether the two pair buffers have changed places.
    pub(crate) swapped: u8,
}

impl PairState {
    /// All pairs but the surplus that is parked.
    pub(crate) const fn in_front(&self) -> usize {
        self.swept as usize - self.surplus_parked as usize
    }

    /// How many pairs of the step before stand in the other buffer: the lost ones; if the last step had
    /// no room for its pairs, all.
    pub(crate) const fn previous(&self) -> u64 {
        if self.complete != 0 { self.lost } else { self.previous }
    }

    /// See [`State::portable`](super::State::portable). None of the pairs are parked: no more can be active,
    /// so the next step looks which it can park.
    pub(super) fn portable(&self) -> Self {
        let Self { reported, found, lost, complete, before_unknown, .. } = *self;
        let previous = self.previous();
        let counts = Self { swept: reported, reported, found, lost, previous, ..Self::default() };
        Self { active: u32::MAX, complete, before_unknown, unkept: 1, ..counts }
    }
}

/// What the last step did, and what led to it: of `step`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct StepState {
    pub(super) work: Work,
    pub(crate) moved: u32,
    pub(super) outran: u32,
    pub(super) leaves: u32,
    pub(super) rebalanced: u32,
    /// Steps in a row in which few objects have moved.
    pub(crate) calm: u8,
    /// Steps until fat boxes are used again; zero where they are.
    pub(crate) margins_in: u8,
    /// How many calm steps there were before the last full step that came after any.
    pub(crate) was_calm: u8,
    /// Zero if the next step cannot keep the leaves as they are; else one more than the full steps that have
    /// kept them since all were filled.
    pub(crate) kept: u8,
    pub(super) path: u8,
    pub(super) reason: u8,
    pub(super) shared: u8,
    pub(super) unused: u8,
    /// Steps for which each new box gets a new fat box; the first step does not tell how objects move.
    pub(crate) renews: u16,
    /// What the steps since that was so last have cost beyond quiet ones.
    pub(crate) spent: u16,
    /// How many these are; while some try fat boxes, the first slots of which some do.
    pub(crate) age: u32,
}

impl StepState {
    /// What a step has chosen; `None` if no step can have left this.
    pub(crate) fn route(&self) -> Option<Route> {
        let path = Path::from_integer(self.path)?;
        let reason = Reason::from_integer(self.reason)?;
        (self.shared <= 1).then_some(Route { path, reason })
    }

    /// Notes what led to a step.
    pub(crate) fn record(&mut self, moved: u32, outran: u32, route: Route, shared: bool) {
        (self.moved, self.outran, self.shared) = (moved, outran, u8::from(shared));
        (self.path, self.reason) = (route.path as u8, route.reason as u8);
    }

    /// Notes what a step did.
    pub(crate) fn did(&mut self, work: Work, leaves: u32, rebalanced: u32) {
        (self.work, self.leaves, self.rebalanced) = (work, leaves, rebalanced);
    }
}
