//! Carves the slab of a world into slices, each for the layer that owns it.

use super::layout::{ALIGN, Sizes, beyond, layout, section};
use super::leaf::{Cell, Leaf, Straddler};
use super::limits::CHUNK;
use super::scratch;
use super::slot_set::SlotSet;
use super::state::State;
use crate::access::{Access, bits, faults};
use crate::config::{Config, Mode};
use crate::error::Error;
use crate::filter::Filter;
use crate::geometry::key::KeyBox;
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use bytemuck::Pod;

/// The slices of a world, by slot unless said otherwise.
pub(crate) struct Parts<'m, I> {
    pub(crate) sizes: Sizes,
    pub(crate) state: &'m mut State,
    pub(crate) boxes: BoxParts<'m>,
    pub(crate) filters: FilterParts<'m>,
    pub(crate) values: ValueParts<'m>,
    pub(crate) former: FormerParts<'m>,
    /// How many objects have had the slot.
    pub(crate) generations: &'m mut [u32],
    /// The swept box has changed since the last complete step (the paper's dynamic objects).
    pub(crate) moved: SlotSet<'m>,
    /// One bit a slot: the caller has put the object to rest.
    pub(crate) resting: &'m mut [u32],
    /// With events, and in an exact world with margins and a tree: the swept box, the reported box or the filter has
    /// changed since the last complete step.
    pub(crate) changed: SlotSet<'m>,
    /// With events: `before` may be out of date, since the slot changed before the last complete step.
    pub(crate) outdated: SlotSet<'m>,
    /// With a tree, one bit a slot: the object is active, so its pairs are not parked.
    pub(crate) active: &'m mut [u32],
    /// One bit a slot: it is in the sorted lists.
    pub(crate) listed: &'m mut [u32],
    /// The tri-linked lists: slots by ascending minimum on x, y and z.
    pub(crate) order: [&'m mut [I]; 3],
    /// The leaf that holds the object's record, or [`Index::LARGE`], or [`Index::NONE`].
    pub(crate) home: &'m mut [I],
    /// The position of the record in its leaf, or in the list of large objects.
    pub(crate) place: &'m mut [I],
    pub(crate) tree: TreeParts<'m>,
    pub(crate) output: OutputParts<'m, I>,
}

/// The boxes of all slots.
pub(crate) struct BoxParts<'m> {
    /// The box as given last. A free slot has an empty one, which holds the next free slot.
    pub(crate) now: &'m mut [KeyBox],
    /// With margins: the fat box (erratum E5).
    pub(crate) fat: &'m mut [KeyBox],
    /// With margins: the length that the box is grown by (erratum E2).
    pub(crate) margins: &'m mut [f32],
    /// With events: the box that the last complete step reported, if the object has [changed](Parts::changed) since;
    /// empty if the object is new. If it has not changed, this is its reported box, unless it is
    /// [outdated](Parts::outdated).
    pub(crate) before: &'m mut [KeyBox],
    /// Whether the boxes as given are swept though there are fat ones, for one step or while margins are left unused.
    /// Fat boxes then mean nothing.
    pub(crate) tight: bool,
}

/// With events: who had the slots that new objects have got since the complete step before, so that lost pairs can be
/// named.
pub(crate) struct FormerParts<'m> {
    /// Of these slots: the generation of the former object.
    pub(crate) generations: &'m mut [u32],
    /// These slots.
    pub(crate) reused: SlotSet<'m>,
}

/// With filters: whom the objects meet.
pub(crate) struct FilterParts<'m> {
    pub(crate) of: &'m mut [Filter],
    /// One bit for each class that a class meets.
    pub(crate) classes: &'m mut [u32],
    /// The filter may answer differently since the last complete step.
    pub(crate) changed: SlotSet<'m>,
}

/// With values: the caller's number for each object.
pub(crate) struct ValueParts<'m> {
    /// A free slot keeps the value of the object that had it.
    pub(crate) of: &'m mut [u64],
    /// With events: the values of the objects in [`FormerParts::generations`].
    pub(crate) former: &'m mut [u64],
}

