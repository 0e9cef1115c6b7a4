//! What a snapshot has, as it stands in a slab or in the bytes of a snapshot: so one function each saves,
//! checks and loads it.

use crate::access::{Access, bits};
use crate::config::{Config, FILTERS, MARGINS, VALUES};
use crate::filter::{CLASSES, Filter};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::layout::{Sizes, if_so, is_small, reports_margins};
use crate::memory::sections::sections;
use crate::memory::slab::{BoxParts, Parts, Section as _};
use crate::memory::slot_set::SlotSet;
use crate::memory::state::{PairState, State};
use crate::pairs::met;
use bytemuck::Pod;
use core::marker::PhantomData;

/// Items in bytes of any alignment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packed<'b, T> {
    bytes: &'b [u8],
    items: PhantomData<T>,
}

impl<'b, T: Pod + Default> Packed<'b, T> {
    fn new(items: &'b [T]) -> Self {
        Self { bytes: bytemuck::try_cast_slice(items).unwrap_or_default(), items: PhantomData }
    }

    /// Cuts so many items off the bytes.
    fn cut(bytes: &mut &'b [u8], count: usize) -> Option<Self> {
        let (own, rest) = bytes.split_at_checked(count.checked_mul(size_of::<T>())?)?;
        *bytes = rest;
        Some(Self { bytes: own, items: PhantomData })
    }

    pub(crate) const fn len(&self) -> usize {
        self.bytes.len() / size_of::<T>()
    }

    /// The item, or the default: see [`Access`].
    pub(crate) fn at(&self, index: usize) -> T {
        debug_assert!(index < self.len(), "read {index} of {}", self.len());
        let bytes = self.bytes.chunks_exact(size_of::<T>()).nth(index).unwrap_or_default();
        bytemuck::try_pod_read_unaligned(bytes).unwrap_or_default()
    }

    /// The items in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = T> + use<'b, T> {
        let item = |bytes| bytemuck::try_pod_read_unaligned(bytes).unwrap_or_default();
        self.bytes.chunks_exact(size_of::<T>()).map(item)
    }
}

impl Packed<'_, u32> {
    /// Whether a slot is in a set. False if the world does not keep the set.
    pub(crate) fn has(&self, slot: usize) -> bool {
        slot / 32 < self.len() && self.at(slot / 32) >> (slot % 32) & 1 != 0
    }

    /// The slots of a set in ascending order.
    pub(crate) fn slots(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).flat_map(|word| bits::of_word(self.at(word)).map(move |bit| word * 32 + bit))
    }

    fn count(&self) -> usize {
        self.iter().map(|word| word.count_ones() as usize).sum()
    }
}

/// The slots in use, and the words of sets of them.
struct Saved {
    slots: usize,
    words: usize,
}

impl Saved {
    fn of(state: &State) -> Self {
        let slots = state.objects.slots as usize;
        Self { slots, words: bits::words(slots) }
    }
}

