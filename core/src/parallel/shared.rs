//! Slices that several workers fill at positions that depend on the data.
//!
//! Loads and stores are relaxed atomics: plain moves on every target. So a race would give a wrong result,
//! which tests see, but never undefined behaviour.

use crate::access::note_fault;
use crate::id::Word;
use bytemuck::Pod;
use core::marker::PhantomData;
use core::sync::atomic::Ordering::Relaxed;

// The widest number that the target loads and stores in one piece. On other targets its atomic may need a wider alignment than the number.
#[cfg(not(all(target_has_atomic = "64", target_pointer_width = "64")))]
use core::primitive::u32 as Widest;
#[cfg(all(target_has_atomic = "64", target_pointer_width = "64"))]
use core::primitive::u64 as Widest;

/// A slice of `T` that is read and written through a shared reference, `W` by `W`.
pub(crate) struct Shared<'a, T, W: Word = Widest> {
    words: &'a [W::Atomic],
    item: PhantomData<T>,
}

impl<T: Copy, W: Word> Copy for Shared<'_, T, W> {}
impl<T: Copy, W: Word> Clone for Shared<'_, T, W> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<'a, T: Pod, W: Word> Shared<'a, T, W> {
    const WORDS: usize = {
        assert!(size_of::<T>().is_multiple_of(size_of::<W>()));
        size_of::<T>() / size_of::<W>()
    };

    /// Shares a slice. Not aligned to words it would be empty; the layout of the slab rules that out.
    pub(crate) fn new(slice: &'a mut [T]) -> Self {
        let words = bytemuck::try_cast_slice_mut::<T, W>(slice).unwrap_or_default();
        // SAFETY: the atomic has the size and bit validity of the number; its alignment is checked below;
        // the exclusive borrow becomes a shared one of interior-mutable cells for as long as it lasts.
        let words = unsafe { &*(core::ptr::from_mut(words) as *const [W::Atomic]) };
        const {
            assert!(align_of::<W::Atomic>() == align_of::<W>() && size_of::<W::Atomic>() == size_of::<W>());
        };
        Self { words, item: PhantomData }
    }

    /// The words of item `index`; none beyond the slice.
    #[inline(always)]
    fn words(&self, index: usize) -> &'a [W::Atomic] {
        let start = index * Self::WORDS;
        self.words.get(start..start + Self::WORDS).unwrap_or_else(|| {
            debug_assert!(false, "item {index} of {}", self.words.len() / Self::WORDS);
            note_fault(self.words.as_ptr().addr());
            &[]
        })
    }

    /// Writes item `index`. Does nothing beyond the slice.
    #[inline(always)]
    pub(crate) fn store(&self, index: usize, item: &T) {
        let pieces = bytemuck::bytes_of(item).chunks_exact(size_of::<W>());
        for (word, piece) in self.words(index).iter().zip(pieces) {
            W::STORE(word, bytemuck::pod_read_unaligned(piece), Relaxed);
        }
    }

    /// Reads item `index`; zero beyond the slice.
    #[inline(always)]
    pub(crate) fn load(&self, index: usize) -> T {
        let mut item = T::zeroed();
        let pieces = bytemuck::bytes_of_mut(&mut item).chunks_exact_mut(size_of::<W>());
        for (word, piece) in self.words(index).iter().zip(pieces) {
            piece.copy_from_slice(bytemuck::bytes_of(&W::LOAD(word, Relaxed)));
        }
        item
    }
}