impl FormerParts<'_> {
    /// A slot goes to a new object. `is_first`: no other object has come since the last complete step. Returns
    /// whether the former object of the slot is kept from now on.
    pub(crate) fn note(&mut self, slot: usize, generation: u32, is_first: bool) -> bool {
        if is_first {
            self.reused.clear();
        }
        let is_new = generation != 0 && !bits::test(self.reused.words, slot);
        if is_new {
            self.reused.set(slot);
            self.generations.put(slot, generation);
        }
        is_new
    }
}

impl ValueParts<'_> {
    /// A slot goes to a new object. `is_kept`: events may still name the former one, so its value is kept.
    pub(crate) fn insert(&mut self, slot: usize, is_kept: bool) {
        if let Some(value) = self.of.get_mut(slot) {
            let former = core::mem::take(value);
            if is_kept && let Some(to) = self.former.get_mut(slot) {
                *to = former;
            }
        }
    }
}

impl BoxParts<'_> {
    /// The boxes that lists, planes and sweeps use.
    pub(crate) fn swept(&self) -> &[KeyBox] {
        if self.fat.is_empty() || self.tight { self.now } else { self.fat }
    }

    /// The boxes whose overlaps a result has.
    pub(crate) fn reported(&self, mode: Mode) -> &[KeyBox] {
        if mode == Mode::Fat { self.swept() } else { self.now }
    }
}

/// The KD-tree.
pub(crate) struct TreeParts<'m> {
    /// By node.
    pub(crate) planes: &'m mut [i32],
    /// By leaf.
    pub(crate) cells: &'m mut [Cell],
    /// By leaf of a full step. Its sub-leaves share it.
    pub(crate) frames: &'m mut [Frame],
    /// By leaf.
    pub(crate) leaves: &'m mut [Leaf],
    /// By leaf, while leaves are divided: a box around its members, as a record in their frame. Else it means
    /// nothing.
    pub(crate) bounds: &'m mut [Record],
    /// By node down to the leaves of a full step: a box around its members. There is no node zero.
    pub(crate) nodes: &'m mut [KeyBox],
    /// The records of all leaves, one leaf after another, each with some room.
    pub(crate) records: &'m mut [Record],
    /// The straddlers of all leaves, one leaf after another, and behind them the list of large objects.
    pub(crate) straddlers: &'m mut [Straddler],
    /// In a fill: a row of counts for each block of slots, see
    /// [`histogram_row`](crate::memory::limits::histogram_row). Between two fills: where the movers of each leaf end.
    pub(crate) histogram: &'m mut [u32],
}

/// The pairs, and all that a sweep writes to.
pub(crate) struct OutputParts<'m, I> {
    /// The overlaps of swept boxes: see `PairState::swept`.
    pub(crate) pairs: &'m mut [Pair<I>],
    /// With events: the pairs of the last complete step, in a step with few movers without the parked ones. After a
    /// step the lost pairs come first. This buffer and `pairs` change places, so nothing is copied: see
    /// [`PairState::swapped`].
    pub(crate) previous: &'m mut [Pair<I>],
    pub(crate) segments: Segments<'m>,
    /// With workers: chunks of pairs in the order in which they were found.
    pub(crate) staged: &'m mut [Pair<I>],
    /// The block, the position and the length of each chunk.
    pub(crate) chunks: &'m mut [[u32; 3]],
    /// The workers' scratch, in equal areas.
    pub(crate) scratch: &'m mut [Record],
}

/// With events and a tree: the last complete result divided by blocks of leaves. First come the persisting pairs of
/// each block, in order, then the found pairs of each block, the last block first.
pub(crate) struct Segments<'m> {
    /// How many blocks there are; zero if the result is in another order.
    count: &'m mut [u32],
    /// Where each segment ends.
    pub(crate) ends: &'m mut [u32],
    /// For each block: how many persisting and found pairs the step has.
    pub(crate) counts: &'m mut [[u32; 2]],
    /// For each block: how many pairs of its two segments are lost.
    pub(crate) lost: &'m mut [[u32; 2]],
}

impl Segments<'_> {
    /// The blocks of the last complete result; zero if it is not divided.
    pub(crate) fn blocks(&self) -> usize {
        self.count.first().map_or(0, |count| *count as usize)
    }

    pub(crate) fn set_blocks(&mut self, blocks: usize) {
        if let Some(count) = self.count.first_mut() {
            *count = blocks as u32;
        }
    }

    /// The pairs get another order.
    pub(crate) fn forget(&mut self) {
        if cfg!(feature = "large") {
            self.set_blocks(0);
        }
    }
}

