//! Reads what is to be checked, from a slab or from the bytes of a snapshot, so that checks are written once for
//! both.

use crate::access::{Access, bits};
use crate::filter::Filter;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::layout::Sizes;
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::tree::{Frame, Record};
use bytemuck::{Pod, Zeroable};

/// The numbers of a leaf in a snapshot. The rest follows from them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct LeafCounts {
    /// Records, and records that fit; zero if the leaves are not filled.
    pub(crate) len: u32,
    pub(crate) room: u32,
    /// See [`Leaf::baseline`](crate::tree::Leaf::baseline).
    pub(crate) baseline: u32,
}

/// The sets of slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Set {
    Moved,
    Resting,
    Changed,
    Active,
    /// Whose filter has changed.
    Refiltered,
    /// Whose slot had another object in the complete step before.
    Reused,
}

/// The place of an object in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A leaf, and the place in it.
    Leaf(usize, usize),
    /// Its position in the list of large objects.
    Large(usize),
}

/// See the module. Callers keep indices within what the state says.
pub(crate) trait Content<I: Index> {
    /// What the world was made for.
    fn sizes(&self) -> &Sizes;
    fn state(&self) -> &State;
    fn now(&self, slot: usize) -> KeyBox;
    fn fat(&self, slot: usize) -> KeyBox;
    fn margin(&self, slot: usize) -> f32;
    /// The box of the last complete step, of an object that may have another one now: by its slot, and by how many
    /// such slots are below it.
    fn before(&self, slot: usize, rank: usize) -> KeyBox;
    /// The generation of the former object of a reused slot: by the slot, and by how many such slots are below it.
    fn former(&self, slot: usize, rank: usize) -> u32;
    /// The value of that object.
    fn former_value(&self, slot: usize, rank: usize) -> u64;
    fn value(&self, slot: usize) -> u64;
    fn filter(&self, slot: usize) -> Filter;
    /// A row of the class matrix.
    fn class(&self, class: usize) -> u32;
    fn generation(&self, slot: usize) -> u32;
    /// A word of a set; `None` if the world does not keep the set.
    fn word(&self, set: Set, index: usize) -> Option<u32>;
    fn plane(&self, node: usize) -> i32;
    fn leaf(&self, index: usize) -> LeafCounts;
    /// The frame of a whole leaf.
    fn frame(&self, whole: usize) -> Frame;
    fn bounds(&self, leaf: usize) -> Record;
    fn node(&self, node: usize) -> KeyBox;
    /// The slot of a record: by its position in the slab, where leaves have free room, and by its position in a
    /// snapshot, where they have none.
    fn member(&self, position: usize, packed: usize) -> usize;
    fn large(&self, at: usize) -> usize;
    fn pair(&self, at: usize) -> Pair<I>;
    fn previous(&self, at: usize) -> Pair<I>;
    /// How many segments the last complete result has, and where each ends.
    fn segments(&self) -> usize;
    fn segment(&self, at: usize) -> u32;
    /// Notes the place of an object; `false` if it has another place. Called for each record and each large object.
    fn is_at(&mut self, slot: usize, at: Place) -> bool;

    /// Whether a slot is in a set. False if the world does not keep the set.
    #[inline(always)]
    fn is_in(&self, set: Set, slot: usize) -> bool {
        self.word(set, slot / 32).is_some_and(|word| word >> (slot % 32) & 1 != 0)
    }

    /// The box that is swept.
    #[inline(always)]
    fn swept(&self, slot: usize) -> KeyBox {
        if self.sizes().fat > 0 { self.fat(slot) } else { self.now(slot) }
    }
}

/// The slab of a world.
pub(crate) struct InSlab<'p, 'm, I>(pub(crate) &'p Parts<'m, I>);

impl<I: Index> Content<I> for InSlab<'_, '_, I> {
    fn sizes(&self) -> &Sizes {
        &self.0.sizes
    }

