//! Slice access that cannot panic.
//!
//! The core never panics. So it takes no index with `[]` where the compiler cannot see that the index is in range.
//! The invariants of a world keep every index in range. If one is not, a read gives the default, a write does
//! nothing, and the next step reports [`Error::InvariantBroken`](crate::Error::InvariantBroken), since a pair may be
//! missing. Builds with debug assertions stop at once instead; nearly all tests run in such a build.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// How many indices were out of range, in all worlds of the process: this code has no world at hand.
static FAULTS: AtomicU32 = AtomicU32::new(0);

/// Counts an index out of range.
#[cold]
#[inline(never)]
pub(crate) fn note_fault() {
    // Not one atomic operation, as some processors have none. If two threads count at once, one count is enough.
    FAULTS.store(FAULTS.load(Relaxed).wrapping_add(1), Relaxed);
}

/// The count. If it has changed, an index was out of range in between.
pub(crate) fn faults() -> u32 {
    FAULTS.load(Relaxed)
}

/// See the module.
pub(crate) trait Access<T> {
    /// The element, or the default.
    fn at(&self, index: usize) -> T
    where
        T: Copy + Default;
    /// Replaces the element.
    fn put(&mut self, index: usize, value: T);
    /// Exchanges two elements.
    fn swap_at(&mut self, a: usize, b: usize)
    where
        T: Copy + Default,
    {
        let (first, second) = (self.at(a), self.at(b));
        self.put(a, second);
        self.put(b, first);
    }
    /// Copies as many elements as both slices have. `copy_from_slice` would check the lengths and could panic.
    fn copy_in(&mut self, from: &[T])
    where
        T: Copy;
    /// `len` elements from `start`, or none.
    fn span(&self, start: usize, len: usize) -> &[T];
    /// `len` elements from `start`, or none.
    fn span_mut(&mut self, start: usize, len: usize) -> &mut [T];
}

impl<T> Access<T> for [T] {
    #[inline(always)]
    fn at(&self, index: usize) -> T
    where
        T: Copy + Default,
    {
        debug_assert!(index < self.len(), "read {index} of {}", self.len());
        match self.get(index) {
            Some(element) => *element,
            None => {
                note_fault();
                T::default()
            }
        }
    }

    #[inline(always)]
    fn put(&mut self, index: usize, value: T) {
        debug_assert!(index < self.len(), "write {index} of {}", self.len());
        match self.get_mut(index) {
            Some(element) => *element = value,
            None => note_fault(),
        }
    }

    #[inline(always)]
    fn copy_in(&mut self, from: &[T])
    where
        T: Copy,
    {
        for (to, from) in self.iter_mut().zip(from) {
            *to = *from;
        }
    }

    #[inline(always)]
    fn span(&self, start: usize, len: usize) -> &[T] {
        debug_assert!(start + len <= self.len(), "span {start}+{len} of {}", self.len());
        match self.get(start..).and_then(|tail| tail.get(..len)) {
            Some(span) => span,
            None => {
                note_fault();
                &[]
            }
        }
    }

    #[inline(always)]
    fn span_mut(&mut self, start: usize, len: usize) -> &mut [T] {
        debug_assert!(start + len <= self.len(), "span {start}+{len} of {}", self.len());
        match self.get_mut(start..).and_then(|tail| tail.get_mut(..len)) {
            Some(span) => span,
            None => {
                note_fault();
                &mut []
            }
        }
    }
}

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

    /// Sets the bit and tells whether it was clear.
    #[inline(always)]
    pub(crate) fn set(words: &mut [u32], bit: usize) -> bool {
        let word = words.at(bit / 32);
        words.put(bit / 32, word | 1 << (bit % 32));
        word >> (bit % 32) & 1 == 0
    }

    #[inline(always)]
    pub(crate) fn clear(words: &mut [u32], bit: usize) {
        let word = words.at(bit / 32);
        words.put(bit / 32, word & !(1 << (bit % 32)));
    }

    /// The set bits of one word in ascending order.
    pub(crate) fn of_word(word: u32) -> impl Iterator<Item = usize> {
        let mut rest = word;
        core::iter::from_fn(move || {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            (bit < 32).then_some(bit)
        })
    }

    /// The set bits in ascending order.
    pub(crate) fn ones(words: &[u32]) -> impl Iterator<Item = usize> + '_ {
        (0..).zip(words).flat_map(|(index, word)| of_word(*word).map(move |bit| index * 32 + bit))
    }

    /// How many bits are set.
    #[cfg(any(test, feature = "validate"))]
    pub(crate) fn count(words: &[u32]) -> u32 {
        words.iter().map(|word| word.count_ones()).sum()
    }
}

/// Only without debug assertions, which stop at once and leave nothing to report.
#[cfg(all(test, not(debug_assertions)))]
mod tests {
    use super::*;
    use crate::{Aabb, Boxes, Capacity, Config, Error, Kernels, World, layout};
    use std::{vec, vec::Vec};

    #[repr(C, align(64))]
    #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
    struct Line([u8; 64]);

    /// A step reports an index out of range, and the next step finds all pairs.
    #[test]
    fn an_index_out_of_range_is_an_error_of_the_step() {
        let config = Config::new(Capacity::for_objects(1000)).with_events();
        let mut slab = vec![Line([0; 64]); layout::<u32>(&config).unwrap().bytes / 64];
        let mut world = World::<u32>::new_in(bytemuck::cast_slice_mut(&mut slab), &config).unwrap();
        let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let boxes: Vec<Aabb> = (0..1000u16).map(|k| cube(f32::from(k))).collect();
        let ids: Vec<_> = world.insert_many(Boxes::new(&boxes)).unwrap().collect();
        assert_eq!(world.set_kernels(Kernels::BASELINE).step().unwrap().pairs().len(), 999);
        world.parts.place.put(7, 1 << 30);
        world.set_aabb(ids[7], cube(7.01)).unwrap();
        assert_eq!(world.set_kernels(Kernels::BASELINE).step().err(), Some(Error::InvariantBroken));
        let step = world.set_kernels(Kernels::BASELINE).step().unwrap();
        assert_eq!((step.pairs().len(), step.lost()), (998, &[[6, 7]][..]));
        assert_eq!(world.validate(), Ok(()));
    }
}
