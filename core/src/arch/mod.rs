//! What depends on the CPU, and all the `unsafe` of the core.
//!
//! A phase is written once, as a [`Phase`] that is generic over [`Simd`]; [`Kernels`](crate::Kernels) runs it
//! compiled for one level. A level is a handful of operations on bytes, records and boxes, so that another CPU
//! costs one small file. All levels give the same bytes.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
pub(crate) mod claim;
pub(crate) mod scalar;
pub(crate) mod shared;

use crate::key::KeyBox;
use crate::tree::{Frame, Record};

/// What two records of one leaf have to do with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Contact {
    /// They touch on all axes, as far as the grid can tell. Conservative: apart is certain.
    pub(crate) touches: bool,
    /// Some two coordinates share a step of the grid, so that only the exact boxes can tell.
    pub(crate) tied: bool,
}

/// The operations of one instruction set. A value of the type is the proof that the CPU has it.
pub(crate) trait Simd: Copy + Send + Sync {
    /// Rows in a block of columns, and so in a mask: a power of two up to 64.
    const ROWS: usize;

    /// Four bytes that rows are compared with.
    type Query: Copy;

    /// Prepares a comparison.
    fn query(self, bytes: [u8; 4]) -> Self::Query;

    /// The rows of a block of four columns, one after another, whose bytes are all at most the query's: bit `i`
    /// for row `i`. The block has `4 * ROWS` bytes; a shorter one has no rows.
    fn rows_at_most(self, block: &[u8], query: Self::Query) -> u64;

    /// Compares two records.
    fn contact(self, a: &Record, b: &Record) -> Contact;

    /// Which of four records touch the one whose [`limit`] this is: bit `i` for record `i`.
    fn touching(self, records: &[Record; 4], limit: Record) -> u32;

    /// A box on the grid of a leaf.
    fn record(self, frame: &Frame, bounds: &KeyBox, tag: u32) -> Record;
}

/// What another record's lanes must not exceed for it to touch this one: the maxima, then the complemented minima.
/// The tag's lanes exclude nothing.
#[inline(always)]
pub(crate) fn limit(record: &Record) -> Record {
    let [x0, y0, z0, x1, y1, z1] = record.lanes.map(|lane| !lane);
    Record { lanes: [x1, y1, z1, x0, y0, z0], tag: u32::MAX }
}

/// A piece of a step that is compiled once for each level.
pub(crate) trait Phase {
    /// What it returns.
    type Output;
    /// Does the work. Inline, so that it takes on the instruction set of its caller.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}