    fn state(&self) -> &State {
        self.0.state
    }

    #[inline(always)]
    fn now(&self, slot: usize) -> KeyBox {
        self.0.boxes.now.at(slot)
    }

    #[inline(always)]
    fn fat(&self, slot: usize) -> KeyBox {
        self.0.boxes.swept().at(slot)
    }

    fn margin(&self, slot: usize) -> f32 {
        self.0.boxes.margins.at(slot)
    }

    fn before(&self, slot: usize, _: usize) -> KeyBox {
        self.0.boxes.before.at(slot)
    }

    fn former(&self, slot: usize, _: usize) -> u32 {
        self.0.former.generations.at(slot)
    }

    fn former_value(&self, slot: usize, _: usize) -> u64 {
        self.0.values.former.at(slot)
    }

    fn value(&self, slot: usize) -> u64 {
        self.0.values.of.at(slot)
    }

    fn filter(&self, slot: usize) -> Filter {
        self.0.filters.of.at(slot)
    }

    fn class(&self, class: usize) -> u32 {
        self.0.filters.classes.at(class)
    }

    fn generation(&self, slot: usize) -> u32 {
        self.0.generations.at(slot)
    }

    #[inline(always)]
    fn word(&self, set: Set, index: usize) -> Option<u32> {
        let parts = self.0;
        let words = match set {
            Set::Moved => &*parts.moved.words,
            Set::Resting => parts.resting,
            Set::Changed => parts.changed.words,
            Set::Active => parts.active,
            Set::Refiltered => parts.filters.changed.words,
            Set::Reused => parts.former.reused.words,
        };
        words.get(index).copied()
    }

    fn plane(&self, node: usize) -> i32 {
        self.0.tree.planes.at(node)
    }

    fn leaf(&self, index: usize) -> LeafCounts {
        leaf(self.0, index)
    }

    fn frame(&self, whole: usize) -> Frame {
        self.0.tree.frames.at(whole)
    }

    fn bounds(&self, leaf: usize) -> Record {
        self.0.tree.bounds.at(leaf)
    }

    fn node(&self, node: usize) -> KeyBox {
        self.0.tree.nodes.at(node)
    }

    fn member(&self, position: usize, _: usize) -> usize {
        self.0.tree.records.at(position).slot() as usize
    }

    fn large(&self, at: usize) -> usize {
        self.0.tree.straddlers.at(self.0.state.tree.large_start as usize + at).slot as usize
    }

    #[inline(always)]
    fn pair(&self, at: usize) -> Pair<I> {
        self.0.output.pairs.at(at)
    }

    fn previous(&self, at: usize) -> Pair<I> {
        self.0.output.previous.at(at)
    }

    fn segments(&self) -> usize {
        2 * self.0.output.segments.blocks()
    }

    fn segment(&self, at: usize) -> u32 {
        self.0.output.segments.ends.at(at)
    }

    fn is_at(&mut self, slot: usize, at: Place) -> bool {
        let (home, place) = match at {
            Place::Leaf(leaf, place) => (I::from_slot(leaf as u32), place),
            Place::Large(place) => (I::LARGE, place),
        };
        self.0.home.at(slot) == home && self.0.place.at(slot).at() == place
    }
}

/// The numbers of a leaf of a world.
pub(crate) fn leaf<I: Index>(parts: &Parts<'_, I>, index: usize) -> LeafCounts {
    let leaf = parts.tree.leaves.at(index);
    let filled = parts.state.tree.filled != 0;
    let [len, room] = [leaf.len, leaf.room].map(|count| if filled { count } else { 0 });
    LeafCounts { len, room, baseline: leaf.baseline }
}

/// How many slots a set has; none may be beyond `slots`.
pub(super) fn count<I: Index>(content: &impl Content<I>, set: Set, slots: usize) -> usize {
    (0..bits::words(slots))
        .filter_map(|index| content.word(set, index))
        .map(|w| w.count_ones() as usize)
        .sum()
}
