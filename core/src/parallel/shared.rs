//! Slices that several workers fill at positions that depend on the data.
//!
//! Stores are relaxed atomics: plain moves on every target. So a race would give a wrong result, which tests
//! see, but never undefined behaviour.

use crate::access::{Access, note_fault};
use crate::id::Index;
use bytemuck::Pod;
use core::marker::PhantomData;
use core::sync::atomic::{AtomicU16, Ordering::Relaxed};

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

/// The same for slots, which are as wide as one or two halves.
#[derive(Clone, Copy)]
pub(crate) struct SharedSlots<'a>(&'a [AtomicU16]);

impl<'a> SharedSlots<'a> {
    pub(crate) fn new<I: Index>(slots: &'a mut [I]) -> Self {
        let halves = bytemuck::try_cast_slice_mut::<I, u16>(slots).unwrap_or_default();
        // SAFETY: as above; the atomic is aligned as the integer on every target.
        Self(unsafe { &*(core::ptr::from_mut(halves) as *const [AtomicU16]) })
    }

    /// Writes a slot. Does nothing beyond the slice.
    pub(crate) fn store<I: Index>(&self, index: usize, slot: I) {
        let width = size_of::<I>() / 2;
        let halves = self.0.get(index * width..index * width + width).unwrap_or_default();
        for (half, piece) in halves.iter().zip(bytemuck::bytes_of(&slot).chunks_exact(2)) {
            half.store(bytemuck::pod_read_unaligned(piece), Relaxed);
        }
    }
}
