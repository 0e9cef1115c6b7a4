//! Hands out blocks of work and areas of scratch memory: each is claimed once, as exclusive slices, by
//! whichever worker comes next. The bounds of the blocks follow from counts and the configuration alone.

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
    /// 0 if there is no slice.
    chunk: usize,
    borrow: PhantomData<&'a mut [T]>,
}

impl<'a, T> Chunks<'a, T> {
    pub(crate) fn new(slice: &'a mut [T], chunk: usize) -> Self {
        Self { start: slice.as_mut_ptr(), len: slice.len(), chunk: chunk.max(1), borrow: PhantomData }
    }

    /// The same of a slice that the world may not have: an empty one has any number of empty parts.
    pub(crate) fn optional(slice: &'a mut [T], chunk: usize) -> Self {
        let chunk = if slice.is_empty() { 0 } else { chunk.max(1) };
        Self { chunk, ..Self::new(slice, 1) }
    }
}

// SAFETY: a `Chunks` is an exclusive borrow of a slice of `T: Send`; other threads get it only part by part.
unsafe impl<T: Send> Sync for Chunks<'_, T> {}

// SAFETY: part `i` covers `[i * chunk, (i + 1) * chunk)` cut to the slice; these ranges are disjoint.
unsafe impl<'a, T: Send> Parted for Chunks<'a, T> {
    type Part = &'a mut [T];

    fn count(&self) -> usize {
        if self.chunk == 0 { usize::MAX } else { self.len.div_ceil(self.chunk) }
    }

    unsafe fn part(&self, index: usize) -> &'a mut [T] {
        if self.chunk == 0 {
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

#[cfg(feature = "validate")]
static CLAIMS: core::sync::atomic::AtomicPtr<fn()> =
    core::sync::atomic::AtomicPtr::new(core::ptr::null_mut());

/// For tests, which run many workers in turns: from now on each claim calls a function first.
#[cfg(feature = "validate")]
#[doc(hidden)]
pub fn before_claims(call: &'static fn()) {
    CLAIMS.store(core::ptr::from_ref(call).cast_mut(), core::sync::atomic::Ordering::Release);
}

/// The most shares; if there are more workers, some begin in the same one.
const SHARES: usize = 8;

/// A queue of parts, each claimed once, in as many shares as there are workers. Each worker claims the parts
/// of one share first, in ascending order, and then blocks that are left in other shares. So a worker mostly
/// gets the same parts in each stage and step, and has them in its cache.
pub(crate) struct BlockQueue<P> {
    parts: P,
    count: u32,
    shares: NonZeroU32,
    /// How many parts of each share have been claimed.
    next: [AtomicU32; SHARES],
    arrived: AtomicU32,
}

impl<P: Parted> BlockQueue<P> {
    /// A share for each worker. Parts of one share are claimed in ascending order.
    pub(crate) fn new(parts: P, workers: usize) -> Self {
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

    /// The share that one more worker begins with. The calling thread is the first one, as a rule.
    pub(crate) fn arrive(&self) -> u32 {
        claim_index(&self.arrived, u32::MAX).unwrap_or_default() as u32 % self.shares
    }

    /// The next part of a share, or of the one after it that has some left, and its index; `None` after the
    /// last one. Goes on with that share.
    pub(crate) fn claim_from(&self, share: &mut u32) -> Option<(usize, P::Part)> {
        #[cfg(feature = "validate")]
        // SAFETY: it is null or a reference that lasts.
        if let Some(call) = unsafe { CLAIMS.load(core::sync::atomic::Ordering::Acquire).as_ref() } {
            call();
        }
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

/// The next index below `count`; a counter gives each once. Relaxed order is enough: the executor orders
/// memory at the start and the end of a job, and so what the parts hold.
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
