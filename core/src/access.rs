//! Slice access that cannot panic.
//!
//! The core never panics. It takes no index with `[]` that the compiler cannot see to be in range. The
//! invariants of a world keep every index in range. If one is not, a read gives the default, a write does
//! nothing, and the next step reports [`Error::InvariantBroken`](crate::Error::InvariantBroken), as a pair
//! may be missing. Builds with debug assertions stop at once instead; nearly all tests run in such a build.
//!
//! This code has no world at hand. So it notes where the slice is, and each world looks for its own slab. A
//! slice outside of all slabs, a few local arrays, is noted and nobody's.

use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering::Relaxed};

/// How many indices were out of range, in all worlds of the process.
static FAULTS: AtomicU32 = AtomicU32::new(0);
/// The addresses of the last slices. A world's own is overwritten only if others break at the same time.
static SLICES: [AtomicUsize; SLICES_KEPT] = [const { AtomicUsize::new(0) }; SLICES_KEPT];
const SLICES_KEPT: usize = if cfg!(feature = "large") { 128 } else { 1 };

/// Notes an index out of range of a slice.
#[cold]
#[inline(never)]
pub(crate) fn note_fault(slice: usize) {
    #[cfg(target_has_atomic = "32")]
    let count = FAULTS.fetch_add(1, Relaxed);
    // Without atomic addition steps are serial.
    #[cfg(not(target_has_atomic = "32"))]
    let count = {
        let count = FAULTS.load(Relaxed);
        FAULTS.store(count.wrapping_add(1), Relaxed);
        count
    };
    if let Some(last) = SLICES.get(count as usize % SLICES.len()) {
        last.store(slice, Relaxed);
    }
}

/// Looks for faults in one slab.
pub(crate) struct Watch {
    slab: core::ops::Range<usize>,
    /// The faults of the process that it has looked at.
    known: u32,
}

impl Watch {
    pub(crate) fn over(slab: &[u8]) -> Self {
        let start = slab.as_ptr().addr();
        Self { slab: start..start + slab.len(), known: FAULTS.load(Relaxed) }
    }

    /// Whether an index into the slab was out of range since the last step.
    pub(crate) fn sees_fault(&self) -> bool {
        let count = FAULTS.load(Relaxed);
        let new = count.wrapping_sub(self.known);
        // Of more than are kept one may have been its own. A small program has one world, or few.
        let some_are_lost = !cfg!(feature = "large") && new as usize > SLICES_KEPT;
        let is_own = |slice: &AtomicUsize| self.slab.contains(&slice.load(Relaxed));
        let kept = new.min(SLICES_KEPT as u32);
        let mut last = (1..=kept).map(|back| count.wrapping_sub(back) as usize % SLICES.len());
        some_are_lost || last.any(|number| SLICES.get(number).is_some_and(is_own))
    }

    /// Forgets the faults so far.
    pub(crate) fn forget(&mut self) {
        self.known = FAULTS.load(Relaxed);
    }

    /// After the world of another slab has come here: the faults that it has not reported come with it.
    pub(crate) fn follow(&mut self, other: &Self) {
        self.forget();
        if other.sees_fault() {
            note_fault(self.slab.start);
        }
    }
}

/// See the module.
pub(crate) trait Access<T>: AsRef<[T]> + AsMut<[T]> {
    /// The element, or the default.
    #[inline(always)]
    fn at(&self, index: usize) -> T
    where
        T: Copy + Default,
    {
        let items = self.as_ref();
        debug_assert!(index < items.len(), "read {index} of {}", items.len());
        match items.get(index) {
            Some(element) => *element,
            None => {
                note_fault(items.as_ptr().addr());
                T::default()
            }
        }
    }

    /// Replaces the element.
    #[inline(always)]
    fn put(&mut self, index: usize, value: T) {
        let items = self.as_mut();
        debug_assert!(index < items.len(), "write {index} of {}", items.len());
        match items.get_mut(index) {
            Some(element) => *element = value,
            None => note_fault(items.as_ptr().addr()),
        }
    }

    /// Exchanges two elements.
    fn swap_at(&mut self, a: usize, b: usize)
    where
        T: Copy + Default,
    {
        let (first, second) = (self.at(a), self.at(b));
        self.put(a, second);
        self.put(b, first);
    }

    /// Copies as many elements as both slices have. `copy_from_slice` could panic.
    fn copy_in(&mut self, from: &[T])
    where
        T: Copy,
    {
        for (to, from) in self.as_mut().iter_mut().zip(from) {
            *to = *from;
        }
    }

    /// `len` elements from `start`, or none.
    fn span(&self, start: usize, len: usize) -> &[T] {
        let items = self.as_ref();
        debug_assert!(start + len <= items.len(), "span {start}+{len} of {}", items.len());
        items.get(start..).and_then(|tail| tail.get(..len)).unwrap_or_else(|| {
            note_fault(items.as_ptr().addr());
            &[]
        })
    }

    /// `len` elements from `start`, or none.
    fn span_mut(&mut self, start: usize, len: usize) -> &mut [T] {
        let items = self.as_mut();
        let slice = items.as_ptr().addr();
        debug_assert!(start + len <= items.len(), "span {start}+{len} of {}", items.len());
        items.get_mut(start..).and_then(|tail| tail.get_mut(..len)).unwrap_or_else(|| {
            note_fault(slice);
            &mut []
        })
    }
}

impl<T> Access<T> for [T] {}

/// One bit for each slot, in words of 32.
pub(crate) mod bits {
    use super::Access;

    /// Words for `count` bits.
    pub(crate) const fn words(count: usize) -> usize {
        count.div_ceil(32)
    }

    #[inline(always)]
    pub(crate) fn test(words: &[u32], bit: usize) -> bool {
        words.at(bit / 32) >> (bit % 32) & 1 != 0
    }

    pub(crate) fn set(words: &mut [u32], bit: usize) {
        let word = words.at(bit / 32);
        words.put(bit / 32, word | 1 << (bit % 32));
    }

    pub(crate) fn clear(words: &mut [u32], bit: usize) {
        let word = words.at(bit / 32);
        words.put(bit / 32, word & !(1 << (bit % 32)));
    }

    /// The set bits of one word in ascending order.
    pub(crate) fn of_word(word: u32) -> impl Iterator<Item = usize> {
        let mut rest = word;
        core::iter::from_fn(move || {
            let (word, bit) = (rest, rest.trailing_zeros() as usize);
            rest &= rest.wrapping_sub(1);
            (word != 0).then_some(bit)
        })
    }
}
