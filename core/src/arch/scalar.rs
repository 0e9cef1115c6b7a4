//! The level that every CPU has. Also the definition of what each operation means.

use super::{Contact, Simd};
use crate::key::{KeyBox, value};
use crate::tree::{Frame, GRID_MAX, Record};

/// No more than the target's baseline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scalar;

impl Simd for Scalar {
    const ROWS: usize = 16;

    type Query = [u8; 4];

    #[inline(always)]
    fn query(self, bytes: [u8; 4]) -> [u8; 4] {
        bytes
    }

    #[inline(always)]
    fn rows_at_most(self, block: &[u8], query: [u8; 4]) -> u64 {
        let Some((block, _)) = block.split_first_chunk::<64>() else { return 0 };
        let mut mask = 0;
        for row in 0..16 {
            let inside = block[row] <= query[0]
                && block[16 + row] <= query[1]
                && block[32 + row] <= query[2]
                && block[48 + row] <= query[3];
            mask |= u64::from(inside) << row;
        }
        mask
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        let (mut touches, mut tied) = (true, false);
        for k in 0..6 {
            // b's maximum against a's minimum, then b's complemented minimum against a's complemented maximum.
            let limit = !b.lanes[(k + 3) % 6];
            touches &= a.lanes[k] <= limit;
            tied |= a.lanes[k] == limit;
        }
        Contact { touches, tied }
    }

    #[inline(always)]
    fn touching(self, records: &[Record; 4], limit: Record) -> u32 {
        let mut mask = 0;
        for (index, record) in records.iter().enumerate() {
            let mut inside = true;
            for k in 0..6 {
                inside &= record.lanes[k] <= limit.lanes[k];
            }
            mask |= u32::from(inside) << index;
        }
        mask
    }

    #[inline(always)]
    fn record(self, frame: &Frame, bounds: &KeyBox, tag: u32) -> Record {
        let step = |k: usize, x: i32| {
            let at = (value(x) - frame.origin[k]) * frame.scale[k];
            // The cast takes NaN (an infinite coordinate times a zero scale) to zero, as the vectors do.
            at.clamp(0.0, GRID_MAX) as u16
        };
        let mut lanes = [0; 6];
        for k in 0..3 {
            lanes[k] = step(k, bounds.min[k]);
            lanes[3 + k] = !step(k, bounds.max[k]);
        }
        Record { lanes, tag }
    }
}
