//! Slice access that cannot panic.
//!
//! The core never panics. So it takes no index with `[]` where the compiler cannot see that the index is in range.
//! The invariants of a world keep every index in range. If one is not, a read gives the default, a write does
//! nothing, and the next step reports [`Error::InvariantBroken`](crate::Error::InvariantBroken), since a pair may be
//! missing. Builds with debug assertions stop at once instead; nearly all tests run in such a build.
//!
//! This code has no world at hand. So it notes where the slice is, and each world looks for its own slab.

use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering::Relaxed};

/// How many indices were out of range, in all worlds of the process.
static FAULTS: AtomicU32 = AtomicU32::new(0);
/// The addresses of the last slices. A world's own is overwritten only if others break at the same time.
static SLICES: [AtomicUsize; SLICES_KEPT] = [const { AtomicUsize::new(0) }; SLICES_KEPT];
const SLICES_KEPT: usize = if cfg!(feature = "large") { 128 } else { 4 };

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
    if let Some(last) = SLICES.get(count as usize % SLICES_KEPT) {
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

    /// Whether an index into the slab was out of range since the last call.
    pub(crate) fn sees_fault(&mut self) -> bool {
        let count = FAULTS.load(Relaxed);
        let new = count.wrapping_sub(core::mem::replace(&mut self.known, count));
        let slices = (1..=new.min(SLICES_KEPT as u32)).map(|back| count.wrapping_sub(back) as usize);
        let mut slices = slices.filter_map(|number| SLICES.get(number % SLICES_KEPT));
        slices.any(|slice| self.slab.contains(&slice.load(Relaxed)))
    }
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
                note_fault(self.as_ptr().addr());
                T::default()
            }
        }
    }

    #[inline(always)]
    fn put(&mut self, index: usize, value: T) {
        debug_assert!(index < self.len(), "write {index} of {}", self.len());
        match self.get_mut(index) {
            Some(element) => *element = value,
            None => note_fault(self.as_ptr().addr()),
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
                note_fault(self.as_ptr().addr());
                &[]
            }
        }
    }

    #[inline(always)]
    fn span_mut(&mut self, start: usize, len: usize) -> &mut [T] {
        debug_assert!(start + len <= self.len(), "span {start}+{len} of {}", self.len());
        let slice = self.as_ptr().addr();
        match self.get_mut(start..).and_then(|tail| tail.get_mut(..len)) {
            Some(span) => span,
            None => {
                note_fault(slice);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aabb, Boxes, Capacity, Config, Error, Kernels, World, layout};
    use std::collections::BTreeSet;
    use std::{vec, vec::Vec};

    #[repr(C, align(64))]
    #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
    struct Line([u8; 64]);

    const COUNT: u32 = 6000;
    const CONFIG: Config = Config::new(Capacity::for_objects(COUNT)).with_events().with_filters();

    fn cube(x: f32) -> Aabb {
        Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
    }

    fn slab() -> Vec<Line> {
        vec![Line([0; 64]); layout::<u32>(&CONFIG).unwrap().bytes / 64]
    }

    /// A row of cubes, each of which overlaps the next one.
    fn row(slab: &mut [Line]) -> World<'_> {
        let mut world = World::<u32>::new_in(bytemuck::cast_slice_mut(slab), &CONFIG).unwrap();
        let boxes: Vec<Aabb> = (0..COUNT).map(|k| cube(k as f32)).collect();
        assert_eq!(world.insert_many(Boxes::new(&boxes)).unwrap().count(), 6000);
        world.set_kernels(Kernels::BASELINE);
        assert_eq!(world.step().unwrap().pairs().len(), 5999);
        world
    }

    /// A step in which many indices are out of range.
    fn faulty_step(world: &mut World<'_>) {
        let slice = world.parts.order[2].as_ptr().addr();
        let rule = |_, _| {
            note_fault(slice);
            true
        };
        assert_eq!(world.with_rule(&rule).step().err(), Some(Error::InvariantBroken));
        assert_eq!((world.pairs().len(), world.found().len(), world.lost().len()), (0, 0, 0));
        assert_eq!(world.validate(), Ok(()));
    }

    /// The step after a fault finds all pairs, and tells those that came and went since the last complete step: few
    /// objects have moved, or all but some.
    #[test]
    fn events_are_relative_to_the_last_step_without_a_fault() {
        for moved in [3, COUNT - 9] {
            let mut slab = slab();
            let mut world = row(&mut slab);
            let before = world.step().unwrap().pairs().to_vec();
            for slot in 0..moved {
                let x = [-2.0, 0.125, 1.25][slot as usize % 3];
                world.set_aabb(world.id_at(slot).unwrap(), cube(x + slot as f32)).unwrap();
            }
            faulty_step(&mut world);
            let step = world.step().unwrap();
            let pairs = step.pairs();
            let set = |pairs: &[[u32; 2]]| pairs.iter().copied().collect::<BTreeSet<_>>();
            assert_eq!(set(step.found()), &set(pairs) - &set(&before));
            assert_eq!(set(step.lost()), &set(&before) - &set(pairs));
            assert_eq!(step.lost().len(), set(step.lost()).len(), "no pair is lost twice");
            assert!(!step.found().is_empty() && !step.lost().is_empty());
            assert_eq!(world.validate(), Ok(()));
        }
    }

    /// Worlds with faults, on the same thread and on another, do not disturb a world.
    #[test]
    fn a_fault_is_a_matter_of_one_world() {
        let (mut good, mut other, mut parallel) = (slab(), slab(), slab());
        let mut good = row(&mut good);
        let done = AtomicU32::new(0);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while done.load(Relaxed) == 0 {
                    let mut world = row(&mut parallel);
                    world.set_aabb(world.id_at(7).unwrap(), cube(7.25)).unwrap();
                    faulty_step(&mut world);
                }
            });
            for frame in 1..100u16 {
                let mut other = row(&mut other);
                other.set_aabb(other.id_at(7).unwrap(), cube(7.25)).unwrap();
                faulty_step(&mut other);
                let id = good.id_at(u32::from(frame) * 3).unwrap();
                good.set_aabb(id, cube(-2.0 - f32::from(frame) * 3.0)).unwrap();
                assert!(good.step().is_ok_and(|step| step.lost().len() == 2), "frame {frame}");
            }
            done.store(1, Relaxed);
        });
    }

    /// Only without debug assertions, which stop at once and leave nothing to report.
    #[cfg(not(debug_assertions))]
    #[test]
    fn an_index_out_of_range_is_an_error_of_the_step() {
        let mut slab = slab();
        let mut world = row(&mut slab);
        world.parts.place.put(7, 1 << 30);
        world.set_aabb(world.id_at(7).unwrap(), cube(7.01)).unwrap();
        assert_eq!(world.step().err(), Some(Error::InvariantBroken));
        let step = world.step().unwrap();
        assert_eq!((step.pairs().len(), step.lost()), (5998, &[[6, 7]][..]));
        assert_eq!(world.validate(), Ok(()));
    }
}
