//! Hands out blocks of work and areas of scratch memory to workers, each to one at a time.
//!
//! Each block is claimed once, as exclusive slices, by whichever worker comes next. The bounds of the blocks follow
//! from counts alone.

use core::marker::PhantomData;
use core::num::NonZeroU32;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Slices that fall into disjoint parts.
///
/// # Safety
/// Parts with different indices must not overlap, and `part` must be callable from any thread.
pub(crate) unsafe trait Parted: Sync {
    /// Exclusive access to one part.
    type Part;

    /// How many parts there are.
    fn count(&self) -> usize;

    /// One part.
    ///
    /// # Safety
    /// `index < count()`, and no other part with this index may be alive.
    unsafe fn part(&self, index: usize) -> Self::Part;
}

/// A slice in parts of equal length, the last one shorter.
pub(crate) struct Chunks<'a, T> {
    start: *mut T,
    len: usize,
    chunk: usize,
    absent: bool,
    borrow: PhantomData<&'a mut [T]>,
}

impl<'a, T> Chunks<'a, T> {
    pub(crate) fn new(slice: &'a mut [T], chunk: usize) -> Self {
        Self {
            start: slice.as_mut_ptr(),
            len: slice.len(),
            chunk: chunk.max(1),
            absent: false,
            borrow: PhantomData,
        }
    }

    /// The same of a slice that the world may not have: an empty one has any number of empty parts.
    pub(crate) fn optional(slice: &'a mut [T], chunk: usize) -> Self {
        let absent = slice.is_empty();
        Self { absent, ..Self::new(slice, chunk) }
    }
}

// SAFETY: a `Chunks` is an exclusive borrow of a slice of `T: Send`; it reaches other threads only part by part.
unsafe impl<T: Send> Sync for Chunks<'_, T> {}

// SAFETY: part `i` covers `[i * chunk, (i + 1) * chunk)` cut to the slice; these ranges are disjoint.
unsafe impl<'a, T: Send> Parted for Chunks<'a, T> {
    type Part = &'a mut [T];

    fn count(&self) -> usize {
        if self.absent { usize::MAX } else { self.len.div_ceil(self.chunk.max(1)) }
    }

    unsafe fn part(&self, index: usize) -> &'a mut [T] {
        if self.absent {
            return &mut [];
        }
        let start = index * self.chunk;
        let len = self.chunk.min(self.len - start);
        // SAFETY: `index < count()` puts `start..start + len` inside the borrowed slice, and the caller holds
        // no other part with this index, so the range is not aliased.
        unsafe { core::slice::from_raw_parts_mut(self.start.add(start), len) }
    }
}

macro_rules! parted_tuple {
    ($($name:ident $index:tt),+) => {
        // SAFETY: each element of the tuple keeps the promise for its own slice.
        unsafe impl<$($name: Parted),+> Parted for ($($name,)+) {
            type Part = ($($name::Part,)+);

            fn count(&self) -> usize {
                usize::MAX $(.min(self.$index.count()))+
            }

            unsafe fn part(&self, index: usize) -> Self::Part {
                // SAFETY: the caller's promise covers every element: `count()` is the least of theirs.
                unsafe { ($(self.$index.part(index),)+) }
            }
        }
    };
}
parted_tuple!(A 0, B 1);
parted_tuple!(A 0, B 1, C 2);
parted_tuple!(A 0, B 1, C 2, D 3);
parted_tuple!(A 0, B 1, C 2, D 3, E 4);

/// Numbers alone.
// SAFETY: nothing is lent.
unsafe impl Parted for usize {
    type Part = ();

    fn count(&self) -> usize {
        *self
    }

    unsafe fn part(&self, _: usize) {}
}

/// The most shares; if there are more workers, some begin in the same one.
const SHARES: usize = 8;

/// A queue of parts, each claimed once, in as many shares as there are workers. Each worker claims the parts of one share first,
/// in ascending order, and then those that are left in other shares. So a worker mostly gets the same parts in each stage and step,
/// and has them in its cache.
pub(crate) struct BlockQueue<P> {
    parts: P,
    count: u32,
    shares: NonZeroU32,
    /// How many parts of each share have been claimed.
    next: [AtomicU32; SHARES],
    arrived: AtomicU32,
}

