//! The pair set that everyone is checked against, from a sweep that shares no code with trisap or a peer, and
//! a digest by which sets of pairs are compared without sorting them.

use crate::recording::Padded;

/// Whether two closed boxes share a point.
pub(crate) fn overlap(a: &Padded, b: &Padded) -> bool {
    (0..3).all(|k| a[k] <= b[k + 4] && b[k] <= a[k + 4])
}

/// A set of pairs, whatever their order: how many, and the sum of their hashes. A pair told twice, left out or
/// put in by mistake changes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Digest {
    pub(crate) count: u64,
    sum: u64,
}

impl Digest {
    pub(crate) fn add(&mut self, pair: [u32; 2]) {
        self.count = self.count.wrapping_add(1);
        self.sum = self.sum.wrapping_add(hash(pair));
    }

    pub(crate) fn remove(&mut self, pair: [u32; 2]) {
        self.count = self.count.wrapping_sub(1);
        self.sum = self.sum.wrapping_sub(hash(pair));
    }
}

fn hash([a, b]: [u32; 2]) -> u64 {
    let mut x = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
    // The finaliser of SplitMix64: a bijection, so that different pairs have different hashes.
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// All overlaps of `boxes` that are asked for: strips along y, each swept along x; a pair is counted in the strip in which
/// the higher of its two minima lies.
pub(crate) fn pairs(boxes: &[Padded], asked: impl Fn(u32, u32) -> bool) -> Digest {
    let (low, high) = boxes
        .iter()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), b| (low.min(b[1]), high.max(b[5])));
    let strips = (boxes.len() as f32).cbrt().ceil();
    let width = ((high - low) / strips).max(f32::MIN_POSITIVE);
    // Monotone, so that the order of two coordinates is never turned round.
    let strip = |y: f32| ((y - low) / width).min(strips - 1.0) as usize;

    let mut members = vec![Vec::new(); strips as usize];
    for (id, b) in boxes.iter().enumerate() {
        members[strip(b[1])..=strip(b[5])].iter_mut().for_each(|m| m.push(id as u32));
    }
    let mut digest = Digest::default();
    for (at, ids) in members.iter_mut().enumerate() {
        ids.sort_unstable_by(|&a, &b| boxes[a as usize][0].total_cmp(&boxes[b as usize][0]));
        for (rank, &a) in ids.iter().enumerate() {
            let one = &boxes[a as usize];
            let candidates = ids[rank + 1..].iter().take_while(|&&b| boxes[b as usize][0] <= one[4]);
            for &b in candidates {
                let other = &boxes[b as usize];
                if overlap(one, other) && strip(one[1].max(other[1])) == at && asked(a, b) {
                    digest.add([a, b]);
                }
            }
        }
    }
    digest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_brute_force() {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let boxes: Vec<Padded> = (0..400)
            .map(|i| {
                let min: [f32; 3] = std::array::from_fn(|_| (next() * 8.0).floor());
                let size = if i % 50 == 0 { 9.0 } else { 1.0 };
                let max = min.map(|x| x + (next() * size).round());
                [min[0], min[1], min[2], 0.0, max[0], max[1], max[2], 0.0]
            })
            .collect();
        let mut expected = Digest::default();
        for a in 0..boxes.len() {
            for b in 0..a {
                if overlap(&boxes[a], &boxes[b]) {
                    expected.add([a as u32, b as u32]);
                }
            }
        }
        assert!(expected.count > 1000);
        assert_eq!(pairs(&boxes, |_, _| true), expected);
    }
}
