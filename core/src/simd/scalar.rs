//! The level that every CPU has, and the definition of each operation.

use super::{Row, Simd, query_lanes, row_lanes};
use crate::access::Access;
use crate::geometry::key::{KeyBox, value};
use crate::geometry::record::{Frame, GRID_MAX, Record};

/// No more than the target's baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Scalar;

impl Simd for Scalar {
    type Keys = KeyBox;

    type Axis = usize;

    type Query = Row;

    #[inline(always)]
    fn keys(self, bounds: &KeyBox) -> KeyBox {
        *bounds
    }

    #[inline(always)]
    fn above(self, a: KeyBox, b: KeyBox) -> u32 {
        let mut mask = 0;
        for k in 0..3 {
            mask |= u32::from(a.min[k] > b.min[k]) << k;
            mask |= u32::from(a.max[k] > b.max[k]) << (3 + k);
        }
        mask
    }

    #[inline(always)]
    fn axis(self, axis: usize) -> usize {
        axis
    }

    #[inline(always)]
    fn row(self, axis: usize, record: &Record) -> Row {
        row_lanes(axis).map(|lane| (!record.lanes.at(lane) >> 8) as u8)
    }

    #[inline(always)]
    fn query(self, axis: usize, record: &Record) -> Row {
        query_lanes(axis).map(|lane| (record.lanes.at(lane) >> 8) as u8)
    }

    #[inline(always)]
    fn window<const N: usize>(self, rows: &[Row; N], count: usize, query: Row) -> u64 {
        // All four bytes at once. With its high bit set, no byte of a row borrows from the next one.
        const HIGH: u32 = 0x8080_8080;
        let query = u32::from_ne_bytes(query);
        let mut mask = 0;
        for (index, row) in rows.iter().take(count).enumerate() {
            let row = u32::from_ne_bytes(*row);
            let rest = (row | HIGH) - (query & !HIGH);
            // High bits decide where they differ, else the bits below them.
            let inside = (row & !query) | (!(row ^ query) & rest);
            mask |= u64::from(inside & HIGH == HIGH) << index;
        }
        mask
    }

    #[inline(always)]
    fn record(self, frame: &Frame, bounds: KeyBox, tag: u32) -> Record {
        let step = |k: usize, x: i32| {
            let at = (value(x) - frame.origin[k]) * frame.scale[k];
            // The conversion makes zero of NaN (infinity times a scale of zero), as the vectors do.
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