/// Cuts sections off the slab.
struct Carver<'m>(&'m mut [u8]);

impl<'m> Carver<'m> {
    fn take<T: Pod>(&mut self, count: usize) -> Option<&'m mut [T]> {
        let (section, rest) = core::mem::take(&mut self.0).split_at_mut_checked(section::<T>(count)?)?;
        self.0 = rest;
        bytemuck::try_cast_slice_mut(section.get_mut(..count * size_of::<T>())?).ok()
    }
}

impl<'m, I: Index> Parts<'m, I> {
    /// Carves a slab that is long enough and aligned, in the order of [`Sizes::bytes`].
    fn carve(slab: &'m mut [u8], sizes: Sizes) -> Option<Self> {
        let mut slab = Carver(slab);
        let state: &mut State = slab.take(1)?.first_mut()?;
        let now = slab.take(sizes.objects)?;
        let fat = slab.take(sizes.fat)?;
        let margins = slab.take(sizes.fat)?;
        let before = slab.take(sizes.before)?;
        let former = FormerParts {
            generations: slab.take(sizes.before)?,
            reused: SlotSet::carve(slab.take(SlotSet::len(sizes.before))?, sizes.before)?,
        };
        let filters = FilterParts {
            of: slab.take(sizes.filters)?,
            classes: slab.take(sizes.classes)?,
            changed: SlotSet::carve(slab.take(SlotSet::len(sizes.filters))?, sizes.filters)?,
        };
        let values = slab.take::<u64>(sizes.values + sizes.former_values)?;
        let (of, former_values) = values.split_at_mut_checked(sizes.values)?;
        let values = ValueParts { of, former: former_values };
        let generations = slab.take(sizes.objects)?;
        let words = bits::words(sizes.objects);
        let (listed, rest) =
            slab.take(2 * words + SlotSet::len(sizes.objects))?.split_at_mut_checked(words)?;
        let (resting, rest) = rest.split_at_mut_checked(words)?;
        let moved = SlotSet::carve(rest, sizes.objects)?;
        let len = SlotSet::len(sizes.changed);
        let (changed, outdated) = slab.take(len + SlotSet::len(sizes.before))?.split_at_mut_checked(len)?;
        let changed = SlotSet::carve(changed, sizes.changed)?;
        let outdated = SlotSet::carve(outdated, sizes.before)?;
        let active = slab.take(bits::words(sizes.tree))?;
        let (x, rest) = slab.take(3 * sizes.objects)?.split_at_mut_checked(sizes.objects)?;
        let (y, z) = rest.split_at_mut_checked(sizes.objects)?;
        let (swapped, blocks) = (state.pairs.swapped != 0, sizes.event_blocks);
        let unused = state.step.margins_in > 0;
        let (home, place) = slab.take(2 * sizes.tree)?.split_at_mut_checked(sizes.tree)?;
        // Fields are evaluated in the order in which they are written here.
        let tree = TreeParts {
            records: slab.take(sizes.records)?,
            straddlers: slab.take(sizes.straddlers)?,
            planes: slab.take(sizes.leaves)?,
            cells: slab.take(sizes.leaves)?,
            frames: slab.take(sizes.whole_leaves)?,
            leaves: slab.take(sizes.leaves)?,
            bounds: slab.take(sizes.leaves)?,
            nodes: slab.take(2 * sizes.whole_leaves)?,
            histogram: slab.take(sizes.histogram())?,
        };
        let (ends, counts) = slab.take::<[u32; 2]>(3 * blocks)?.split_at_mut_checked(blocks)?;
        let (counts, lost) = counts.split_at_mut_checked(blocks)?;
        let (count, ends) = (slab.take(usize::from(blocks > 0))?, ends.as_flattened_mut());
        let segments = Segments { count, ends, counts, lost };
        let mut pairs = slab.take(sizes.pairs)?;
        let mut previous = slab.take(sizes.previous)?;
        if swapped {
            core::mem::swap(&mut pairs, &mut previous);
        }
        Some(Self {
            state,
            boxes: BoxParts { now, fat, margins, before, tight: unused },
            former,
            filters,
            values,
            generations,
            moved,
            resting,
            changed,
            outdated,
            active,
            listed,
            order: [x, y, z],
            home,
            place,
            tree,
            output: OutputParts {
                pairs,
                previous,
                segments,
                staged: slab.take(sizes.staged * CHUNK)?,
                chunks: slab.take(sizes.staged)?,
                scratch: slab.take(sizes.workers * scratch::records::<I>(sizes.bucket))?,
            },
            sizes,
        })
    }

