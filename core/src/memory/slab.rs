//! The slab of a world, divided into slices for the layers that own them: see [`sections`].

use super::layout::{ALIGN, Sizes, if_so, reports_margins, section};
use super::leaf::{Cell, Leaf, Nodes, Split, Straddler, Straddling};
use super::limits::CHUNK;
use super::scratch::{self, cut_off};
use super::sections::sections;
use super::slot_set::SlotSet;
use super::state::State;
use crate::access::{Access, Watch, bits};
use crate::config::{Config, EVENTS, FILTERS, MARGINS, TREE, VALUES};
use crate::error::Error;
use crate::filter::{CLASSES, Filter};
use crate::geometry::key::KeyBox;
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use bytemuck::Pod;

/// An array of a world, or what stands for it.
pub(crate) trait Section<'m, T: Pod>: Sized {
    /// Takes its memory.
    fn of(memory: &'m mut [T]) -> Self;
    /// The items, in up to two slices.
    fn items(&self) -> [&[T]; 2];
    fn items_mut(&mut self) -> [&mut [T]; 2];
    /// Brings up to date what follows from the first slice.
    fn derive(&mut self) {}

    fn fill(&mut self, value: T) {
        self.items_mut().into_iter().for_each(|items| items.fill(value));
    }

    /// Takes over so many items of each slice, or all.
    fn copy(&mut self, from: [&[T]; 2], count: usize) {
        for (to, from) in self.items_mut().into_iter().zip(from) {
            to.copy_in(from.get(..count).unwrap_or(from));
        }
    }

    /// Takes over the bytes of the first items.
    fn load(&mut self, bytes: &[u8]) {
        let [items, ..] = self.items_mut();
        bytemuck::try_cast_slice_mut::<T, u8>(items).unwrap_or_default().copy_in(bytes);
        self.derive();
    }
}

impl<'m, T: Pod> Section<'m, T> for &'m mut [T] {
    fn of(memory: &'m mut [T]) -> Self {
        memory
    }

    fn items(&self) -> [&[T]; 2] {
        [self, &[]]
    }

    fn items_mut(&mut self) -> [&mut [T]; 2] {
        [self, &mut []]
    }
}

impl<'m> Section<'m, u32> for SlotSet<'m> {
    fn of(memory: &'m mut [u32]) -> Self {
        let groups = if TREE { memory.len().div_ceil(33) } else { 0 };
        let (words, groups) = memory.split_at_mut_checked(memory.len() - groups).unwrap_or_default();
        Self { words, groups }
    }

    fn items(&self) -> [&[u32]; 2] {
        [self.words, self.groups]
    }

    fn items_mut(&mut self) -> [&mut [u32]; 2] {
        [self.words, self.groups]
    }

    fn derive(&mut self) {
        self.groups.fill(0);
        for word in 0..self.words.len() {
            self.add(word, self.words.at(word));
        }
    }
}

macro_rules! clear {
    (new $section:expr, $value:expr, $zero:expr) => {
        if !$zero || bytemuck::bytes_of(&$value).iter().any(|byte| *byte != 0) {
            $section.fill($value);
        }
    };
    (used $section:expr, $count:expr, $zero:expr) => {};
}

macro_rules! copy {
    (new $to:expr, $from:expr, $value:expr) => {
        $to.copy($from.items(), usize::MAX);
    };
    (used $to:expr, $from:expr, $count:expr) => {
        $to.copy($from.items(), $count);
    };
}

