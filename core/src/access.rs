//! Slice access that cannot panic.
//!
//! The core promises no panic, so an index is never taken with `[]` where the compiler cannot see that it is in
//! range. By the world's invariants these indices always are; should one not be, reads give the default and
//! writes are dropped. Builds with debug assertions stop there instead, and all tests run in such a build.

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
    /// Copies elements from the front of `from`, as many as both have. Not `copy_from_slice`, whose check of the lengths
    /// can panic.
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
        self.get(index).copied().unwrap_or_default()
    }

    #[inline(always)]
    fn put(&mut self, index: usize, value: T) {
        debug_assert!(index < self.len(), "write {index} of {}", self.len());
        if let Some(element) = self.get_mut(index) {
            *element = value;
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
        self.get(start..).and_then(|tail| tail.get(..len)).unwrap_or_default()
    }

    #[inline(always)]
    fn span_mut(&mut self, start: usize, len: usize) -> &mut [T] {
        debug_assert!(start + len <= self.len(), "span {start}+{len} of {}", self.len());
        self.get_mut(start..).and_then(|tail| tail.get_mut(..len)).unwrap_or_default()
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
    pub(crate) fn count(words: &[u32]) -> u32 {
        words.iter().map(|word| word.count_ones()).sum()
    }
}
