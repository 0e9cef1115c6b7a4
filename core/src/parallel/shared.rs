//! Slices that several workers fill at positions that depend on the data.
//!
//! Stores are relaxed atomics: plain moves on every target. So a race would give a wrong result, which tests
//! see, but never undefined behaviour.

use crate::access::{Access, note_fault};
use crate::id::Index;
use bytemuck::Pod;
use core::marker::PhantomData;
use core::sync::atomic::Ordering::Relaxed;

// The widest integer that the target stores in one piece. On other targets such an atomic may need a wider
// alignment than the integer.
#[cfg(not(all(target_has_atomic = "64", target_pointer_width = "64")))]
use core::{primitive::u32 as Plain, sync::atomic::AtomicU32 as Atomic};
#[cfg(all(target_has_atomic = "64", target_pointer_width = "64"))]
use core::{primitive::u64 as Plain, sync::atomic::AtomicU64 as Atomic};

/// A slice of `T` that is written through a shared reference.
#[derive(Clone, Copy)]
pub(crate) struct Shared<'a, T> {
    words: &'a [Atomic],
    item: PhantomData<T>,
}

impl<'a, T: Pod> Shared<'a, T> {
    const WORDS: usize = {
        assert!(size_of::<T>().is_multiple_of(size_of::<Plain>()));
        size_of::<T>() / size_of::<Plain>()
    };

    /// Shares a slice. Not aligned to words it would be empty; the layout of the slab rules that out.
    pub(crate) fn new(slice: &'a mut [T]) -> Self {
        let words = bytemuck::try_cast_slice_mut::<T, Plain>(slice).unwrap_or_default();
        // SAFETY: the atomic has the size and bit validity of the integer; its alignment is checked below;
        // the exclusive borrow becomes a shared one of interior-mutable cells for as long as it lasts.
        let words = unsafe { &*(core::ptr::from_mut(words) as *const [Atomic]) };
        const { assert!(align_of::<Atomic>() == align_of::<Plain>() && size_of::<Atomic>() == size_of::<Plain>()) };
        Self { words, item: PhantomData }
    }

    /// Writes item `index`. Does nothing beyond the slice.
    #[inline(always)]
    pub(crate) fn store(&self, index: usize, item: &T) {
        let start = index * Self::WORDS;
        let Some(target) = self.words.get(start..start + Self::WORDS) else {
            debug_assert!(false, "store {index} of {}", self.words.len() / Self::WORDS);
            note_fault(self.words.as_ptr().addr());
            return;
        };
        let bytes = bytemuck::bytes_of(item);
        for (word, piece) in target.iter().zip(bytes.chunks_exact(size_of::<Plain>())) {
            word.store(bytemuck::pod_read_unaligned(piece), Relaxed);
        }
    }

    /// Item `index`, which no other worker writes; or zero.
    #[inline(always)]
    pub(crate) fn load(&self, index: usize) -> T {
        let (mut item, start) = (T::zeroed(), index * Self::WORDS);
        let words = self.words.get(start..start + Self::WORDS).unwrap_or_default();
        for (piece, word) in bytemuck::bytes_of_mut(&mut item).chunks_exact_mut(size_of::<Plain>()).zip(words)
        {
            piece.copy_in(bytemuck::bytes_of(&word.load(Relaxed)));
        }
        item
    }
}

/// The same for slots.
pub(crate) struct SharedSlots<'a, I: Index>(&'a [I::Atomic]);

// Derived, it would ask for a copy of the atomic.
impl<I: Index> Copy for SharedSlots<'_, I> {}
impl<I: Index> Clone for SharedSlots<'_, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<'a, I: Index> SharedSlots<'a, I> {
    pub(crate) fn new(slots: &'a mut [I]) -> Self {
        const { assert!(align_of::<I::Atomic>() == align_of::<I>() && size_of::<I::Atomic>() == size_of::<I>()) };
        // SAFETY: the atomic is that of the integer, with its bit validity, and its size and alignment, as is
        // checked above; and the borrow becomes a shared one, as before.
        Self(unsafe { &*(core::ptr::from_mut(slots) as *const [I::Atomic]) })
    }

    /// Writes a slot. Does nothing beyond the slice.
    pub(crate) fn store(&self, index: usize, slot: I) {
        self.0.get(index).into_iter().for_each(|to| slot.store_to(to));
    }

    /// A slot, which no other worker writes; or zero.
    pub(crate) fn load(&self, index: usize) -> I {
        self.0.get(index).map_or(I::zeroed(), I::load_from)
    }
}