    /// The sizes of a world of this configuration.
    pub(crate) fn sizes(config: &Config) -> Result<Sizes, Error> {
        if let Some(margin) = config.margin {
            margin.check()?;
        }
        Sizes::of::<I>(config).ok_or(beyond::<I>(config))
    }

    /// Makes a slab into an empty world.
    pub(crate) fn init(slab: &'m mut [u8], config: &Config) -> Result<Self, Error> {
        let sizes = Self::sizes(config)?;
        let needed = layout::<I>(config).ok_or(beyond::<I>(config))?.bytes;
        check(slab, needed)?;
        let given = slab.len();
        let slab = slab.get_mut(..needed).unwrap_or_default();
        slab.fill(0);
        let mut parts = Self::carve(slab, sizes).ok_or(Error::SlabTooSmall { needed, given })?;
        *parts.state = State::new(config, size_of::<I>());
        parts.state.faults = faults();
        parts.clear();
        Ok(parts)
    }

    /// Empties all arrays, so that every slot is as new.
    pub(crate) fn clear(&mut self) {
        self.boxes.now.fill(KeyBox::EMPTY);
        self.boxes.fat.fill(KeyBox::EMPTY);
        self.boxes.before.fill(KeyBox::EMPTY);
        self.filters.classes.fill(u32::MAX);
        self.generations.fill(0);
        self.former.generations.fill(0);
        for mut set in [
            self.moved.reborrow(),
            self.changed.reborrow(),
            self.outdated.reborrow(),
            self.filters.changed.reborrow(),
            self.former.reused.reborrow(),
        ] {
            set.words.fill(0);
            set.regroup();
        }
        for bits in [&mut *self.active, self.resting, self.listed] {
            bits.fill(0);
        }
        self.home.fill(I::NONE);
        let tree = &mut self.tree;
        tree.planes.fill(0);
        tree.cells.fill(Cell::default());
        tree.frames.fill(Frame::default());
        tree.leaves.fill(Leaf::default());
        tree.bounds.fill(Record::default());
        tree.nodes.fill(KeyBox::NOTHING);
        self.output.segments.forget();
        for pairs in [&mut *self.output.pairs, self.output.previous] {
            pairs.fill([I::default(); 2]);
        }
    }

    /// Opens the world in a slab.
    pub(crate) fn open(slab: &'m mut [u8]) -> Result<Self, Error> {
        check(slab, size_of::<State>())?;
        let state =
            slab.get(..size_of::<State>()).and_then(|bytes| bytemuck::try_from_bytes::<State>(bytes).ok());
        let config = state.and_then(|state| state.setup.config(size_of::<I>())).ok_or(Error::NotAWorld)?;
        let sizes = Sizes::of::<I>(&config).ok_or(Error::NotAWorld)?;
        let needed = layout::<I>(&config).ok_or(Error::NotAWorld)?.bytes;
        check(slab, needed)?;
        let given = slab.len();
        Self::carve(slab, sizes).ok_or(Error::SlabTooSmall { needed, given })
    }

    /// Which pairs the world returns.
    pub(crate) fn mode(&self) -> Mode {
        self.state.setup.mode()
    }

    /// Whether overlaps of fat boxes may not be pairs.
    pub(crate) fn has_surplus(&self) -> bool {
        self.mode() == Mode::Exact && !self.boxes.fat.is_empty() && !self.boxes.tight
    }
}

fn check(slab: &[u8], needed: usize) -> Result<(), Error> {
    if slab.len() < needed {
        return Err(Error::SlabTooSmall { needed, given: slab.len() });
    }
    if slab.as_ptr().align_offset(ALIGN) != 0 {
        return Err(Error::SlabMisaligned { align: ALIGN });
    }
    Ok(())
}
