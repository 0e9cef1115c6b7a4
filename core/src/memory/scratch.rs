//! Divides a worker's scratch memory: all that the sweep of a leaf needs, for a bucket of records that stays
//! in the cache.

use super::limits::{BATCH, BUCKET, MASKS_PER_ROUND, ROWS};
use crate::access::Access;
use crate::geometry::record::Record;
use crate::id::{Index, Pair};
use crate::simd::{Row, WINDOW};
use bytemuck::{Pod, Zeroable};

/// The fewest records in a bucket: `scan` needs room for the candidates of one round, or it would lose them.
/// Smaller worlds have no bucket.
const LEAST: usize = 128;
const _: () = assert!(batch(LEAST) + WINDOW >= CANDIDATES_PER_ROUND);

/// Records in the bucket of a world of this capacity, a multiple of 64.
pub(crate) const fn bucket(objects: usize) -> usize {
    let bucket = objects.next_multiple_of(64);
    let bucket = if bucket > LEAST { bucket } else { LEAST };
    if bucket < BUCKET { bucket } else { BUCKET }
}

/// Candidates that are collected before they are tested. Fewer in a small world, where a worker must not take
/// more memory than the world.
const fn batch(bucket: usize) -> usize {
    if bucket < BATCH { bucket } else { BATCH }
}

/// The length of a worker's area in records.
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

/// The most candidates, or pairs, of a round, and what is written behind them.
pub(crate) const CANDIDATES_PER_ROUND: usize = 4 * MASKS_PER_ROUND + 4;

/// The masks that windows gave, and the rows that have further windows.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Lists {
    /// The masks: a bit for each row of a window that may touch.
    pub(crate) bits: [u64; ROWS],
    /// The window of each mask: the position of its record, and of its first row, `at << 16 | first`. The
    /// candidate of bit `k` is `base + k`.
    pub(crate) bases: [u32; ROWS],
    /// The next window of a row that has more neighbours, in the same form.
    pub(crate) open: [u32; ROWS],
    /// Where the neighbours of that row end.
    pub(crate) ends: [u32; ROWS],
}

impl Lists {
    /// The bits and the base of a mask.
    pub(crate) fn mask(&self, index: usize) -> (u64, u32) {
        (self.bits.at(index % ROWS), self.bases.at(index % ROWS))
    }

    pub(crate) fn put_mask(&mut self, index: usize, bits: u64, base: u32) {
        self.bits.put(index % ROWS, bits);
        self.bases.put(index % ROWS, base);
    }
}

/// What a worker has done so far.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Work {
    pub(crate) copies: u64,
    pub(crate) candidates: u64,
    /// Candidates that only the keys could decide.
    pub(crate) tied: u64,
    /// Pairs of records that were not compared.
    pub(crate) spared: u64,
}

impl Work {
    fn add(&mut self, other: &Self) {
        self.copies += other.copies;
        self.candidates += other.candidates;
        self.tied += other.tied;
        self.spared += other.spared;
    }
}

pub(crate) struct Scratch<'s, I> {
    /// What earlier calls did with this area.
    before: &'s mut [Work],
    /// The ghosts of a leaf, or its tiles.
    pub(crate) ghosts: &'s mut [Record],
    pub(crate) leaf_scratch: LeafScratch<'s, I>,
}

/// What the sweep of a bucket works on.
pub(crate) struct LeafScratch<'s, I> {
    /// The bucket, sorted along the sweep axis.
    pub(crate) sorted: &'s mut [Record],
    /// The rows of the bucket, and room for a window behind them.
    pub(crate) rows: &'s mut [Row],
    /// Masks, and rows with further windows.
    pub(crate) lists: &'s mut [Lists],
    /// Positions in the bucket: `low << 16 | high`.
    pub(crate) candidates: &'s mut [u32],
    /// Pairs that wait to be passed on.
    pub(crate) pairs: &'s mut [Pair<I>],
    /// The axes on which all boxes of this sweep have a point in common, a bit each, once a leaf has asked.
    pub(crate) common_axes: Option<u32>,
    pub(crate) work: Work,
}

impl<'s, I: Index> Scratch<'s, I> {
    /// Divides a worker's area.
    pub(crate) fn carve(area: &'s mut [Record], bucket: usize) -> Self {
        let mut rest = area;
        let candidates = batch(bucket) + WINDOW;
        Self {
            before: cut(&mut rest, 1),
            ghosts: cut(&mut rest, bucket),
            leaf_scratch: LeafScratch {
                sorted: cut(&mut rest, bucket),
                rows: cut(&mut rest, bucket + WINDOW),
                lists: cut(&mut rest, 1),
                candidates: cut(&mut rest, candidates),
                pairs: cut(&mut rest, candidates),
                common_axes: None,
                work: Work::default(),
            },
        }
    }

    /// Adds what this call has done to its area.
    pub(crate) fn finish(self) {
        self.before.iter_mut().for_each(|before| before.add(&self.leaf_scratch.work));
    }
}

fn cut<'s, T: Pod>(rest: &mut &'s mut [Record], count: usize) -> &'s mut [T] {
    cut_off(rest, of::<T>(count), count).unwrap_or_default()
}

/// Cuts `count` items off the front, which take so many units. By the layout there is always enough.
pub(super) fn cut_off<'s, U: Pod, T: Pod>(
    rest: &mut &'s mut [U],
    units: usize,
    count: usize,
) -> Option<&'s mut [T]> {
    let (section, left) = core::mem::take(rest).split_at_mut_checked(units)?;
    *rest = left;
    let bytes = bytemuck::try_cast_slice_mut::<U, u8>(section).ok()?.get_mut(..count * size_of::<T>())?;
    bytemuck::try_cast_slice_mut(bytes).ok()
}

/// The sums in the areas of all workers.
fn sums(scratch: &mut [Record], area: usize) -> impl Iterator<Item = &mut Work> {
    scratch.chunks_exact_mut(area.max(1)).flat_map(|mut area| cut(&mut area, 1))
}

/// Sets the sums of all workers to zero.
pub(crate) fn reset(scratch: &mut [Record], area: usize) {
    sums(scratch, area).for_each(|work| *work = Work::default());
}

/// The sum over all workers.
pub(crate) fn work(scratch: &mut [Record], area: usize) -> Work {
    let mut all = Work::default();
    sums(scratch, area).for_each(|work| all.add(work));
    all
}