impl<P: Parted> BlockQueue<P> {
    /// One share: parts are claimed in ascending order.
    pub(crate) fn new(parts: P) -> Self {
        Self::shared(parts, 1)
    }

    /// A share for each worker.
    pub(crate) fn shared(parts: P, workers: usize) -> Self {
        // Callers have far fewer blocks than this.
        let count = parts.count().min(u32::MAX as usize / 2 / SHARES) as u32;
        let shares = NonZeroU32::new(workers.min(SHARES) as u32).unwrap_or(NonZeroU32::MIN);
        let next = core::array::from_fn(|_| AtomicU32::new(0));
        Self { parts, count, shares, next, arrived: AtomicU32::new(0) }
    }

    /// How many parts there are.
    pub(crate) const fn count(&self) -> usize {
        self.count as usize
    }

    /// How many parts of the first share have been claimed so far.
    pub(crate) fn claimed(&self) -> usize {
        self.next[0].load(Relaxed).min(self.count) as usize
    }

    /// The share that one more worker begins with. The calling thread is the first one, as a rule.
    pub(crate) fn arrive(&self) -> u32 {
        claim_index(&self.arrived, u32::MAX).unwrap_or_default() as u32 % self.shares
    }

    /// The next part of the first share that has some left, and its index; `None` after the last one.
    pub(crate) fn claim(&self) -> Option<(usize, P::Part)> {
        self.claim_from(&mut 0)
    }

    /// The next part of a share, or of the one after it that has some left, and its index; `None` after the last one. Goes on
    /// with that share.
    pub(crate) fn claim_from(&self, share: &mut u32) -> Option<(usize, P::Part)> {
        for _ in 0..self.shares.get() {
            // Without overflow: see `shared`. The shares are disjoint and end at `count`.
            let start = |share: u32| share * self.count / self.shares;
            let (from, to) = (start(*share), start(*share + 1));
            if let Some(index) = self.next.get(*share as usize).and_then(|next| claim_index(next, to - from))
            {
                let index = from as usize + index;
                // SAFETY: `claim_index` returns each index of a share once.
                return Some((index, unsafe { self.parts.part(index) }));
            }
            *share = (*share + 1) % self.shares;
        }
        None
    }
}

/// The next index below `count`; a counter gives each once. Relaxed order is enough: the executor orders memory at
/// the start and the end of a job, and so what the parts hold.
fn claim_index(next: &AtomicU32, count: u32) -> Option<usize> {
    // Without this, late callers could overflow the counter.
    let index = next.load(Relaxed);
    if index >= count {
        return None;
    }
    #[cfg(target_has_atomic = "32")]
    let index = next.fetch_add(1, Relaxed);
    // Without atomic addition steps are serial: no other thread comes between load and store.
    #[cfg(not(target_has_atomic = "32"))]
    next.store(index + 1, Relaxed);
    (index < count).then_some(index as usize)
}

/// Up to 32 areas of scratch memory. A call of a job borrows one while it runs.
pub(crate) struct Pool<'a, T> {
    areas: Chunks<'a, T>,
    busy: AtomicU32,
}

impl<'a, T: Send> Pool<'a, T> {
    /// Areas of `len` items each.
    pub(crate) fn new(memory: &'a mut [T], len: usize) -> Self {
        Self { areas: Chunks::new(memory, len), busy: AtomicU32::new(0) }
    }

    /// How many areas there are.
    pub(crate) fn count(&self) -> usize {
        self.areas.count().min(32)
    }

    /// A free area; `None` if all are in use. The call then leaves the work to others.
    pub(crate) fn borrow(&self) -> Option<Borrowed<'_, 'a, T>> {
        (0..self.count()).find(|&index| self.take(1 << index)).map(|index| Borrowed { pool: self, index })
    }

    #[cfg(target_has_atomic = "32")]
    fn take(&self, bit: u32) -> bool {
        // Acquire: the last borrower's writes come before this one's reads.
        self.busy.fetch_or(bit, core::sync::atomic::Ordering::Acquire) & bit == 0
    }