macro_rules! slab {
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
        /// The slices of a world, by slot unless said otherwise.
        pub(crate) struct Parts<'m, I> {
            pub(crate) sizes: Sizes,
            pub(crate) state: &'m mut State,
            pub(crate) watch: Watch,
            $($(#[$doc])* pub(crate) $name: $type,)*
            $($(#[$about])* pub(crate) $group: $Group<$($of)*>,)*
        }

        $($(#[$about])*
        pub(crate) struct $Group<$($of)*> {
            $($(#[$gdoc])* pub(crate) $gname: $gtype,)*
            $($(#[$pdoc])* pub(crate) $plain: $ptype,)*
        })*

        impl Sizes {
            /// The bytes of all sections, one after another.
            pub(super) const fn sum<I: Index>(&self) -> Option<usize> {
                let $s = self;
                let mut bytes = section::<State>(1, Some(0), $s);
                $(bytes = section::<$item>($count, bytes, $s);)*
                $($(bytes = section::<$gitem>($gcount, bytes, $s);)*)*
                bytes
            }
        }

        impl<'m, I: Index> Parts<'m, I> {
            /// Carves a slab that is long enough and aligned.
            fn carve(slab: &'m mut [u8], sizes: Sizes) -> Result<Self, Error> {
                let $s = &sizes;
                let watch = Watch::over(slab);
                let rest = &mut &mut *slab;
                let $state: &mut State = take(rest, 1, $s).first_mut().ok_or(Error::InvariantBroken)?;
                let swapped = $state.pairs.swapped != 0;
                let mut parts = Self {
                    $($name: Section::of(take::<$item>(rest, $count, $s)),)*
                    $($group: $Group {
                        $($gname: Section::of(take::<$gitem>(rest, $gcount, $s)),)*
                        $($plain: $pvalue,)*
                    },)*
                    state: $state,
                    watch,
                    sizes,
                };
                if swapped {
                    core::mem::swap(&mut parts.output.pairs, &mut parts.output.previous);
                }
                Ok(parts)
            }

            /// Empties the world, if all is zero that was there before or not. What is never read before it
            /// is written stays as it was.
            pub(crate) fn clear(&mut self, zero: bool) {
                $(clear!($how self.$name, $what, zero);)*
                $($(clear!($ghow self.$group.$gname, $gwhat, zero);)*)*
            }

            /// Becomes a copy of a world of the same capacity and kind.
            pub(crate) fn copy(&mut self, from: &Parts<'_, I>) {
                let ($s, $state) = (&from.sizes, &*from.state);
                $(copy!($how self.$name, from.$name, $what);)*
                $($(copy!($ghow self.$group.$gname, from.$group.$gname, $gwhat);)*
                  $(self.$group.$plain = from.$group.$plain;)*)*
                let swapped = self.state.pairs.swapped;
                (*self.state, self.sizes) = (*from.state, from.sizes);
                self.state.pairs.swapped = swapped;
            }
        }
    };
}

sections!(slab);

/// Cuts a section off the slab. By the layout's arithmetic there is always enough.
fn take<'m, T: Pod>(rest: &mut &'m mut [u8], count: usize, sizes: &Sizes) -> &'m mut [T] {
    let bytes = if count == 0 { None } else { section::<T>(count, Some(0), sizes) };
    bytes.and_then(|bytes| cut_off(rest, bytes, count)).unwrap_or_default()
}

impl TreeParts<'_> {
    pub(crate) fn nodes(&self) -> Nodes<'_> {
        Nodes { boxes: self.boxes, splits: self.splits, parents: self.parents, tops: self.tops }
    }
}

impl BoxParts<'_> {
    /// Whether fat boxes are swept, of which overlaps may not be pairs.
    pub(crate) fn are_fat(&self) -> bool {
        TREE && !self.fat.is_empty() && !self.tight
    }

    /// The boxes that lists, planes and sweeps use.
    pub(crate) fn swept(&self) -> &[KeyBox] {
        if self.are_fat() { self.fat } else { self.now }
    }

    /// The boxes as given last.
    pub(crate) fn given(&self) -> &[KeyBox] {
        if !MARGINS || self.given.is_empty() { self.now } else { self.given }
    }
}

impl<'m, I: Index> Parts<'m, I> {
    /// Makes a slab into an empty world.
    pub(crate) fn init(slab: &'m mut [u8], config: &Config) -> Result<Self, Error> {
        let sizes = Sizes::of::<I>(config)?;
        let slab = front(slab, sizes.bytes)?;
        if !TREE {
            // Few bytes; and nearly all arrays of a new lean world are zero, so this is less code.
            slab.fill(0);
        }
        // Only the state decides how a slab is carved.
        slab.span_mut(0, size_of::<State>()).copy_in(bytemuck::bytes_of(&State::new(config, size_of::<I>())));
        let mut parts = Self::carve(slab, sizes)?;
        parts.clear(!TREE);
        Ok(parts)
    }

    /// Opens the world in a slab.
    pub(crate) fn open(slab: &'m mut [u8]) -> Result<Self, Error> {
        let sizes = Self::sizes_in(slab)?;
        Self::carve(front(slab, sizes.bytes)?, sizes)
    }

    // Its stack frame does not stand below that of the parts.
    #[inline(never)]
    fn sizes_in(slab: &mut [u8]) -> Result<Sizes, Error> {
        let state = bytemuck::try_from_bytes::<State>(front(slab, size_of::<State>())?).ok();
        let config = state.and_then(|state| state.setup.config(size_of::<I>())).ok_or(Error::NotAWorld)?;
        Sizes::of::<I>(&config).map_err(|_| Error::NotAWorld)
    }

    /// What the world was made for.
    pub(crate) fn config(&self) -> &Config {
        &self.sizes.config
    }
}

/// The front of a slab, if that is as long and as aligned as it has to be.
fn front(slab: &mut [u8], needed: usize) -> Result<&mut [u8], Error> {
    let given = slab.len();
    let slab = slab.get_mut(..needed).ok_or(Error::SlabTooSmall { needed, given })?;
    let is_aligned = slab.as_ptr().align_offset(ALIGN) == 0;
    if is_aligned { Ok(slab) } else { Err(Error::SlabMisaligned { align: ALIGN }) }
}
