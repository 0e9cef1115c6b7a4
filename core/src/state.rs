//! The few numbers of a world that are not arrays, and the statistics of a step.

use crate::config::{Capacity, Config, Margin, Mode};
use crate::sweep::scratch::Work;
use crate::tree::cells::Extent;
use bytemuck::{Pod, Zeroable};

/// How a step found its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Path {
    /// Nothing has moved: the pairs stay.
    #[default]
    Unchanged,
    /// A small world: swept straight from a sorted list.
    Lists,
    /// Few have moved: each mover was tested against the leaves that it reaches, the other pairs stay.
    Movers,
    /// Many have moved: all leaves were filled and swept.
    Full,
    /// As `Full`, after new planes for the whole tree.
    Rebuilt,
}

impl Path {
    const ALL: [Self; 5] = [Self::Unchanged, Self::Lists, Self::Movers, Self::Full, Self::Rebuilt];
}

/// What a step did. All are counts, so equal calls give equal statistics on any machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Stats {
    /// Living objects.
    pub objects: u32,
    /// Objects that are new or gone, or have left their fat box (without a margin: whose box has changed) since
    /// the last complete step.
    pub moved: u32,
    /// How the pairs were found.
    pub path: Path,
    /// Leaves of the tree; 1 where the world is swept from a list.
    pub leaves: u32,
    /// Boxes swept in leaves where they are not at home.
    pub copies: u64,
    /// Pairs of boxes that were tested on all axes.
    pub candidates: u64,
    /// Candidates that share a step of their leaf's 16-bit grid, so that the `f32` boxes had to decide. Zero in small
    /// worlds, which compare nothing else.
    pub tied: u64,
    /// Overlapping pairs.
    pub pairs: u64,
    /// Pairs that the last step did not have.
    pub found: u64,
    /// Pairs that only the last step had.
    pub lost: u64,
    /// Exact mode with a margin: overlaps of fat boxes that the exact test dropped.
    pub surplus: u64,
    /// Large objects, which live in a list of their own.
    pub large: u32,
    /// Objects whose leaf got new planes.
    pub rebalanced: u32,
    /// Whether `f32` is too coarse for some box where it stands: a side of it is below four steps of its
    /// coordinate. The pairs are those of the boxes as given, but the boxes may have lost their shape before; shift
    /// the origin. Looked for in steps that fill all leaves;
    /// in worlds swept box by box, in every eighth step and where objects are new.
    pub coarse_resolution: bool,
}

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
    mode: u32,
    has_margin: u32,
    margin: [f32; 3],
    /// Whether there are events, whether the world is lean, and whether there are filters.
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
    /// Whether the lists do not hold the living objects any more.
    pub(crate) stale_lists: u32,
    /// The axis that a small world is swept along.
    pub(crate) list_axis: u32,
    /// The axis across which its strips lie.
    pub(crate) strip_axis: u32,
    /// Steps until the axes are chosen anew.
    pub(crate) survey_in: u32,

    /// Living objects when the planes were made, or zero where there are none.
    pub(crate) planted: u32,
    /// The depth that the planes are used to; less than planned where copies would take too much room.
    pub(crate) depth: u32,
    /// Whether the leaves are smaller than those of the last full step, and the depth of those.
    pub(crate) refined: u32,
    pub(crate) swept_depth: u32,
    /// Whether records, places and reaches are those of the last step.
    pub(crate) filled: u32,
    /// First large object among the fronts, and how many there are.
    pub(crate) large_start: u32,
    pub(crate) large: u32,
    /// Bounds of the minima.
    pub(crate) low: [i32; 3],
    pub(crate) high: [i32; 3],
    /// Whether an object may differ from what the last complete step has seen.
    pub(crate) touched: u32,
    /// Whether the caller has ever put an object to rest.
    pub(crate) resting: u32,
    /// Whether an object has come since the last complete step.
    pub(crate) entered: u32,
    /// The sum of squares of the leaves' counts when their planes were new: what new planes can achieve.
    pub(crate) settled: u64,

    /// Overlaps of swept boxes in the pair buffer: those set aside, the persisting ones, the found ones, then, in exact
    /// mode with a margin, the surplus.
    pub(crate) swept_pairs: u64,
    /// Pairs of two resting objects at the front of the pair buffer, which steps need not look at: see `resting`.
    pub(crate) aside: u64,
    /// The persisting and the found ones: the result.
    pub(crate) result_pairs: u64,
    pub(crate) found: u64,
    pub(crate) lost: u64,
    /// With events: pairs of the last complete result in the other buffer, all but those set aside.
    pub(crate) previous_result: u64,
    /// Whether the last step ended with all its pairs.
    pub(crate) complete: u32,
    /// Steps in a row in which few objects have moved.
    pub(crate) calm: u32,
    /// Whether a tight box has changed inside its fat box since the last complete step.
    pub(crate) crept: u32,

    // Statistics of the last step that are nowhere else.
    moved: u32,
    path: u32,
    leaves: u32,
    rebalanced: u32,
    coarse: u32,
    copies: u64,
    candidates: u64,
    tied: u64,
}

