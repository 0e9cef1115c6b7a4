//! Ids of objects: a slot and its generation.

use bytemuck::Pod;
use core::fmt;
use core::num::NonZeroU64;
use core::sync::atomic::{AtomicU16, AtomicU32, Ordering::Relaxed};

/// Names one object while it lives: a slot and the generation of that slot.
///
/// The bits are never zero: zero is null in C, and `Option<Id>` takes no more bytes. A slot gets a new
/// generation with each object, so the id of a removed object is stale.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(NonZeroU64);

impl Id {
    /// The id of `slot` in its `generation` (which starts at 1).
    pub(crate) const fn new(slot: u32, generation: u32) -> Option<Self> {
        match NonZeroU64::new(((generation as u64) << 32) | slot as u64) {
            Some(bits) if generation != 0 => Some(Self(bits)),
            _ => None,
        }
    }

    /// The index of the object in pairs and in the caller's arrays.
    #[must_use]
    pub const fn slot(self) -> u32 {
        self.0.get() as u32
    }

    /// How many objects have had this slot, this one included.
    #[must_use]
    pub const fn generation(self) -> u32 {
        (self.0.get() >> 32) as u32
    }

    /// The id as an integer, for storage outside Rust.
    #[must_use]
    pub const fn to_bits(self) -> u64 {
        self.0.get()
    }

    /// The id with these bits; `None` if the bits or the generation are zero.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Option<Self> {
        Self::new(bits as u32, (bits >> 32) as u32)
    }
}

impl fmt::Debug for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Id({}v{})", self.slot(), self.generation())
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}v{}", self.slot(), self.generation())
    }
}

mod sealed {
    /// How workers share a slice of it.
    pub trait Sealed: Sized {
        type Atomic: Sync;
        fn store_to(self, to: &Self::Atomic);
        fn load_from(from: &Self::Atomic) -> Self;
    }
}

/// The width of slots in a world. `u16` halves their memory in worlds of up to 65,534 objects.
pub trait Index:
    sealed::Sealed + Pod + Default + Ord + Send + Sync + fmt::Debug + core::hash::Hash + 'static
{
    /// The index that no object has.
    const NONE: Self;
    /// The home of a large object, which is in no leaf.
    const LARGE: Self;
    /// The most objects that a world of this width can hold.
    const MAX_OBJECTS: u32;
    /// From a slot. The world's capacity keeps it in range.
    fn from_slot(slot: u32) -> Self;
    /// As a slot.
    fn slot(self) -> u32;
    /// As a position in a slice.
    fn at(self) -> usize {
        self.slot() as usize
    }
}

macro_rules! index {
    ($type:ty, $atomic:ty, $most:expr) => {
        impl sealed::Sealed for $type {
            type Atomic = $atomic;
            fn store_to(self, to: &$atomic) {
                to.store(self, Relaxed);
            }
            fn load_from(from: &$atomic) -> Self {
                from.load(Relaxed)
            }
        }

        impl Index for $type {
            const NONE: Self = Self::MAX;
            const LARGE: Self = Self::MAX - 1;
            const MAX_OBJECTS: u32 = $most;
            fn from_slot(slot: u32) -> Self {
                slot as Self
            }
            fn slot(self) -> u32 {
                self.into()
            }
        }
    };
}
index!(u16, AtomicU16, 65_534);
index!(u32, AtomicU32, 1 << 27);

/// Two overlapping objects by slot, the lower one first.
pub type Pair<I = u32> = [I; 2];

/// The pair of two slots.
#[inline(always)]
pub(crate) fn pair<I: Index>(a: u32, b: u32) -> Pair<I> {
    [I::from_slot(a.min(b)), I::from_slot(a.max(b))]
}