    #[cfg(not(target_has_atomic = "32"))]
    fn take(&self, bit: u32) -> bool {
        let busy = self.busy.load(Relaxed);
        self.busy.store(busy | bit, Relaxed);
        busy & bit == 0
    }

    fn give_back(&self, bit: u32) {
        #[cfg(target_has_atomic = "32")]
        self.busy.fetch_and(!bit, core::sync::atomic::Ordering::Release);
        #[cfg(not(target_has_atomic = "32"))]
        self.busy.store(self.busy.load(Relaxed) & !bit, Relaxed);
    }
}

/// An area of a [`Pool`], given back on drop.
pub(crate) struct Borrowed<'p, 'a, T: Send> {
    pool: &'p Pool<'a, T>,
    index: usize,
}

impl<T: Send> Borrowed<'_, '_, T> {
    pub(crate) fn area(&mut self) -> &mut [T] {
        // SAFETY: the pool's bit for `index` is ours until drop, and the area's life is tied to this borrow.
        unsafe { self.pool.areas.part(self.index) }
    }
}

impl<T: Send> Drop for Borrowed<'_, '_, T> {
    fn drop(&mut self) {
        self.pool.give_back(1 << self.index);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_claimed_once() {
        let (mut a, mut b) = ([0u8; 10], [0u16; 4]);
        let queue = BlockQueue::new((Chunks::new(&mut a, 3), Chunks::new(&mut b, 1)));
        while let Some((index, (a, b))) = queue.claim() {
            a.fill(index as u8 + 1);
            b.fill(index as u16 + 1);
        }
        assert!(queue.claim().is_none());
        assert_eq!(a, [1, 1, 1, 2, 2, 2, 3, 3, 3, 4]);
        assert_eq!(b, [1, 2, 3, 4]);
    }

    #[test]
    fn every_part_of_all_shares_is_claimed_once() {
        for (workers, len) in [(0, 7), (1, 7), (2, 7), (3, 2), (3, 10), (9, 20), (2, 0)] {
            let mut items = [0u8; 20];
            let queue = BlockQueue::shared(Chunks::new(&mut items[..len], 1), workers);
            let mut shares = [(); 3].map(|()| queue.arrive());
            let mut order = std::vec::Vec::new();
            'all: loop {
                for share in &mut shares {
                    let Some((index, item)) = queue.claim_from(share) else { break 'all };
                    item.iter_mut().for_each(|item| *item += 1);
                    order.push(index);
                }
            }
            assert_eq!(order.len(), len);
            assert!(items[..len].iter().all(|item| *item == 1));
            match (workers, len) {
                (2, 7) => assert_eq!(order, [0, 3, 1, 2, 4, 5, 6]),
                (1, _) => assert!(order.is_sorted()),
                _ => {}
            }
        }
    }

    #[test]
    fn a_pool_lends_each_area_to_one() {
        let mut memory = [1, 2, 3, 4];
        let pool = Pool::new(&mut memory, 2);
        let (mut first, mut second) = (pool.borrow().unwrap(), pool.borrow().unwrap());
        assert!(pool.borrow().is_none());
        assert_eq!((&*first.area(), &*second.area()), (&[1, 2][..], &[3, 4][..]));
        drop(first);
        assert_eq!(pool.borrow().unwrap().area(), [1, 2]);
    }

    /// Small enough for Miri with many seeds. `tests/loom` tries all interleavings.
    #[test]
    fn threads_share_blocks_and_scratch() {
        let (mut items, mut sums) = ([0u32; 23], [0u32; 2]);
        let queue = BlockQueue::new(Chunks::new(&mut items, 4));
        let pool = Pool::new(&mut sums, 1);
        let job = || {
            // More calls than areas: some leave the work to others.
            let Some(mut borrowed) = pool.borrow() else { return };
            while let Some((block, items)) = queue.claim() {
                items.iter_mut().for_each(|item| *item += block as u32 + 1);
                borrowed.area()[0] += 1;
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(job);
            }
            job();
        });
        job();
        assert_eq!(queue.claimed(), 6);
        assert!(items.iter().enumerate().all(|(at, &item)| item as usize == at / 4 + 1));
        assert_eq!(sums.iter().sum::<u32>(), 6);
    }
}