macro_rules! stored {
    (
        |$s:ident, $state:ident, $n:ident| {
        $($(#[$doc:meta])* $name:ident: $type:ty = [$item:ty; $count:expr], $how:ident $what:expr
            $(, saved $saved:ident [$len:expr])?;)*
        }
        $($(#[$about:meta])* $group:ident: $Group:ident [$($of:tt)*] {
            $($(#[$gdoc:meta])* $gname:ident: $gtype:ty = [$gitem:ty; $gcount:expr], $ghow:ident $gwhat:expr
                $(, saved $gsaved:ident [$glen:expr])?;)*
            $(+ $(#[$pdoc:meta])* $plain:ident: $ptype:ty = $pvalue:expr;)*
        })*
    ) => {
        /// The sections of a snapshot: all that the table of arrays says are saved, and these. The
        /// state comes before them.
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct Stored<'b, I> {
            /// See [`State::portable`].
            pub(crate) state: State,
            pub(crate) config: Config,
            $($(pub(crate) $saved: Packed<'b, $item>,)?)*
            $($($(pub(crate) $gsaved: Packed<'b, $gitem>,)?)*)*
            pub(crate) pairs: Packed<'b, Pair<I>>,
            /// With events: pairs of the step before.
            pub(crate) previous: Packed<'b, Pair<I>>,
            /// Of changed slots: the boxes of the last complete step.
            pub(crate) before: Packed<'b, KeyBox>,
            /// Of reused slots: the generations and values of former objects.
            pub(crate) former: Packed<'b, u32>,
            pub(crate) former_values: Packed<'b, u64>,
            /// Whether the last three have an item for each slot, as in a slab, or for each in their set.
            by_slot: bool,
        }

        impl<'b, I: Index> Stored<'b, I> {
            /// What is saved of a world.
            pub(crate) fn of(parts: &'b Parts<'_, I>) -> Self {
                let state = parts.state.portable();
                let ($s, $n) = (&parts.sizes, Saved::of(&state));
                Self {
                    state,
                    config: $s.config,
                    $($($saved: Packed::new(parts.$name.items()[0].span(0, ($count).min($len))),)?)*
                    $($($($gsaved: Packed::new(parts.$group.$gname.items()[0].span(0, ($gcount).min($glen))),)?)*)*
                    pairs: Packed::new(parts.output.pairs.span(0, state.pairs.reported as usize)),
                    previous: Packed::new(parts.output.previous.span(0, state.pairs.previous as usize)),
                    before: Packed::new(parts.boxes.before),
                    former: Packed::new(parts.former.generations),
                    former_values: Packed::new(parts.values.former),
                    by_slot: true,
                }
            }

            /// Cuts the bytes behind a state. `None` if they are too few or too many, or no world is so.
            pub(crate) fn cut(state: State, mut bytes: &'b [u8]) -> Option<Self> {
                let ($s, $n) = (&Sizes::of::<I>(&state.setup.portable_config(size_of::<I>())?).ok()?, Saved::of(&state));
                let bytes = &mut bytes;
                let mut stored = Self {
                    state,
                    config: $s.config,
                    $($($saved: Packed::cut(bytes, ($count).min($len))?,)?)*
                    $($($($gsaved: Packed::cut(bytes, ($gcount).min($glen))?,)?)*)*
                    pairs: Packed::cut(bytes, state.pairs.reported as usize)?,
                    previous: Packed::cut(bytes, state.pairs.previous as usize)?,
                    before: Packed::cut(bytes, 0)?,
                    former: Packed::cut(bytes, 0)?,
                    former_values: Packed::cut(bytes, 0)?,
                    by_slot: false,
                };
                let reused = stored.reused.count();
                stored.before = Packed::cut(bytes, $s.by_object($s.config.events).min(stored.changed.count()))?;
                stored.former = Packed::cut(bytes, $s.by_object($s.config.events).min(reused))?;
                stored.former_values = Packed::cut(bytes, $s.by_object($s.config.values && $s.config.events).min(reused))?;
                (bytes.is_empty() && $n.slots <= $s.objects).then_some(stored)
            }

            /// Gives the bytes of all sections to `to`, one after another.
            pub(crate) fn write(&self, to: &mut impl FnMut(&[u8])) {
                to(bytemuck::bytes_of(&self.state));
                $($(to(self.$saved.bytes);)?)*
                $($($(to(self.$gsaved.bytes);)?)*)*
                to(self.pairs.bytes);
                to(self.previous.bytes);
                self.of_set(&self.changed, &self.before).for_each(|(_, item)| to(bytemuck::bytes_of(&item)));
                self.of_set(&self.reused, &self.former).for_each(|(_, item)| to(bytemuck::bytes_of(&item)));
                let values = self.of_set(&self.reused, &self.former_values);
                values.for_each(|(_, item)| to(bytemuck::bytes_of(&item)));
            }

            /// Puts all into an empty world with enough room. The next step finds all pairs anew.
            pub(crate) fn put(&self, to: &mut Parts<'_, I>) {
                let pairs = PairState { swapped: to.state.pairs.swapped, ..self.state.pairs };
                *to.state = State { setup: to.state.setup, pairs, ..self.state };
                $($(to.$name.load(self.$saved.bytes);)?)*
                $($($(to.$group.$gname.load(self.$gsaved.bytes);)?)*)*
                self.finish(to);
            }
        }
    };
}

sections!(stored);

impl<I: Index> Stored<'_, I> {
    /// The slots of a set, and what belongs to each of them.
    pub(crate) fn of_set<'s, T: Pod + Default>(
        &'s self,
        set: &'s Packed<'_, u32>,
        items: &'s Packed<'_, T>,
    ) -> impl Iterator<Item = (usize, T)> + 's {
        let count = if items.len() == 0 { 0 } else { usize::MAX };
        let at = |(rank, slot)| (slot, items.at(if self.by_slot { slot } else { rank }));
        set.slots().enumerate().map(at).take(count)
    }

    /// What is no more than to [load](Section::load) a section.
    fn finish(&self, to: &mut Parts<'_, I>) {
        let BoxParts { fat, before, tight, .. } = &mut to.boxes;
        *tight = false;
        fat.load(self.now.bytes);
        if !before.is_empty() {
            before.load(self.now.bytes);
            self.of_set(&self.changed, &self.before).for_each(|(slot, bounds)| before.put(slot, bounds));
            if is_small(&self.config) {
                let changed = self.moved.slots().chain(self.settled.slots());
                changed.for_each(|slot| before.put(slot, KeyBox::EMPTY));
                to.state.pairs.before_unknown = 1;
            }
        }
        // Where one set is not kept, the other tells which boxes have changed.
        if self.changed.len() == 0 {
            to.changed.load(self.moved.bytes);
            self.settled.slots().for_each(|slot| to.changed.set(slot));
        } else if to.changed.words.is_empty() {
            to.moved.load(self.changed.bytes);
            to.state.objects.dirty = 1;
        }
        let former = &mut to.former.generations;
        self.of_set(&self.reused, &self.former).for_each(|(slot, item)| former.put(slot, item));
        let former = &mut to.values.former;
        self.of_set(&self.reused, &self.former_values).for_each(|(slot, item)| former.put(slot, item));
        to.output.pairs.load(self.pairs.bytes);
        to.output.previous.load(self.previous.bytes);
        met::set_all(to);
    }
}
