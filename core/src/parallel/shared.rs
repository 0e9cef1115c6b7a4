//! Slices that several workers fill at positions that depend on the data.
//!
//! Stores are relaxed atomics: plain moves on every target. So a race would give a wrong result, which tests see, but
//! never undefined behaviour.

use crate::access::note_fault;
use bytemuck::Pod;
use core::marker::PhantomData;
use core::sync::atomic::Ordering::Relaxed;

// On other targets such an atomic may need a wider alignment than the integer.
#[cfg(all(target_has_atomic = "64", target_pointer_width = "64"))]
type Word = (u64, core::sync::atomic::AtomicU64);
#[cfg(not(all(target_has_atomic = "64", target_pointer_width = "64")))]
type Word = (u32, core::sync::atomic::AtomicU32);
/// The widest integer that the target stores in one piece.
type Plain = <Word as Pieces>::Plain;
type Atomic = <Word as Pieces>::Atomic;

trait Pieces {
    type Plain;
    type Atomic;
}
impl<P, A> Pieces for (P, A) {
    type Plain = P;
    type Atomic = A;
}

/// A slice of `T` that is written through a shared reference.
pub(crate) struct Shared<'a, T> {
    words: &'a [Atomic],
    item: PhantomData<T>,
}

impl<T> Clone for Shared<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Shared<'_, T> {}

impl<'a, T: Pod> Shared<'a, T> {
    const WORDS: usize = {
        assert!(size_of::<T>().is_multiple_of(size_of::<Plain>()));
        size_of::<T>() / size_of::<Plain>()
    };

    /// Shares a slice. If it were not aligned to words, it would be empty; the layout of the slab rules that out.
    pub(crate) fn new(slice: &'a mut [T]) -> Self {
        let words = bytemuck::try_cast_slice_mut::<T, Plain>(slice).unwrap_or_default();
        // SAFETY: the atomic has the size and bit validity of the integer; its alignment is checked below; the
        // exclusive borrow becomes a shared one of interior-mutable cells for as long as it lasts.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stores_land_where_they_should() {
        let mut items = [[0u64; 2]; 3];
        let shared = Shared::new(&mut items);
        shared.store(2, &[5, 6]);
        shared.store(0, &[1, 2]);
        assert_eq!(items, [[1, 2], [0, 0], [5, 6]]);
    }

    /// Small enough for Miri with many seeds.
    #[test]
    fn threads_fill_one_slice() {
        let mut items = [[0u64; 2]; 12];
        let shared = &Shared::new(&mut items);
        std::thread::scope(|scope| {
            for worker in 0..3 {
                let slots = (worker..12).step_by(3);
                scope.spawn(move || slots.for_each(|slot| shared.store(slot, &[slot as u64, worker as u64])));
            }
        });
        assert!(items.iter().enumerate().all(|(slot, item)| *item == [slot as u64, slot as u64 % 3]));
    }
}
