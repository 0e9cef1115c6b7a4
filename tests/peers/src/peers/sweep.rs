//! The honest baseline: a radix sort on the widest axis and an AVX2 sweep, one thread, no tree, no memory of
//! the last frame. What a careful programmer writes in an afternoon.

use super::{Crowd, Entry, Output, Peer};
use crate::recording::Padded;
use std::arch::x86_64::*;

pub(crate) fn entry() -> Entry {
    Entry {
        name: "radix sort + AVX2 sweep",
        setup: "LSD radix sort on the widest axis, sweep of eight boxes at a time",
        events: false,
        fat: false,
        parallel: false,
        crowd: Crowd::Unsuited,
        start: if is_x86_feature_detected!("avx2") {
            Ok(|setting| Box::new(Sweep::new(setting.boxes)))
        } else {
            Err("this CPU has no AVX2")
        },
    }
}

/// Boxes in one vector.
const LANES: usize = 8;
const DIGIT: u32 = 11;

#[derive(Default)]
struct Sweep {
    boxes: Vec<Padded>,
    /// The axes, the widest (the sort axis) first.
    axes: [usize; 3],
    keys: [Vec<(u32, u32)>; 2],
    /// Sorted boxes by column: minima, then maxima, in the order of `axes`; `LANES` that match nothing follow.
    columns: [Vec<f32>; 6],
    ids: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl Sweep {
    fn new(boxes: &[Padded]) -> Self {
        let n = boxes.len();
        let spread = |k: usize| {
            let mean = boxes.iter().map(|b| f64::from(b[k])).sum::<f64>() / n as f64;
            boxes.iter().map(|b| (f64::from(b[k]) - mean).powi(2)).sum::<f64>()
        };
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| spread(b).total_cmp(&spread(a)));
        Self {
            boxes: boxes.to_vec(),
            axes,
            keys: [vec![(0, 0); n], vec![(0, 0); n]],
            columns: std::array::from_fn(|_| vec![f32::INFINITY; n + LANES]),
            ids: vec![0; n + LANES],
            pairs: Vec::new(),
        }
    }

    /// Sorts by the minimum on the first axis, three passes of eleven bits.
    fn sort(&mut self) {
        let mut counts = [[0u32; 1 << DIGIT]; 3];
        let digit = |key: u32, pass: usize| (key >> (DIGIT * pass as u32)) as usize & ((1 << DIGIT) - 1);
        for (id, b) in self.boxes.iter().enumerate() {
            // -0 becomes +0; then the bits of a float, made monotone.
            let bits = (b[self.axes[0]] + 0.0).to_bits();
            let key = bits ^ ((bits as i32 >> 31) as u32 | 1 << 31);
            self.keys[0][id] = (key, id as u32);
            (0..3).for_each(|pass| counts[pass][digit(key, pass)] += 1);
        }
        for (pass, counts) in counts.iter_mut().enumerate() {
            let mut start = 0;
            for count in counts.iter_mut() {
                start += std::mem::replace(count, start);
            }
            let [a, b] = &mut self.keys;
            let (from, to) = if pass % 2 == 0 { (a, b) } else { (b, a) };
            for &(key, id) in from.iter() {
                let at = &mut counts[digit(key, pass)];
                to[*at as usize] = (key, id);
                *at += 1;
            }
        }
        for (rank, &(_, id)) in self.keys[1].iter().enumerate() {
            let b = &self.boxes[id as usize];
            self.ids[rank] = id;
            for (k, &axis) in self.axes.iter().enumerate() {
                self.columns[k][rank] = b[axis];
                self.columns[k + 3][rank] = b[axis + 4];
            }
        }
    }

    #[target_feature(enable = "avx2")]
    fn sweep(&mut self) {
        self.pairs.clear();
        let n = self.boxes.len();
        let [min_x, min_y, min_z, max_x, max_y, max_z] = &self.columns;
        for i in 0..n {
            let all = |column: &[f32]| _mm256_set1_ps(column[i]);
            let (x, low_y, low_z, high_y, high_z) =
                (all(max_x), all(min_y), all(min_z), all(max_y), all(max_z));
            let mut j = i + 1;
            while min_x[j] <= max_x[i] {
                // SAFETY: `j < n`, because the columns hold infinity from `n` on, and they go on for `LANES` more.
                let load = |column: &[f32]| unsafe { _mm256_loadu_ps(column.as_ptr().add(j)) };
                let y = _mm256_and_ps(
                    _mm256_cmp_ps::<_CMP_LE_OQ>(load(min_y), high_y),
                    _mm256_cmp_ps::<_CMP_LE_OQ>(low_y, load(max_y)),
                );
                let z = _mm256_and_ps(
                    _mm256_cmp_ps::<_CMP_LE_OQ>(load(min_z), high_z),
                    _mm256_cmp_ps::<_CMP_LE_OQ>(low_z, load(max_z)),
                );
                let x = _mm256_cmp_ps::<_CMP_LE_OQ>(load(min_x), x);
                let mut hits = _mm256_movemask_ps(_mm256_and_ps(x, _mm256_and_ps(y, z))) as u32;
                while hits != 0 {
                    self.pairs.push([self.ids[i], self.ids[j + hits.trailing_zeros() as usize]]);
                    hits &= hits - 1;
                }
                j += LANES;
                if j >= n {
                    break;
                }
            }
        }
    }
}

impl Peer for Sweep {
    fn prepare(&mut self, boxes: &[Padded]) {
        self.boxes.copy_from_slice(boxes);
    }

    fn frame(&mut self) {
        self.sort();
        // SAFETY: a sweep is started only where the CPU has AVX2.
        unsafe { self.sweep() }
    }

    fn output(&mut self) -> Output<'_> {
        Output::Pairs(&self.pairs)
    }
}