const MAGIC: u32 = 0x7452_0002;

impl Default for State {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl State {
    pub(crate) fn new(config: &Config, index_bytes: usize) -> Self {
        let margin = config.margin.unwrap_or(Margin::length(0.0));
        Self {
            magic: MAGIC,
            index_bytes: index_bytes as u32,
            objects: config.capacity.objects,
            leaf_refs: config.capacity.leaf_refs,
            pairs_capacity: config.capacity.pairs,
            mode: (config.mode == Mode::Fat) as u32,
            has_margin: config.margin.is_some() as u32,
            margin: [margin.per_extent, margin.min, margin.max],
            flags: config.events as u32 | (config.lean as u32) << 1 | (config.filters as u32) << 2,
            workers: config.workers,
            complete: 1,
            ..Self::zeroed()
        }
    }

    /// The configuration of a slab that holds a world of this index width.
    pub(crate) fn config(&self, index_bytes: usize) -> Option<Config> {
        let known = self.magic == MAGIC && self.index_bytes == index_bytes as u32;
        known.then_some(Config {
            capacity: Capacity {
                objects: self.objects,
                leaf_refs: self.leaf_refs,
                pairs: self.pairs_capacity,
            },
            mode: self.mode(),
            margin: self.margin(),
            events: self.flags & 1 != 0,
            lean: self.flags & 2 != 0,
            filters: self.flags & 4 != 0,
            workers: self.workers,
        })
    }

    /// Whether this is the state of a world of the same configuration, but for the workers.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let key = |state: &Self| {
            let Self {
                magic, index_bytes, objects, leaf_refs, pairs_capacity, mode, has_margin, flags, ..
            } = *state;
            (
                [magic, index_bytes, objects, leaf_refs, pairs_capacity, mode, has_margin, flags],
                state.margin.map(f32::to_bits),
            )
        };
        key(self) == key(other)
    }

    /// The state as a snapshot has it: the number of workers decides about scratch memory alone.
    pub(crate) fn without_workers(&self) -> Self {
        Self { workers: 1, ..*self }
    }

    /// Takes over the number of workers.
    pub(crate) fn adopt_workers(&mut self, other: &Self) {
        self.workers = other.workers;
    }

    pub(crate) fn mode(&self) -> Mode {
        if self.mode == 0 { Mode::Exact } else { Mode::Fat }
    }

    /// The margin of new objects.
    pub(crate) fn margin(&self) -> Option<Margin> {
        let [per_extent, min, max] = self.margin;
        (self.has_margin != 0).then_some(Margin { per_extent, min, max })
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
            path: Path::ALL.get(self.path as usize).copied().unwrap_or_default(),
            leaves: self.leaves,
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

    pub(crate) fn record(&mut self, moved: u32, path: Path, progress: &Progress) {
        self.moved = moved;
        self.path = path as u32;
        self.leaves = progress.leaves;
        self.rebalanced = progress.rebalanced;
        if let Some(coarse) = progress.coarse {
            self.coarse = u32::from(coarse);
        }
        self.copies = progress.work.copies;
        self.candidates = progress.work.candidates;
        self.tied = progress.work.tied;
    }
}

/// What a step has done so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    /// Pairs of swept boxes, whether they fit or not.
    pub(crate) pairs: u64,
    pub(crate) work: Work,
    pub(crate) leaves: u32,
    pub(crate) rebalanced: u32,
    pub(crate) coarse: Option<bool>,
}
