//! A worker's scratch: everything that a leaf's sweep needs, for a bucket of records that stays in the cache.

use crate::access::Access;
use crate::geometry::record::Record;
use crate::id::{Index, Pair};
use crate::simd::{Row, WINDOW};
use bytemuck::{Pod, Zeroable};

/// The most records that are swept at once; larger leaves are swept tile by tile.
const BUCKET: usize = 2048;

/// The fewest: `rounds` has to find room for the candidates of so many masks, or it would lose them. Smaller worlds have no bucket.
const LEAST: usize = 128;
const _: () = assert!(batch(LEAST) + WINDOW >= ROOM);

/// Records in the bucket of a world of this capacity, in whole blocks of columns.
pub(crate) const fn bucket(objects: usize) -> usize {
    let bucket = objects.next_multiple_of(64);
    let bucket = if bucket > LEAST { bucket } else { LEAST };
    if bucket < BUCKET { bucket } else { BUCKET }
}

/// Candidates that are collected before they are tested.
const fn batch(bucket: usize) -> usize {
    // A worker of a small world must not cost more than the world.
    if bucket < 1024 { bucket } else { 1024 }
}

/// The length of a worker's area.
pub(crate) const fn records<I>(bucket: usize) -> usize {
    if bucket == 0 {
        return 0;
    }
    let candidates = batch(bucket) + WINDOW;
    of::<Work>(1)
        + 2 * bucket
        + of::<Row>(bucket + WINDOW)
        + of::<Lists>(1)
        + of::<u32>(candidates)
        + of::<Pair<I>>(candidates)
}

const fn of<T>(count: usize) -> usize {
    (count * size_of::<T>()).div_ceil(size_of::<Record>())
}

/// Masks that are taken bits from before the room for them is looked at again.
pub(crate) const PART: usize = 32;

/// Candidates, or pairs, of so many masks, and what is written behind them.
pub(crate) const ROOM: usize = 4 * PART + 4;

/// Rows whose windows are compared in one pass. A power of two, so that a list's index needs no check.
pub(crate) const ROWS: usize = 256;

/// What the passes found, and what they have left to do.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Lists {
    /// A bit for each row of a window that may touch.
    pub(crate) bits: [u64; ROWS],
    /// Where the mask belongs: the position whose window it is, and that of the window's first row, `at << 16 | first`. The
    /// candidate of bit `k` is `base + k`.
    pub(crate) bases: [u32; ROWS],
    /// The next window of a row whose run of neighbours goes on, in the same form.
    pub(crate) open: [u32; ROWS],
    /// Where that run ends.
    pub(crate) ends: [u32; ROWS],
}

impl Lists {
    /// The bits and the base of a mask.
    #[inline(always)]
    pub(crate) fn mask(&self, index: usize) -> (u64, u32) {
        (self.bits.at(index % ROWS), self.bases.at(index % ROWS))
    }

    /// Replaces a mask.
    #[inline(always)]
    pub(crate) fn put_mask(&mut self, index: usize, bits: u64, base: u32) {
        self.bits.put(index % ROWS, bits);
        self.bases.put(index % ROWS, base);
    }
}

/// Sums over the leaves that a worker has swept.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Work {
    pub(crate) copies: u64,
    pub(crate) candidates: u64,
    pub(crate) tied: u64,
    /// Makes it as long as two records, between which it stands.
    pub(crate) unused: u64,
}

/// See the module.
pub(crate) struct Scratch<'s, I> {
    /// The sums of earlier jobs in this area.
    work: &'s mut [Work],
    /// Copies so far.
    pub(crate) copies: u64,
    /// Records that come from other leaves, or the tiles of a leaf.
    pub(crate) ghosts: &'s mut [Record],
    pub(crate) leaf_scratch: LeafScratch<'s, I>,
}

/// What the sweep of one bucket works on.
pub(crate) struct LeafScratch<'s, I> {
    /// The bucket, sorted along the sweep axis.
    pub(crate) sorted: &'s mut [Record],
    /// The bucket's rows, and room for a window behind them.
    pub(crate) rows: &'s mut [Row],
    /// Masks, and rows that have further windows.
    pub(crate) lists: &'s mut [Lists],
    /// Positions in the bucket: `low << 16 | high`.
    pub(crate) candidates: &'s mut [u32],
    /// Pairs on their way out.
    pub(crate) pairs: &'s mut [Pair<I>],
    /// Candidates so far.
    pub(crate) tested: u64,
    /// Candidates so far whose records could not tell.
    pub(crate) tied: u64,
}

impl<'s, I: Index> Scratch<'s, I> {
    /// Divides a worker's area.
    pub(crate) fn carve(area: &'s mut [Record], bucket: usize) -> Self {
        let mut rest = area;
        let candidates = batch(bucket) + WINDOW;
        Self {
            work: cut(&mut rest, 1),
            copies: 0,
            ghosts: cut(&mut rest, bucket),
            leaf_scratch: LeafScratch {
                sorted: cut(&mut rest, bucket),
                rows: cut(&mut rest, bucket + WINDOW),
                lists: cut(&mut rest, 1),
                candidates: cut(&mut rest, candidates),
                pairs: cut(&mut rest, candidates),
                tested: 0,
                tied: 0,
            },
        }
    }
}

impl<I> Scratch<'_, I> {
    /// Leaves the sums of this job in its area.
    pub(crate) fn finish(self) {
        if let [work] = self.work {
            work.copies += self.copies;
            work.candidates += self.leaf_scratch.tested;
            work.tied += self.leaf_scratch.tied;
        }
    }
}

/// Cuts `count` items off the straddlers. By the layout's arithmetic there is always enough.
fn cut<'s, T: Pod>(rest: &mut &'s mut [Record], count: usize) -> &'s mut [T] {
    let taken = core::mem::take(rest);
    let (section, left) = taken.split_at_mut_checked(of::<T>(count)).unwrap_or_default();
    *rest = left;
    bytemuck::try_cast_slice_mut(section).ok().and_then(|items| items.get_mut(..count)).unwrap_or_default()
}

/// What stands in the areas of all workers.
fn sums(scratch: &mut [Record], area: usize) -> impl Iterator<Item = &mut Work> {
    scratch.chunks_exact_mut(area.max(1)).flat_map(|mut area| cut(&mut area, 1))
}

/// Sets the sums of all workers to zero.
pub(crate) fn reset(scratch: &mut [Record], area: usize) {
    sums(scratch, area).for_each(|work| *work = Work::default());
}

/// The sums that the workers left in their areas.
pub(crate) fn work(scratch: &mut [Record], area: usize) -> Work {
    sums(scratch, area).fold(Work::default(), |sum, work| Work {
        copies: sum.copies + work.copies,
        candidates: sum.candidates + work.candidates,
        tied: sum.tied + work.tied,
        unused: 0,
    })
}
