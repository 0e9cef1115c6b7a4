//! Compares the operations of a level with the scalar ones, on random operands of which half are made to touch.
//!
//! Steps of worlds run the same operations, but do not reach all of their corners. It is a function of the crate
//! under a feature, so that it can also run in an emulator without std: see `tests/emulated`.

#[cfg(test)]
#[path = "coordinates.rs"]
mod coordinates;

use super::{EIGHT, Row, Simd, WINDOW, limit, scalar::Scalar};
use crate::geometry::aabb::Aabb;
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, key, value};
use crate::geometry::line::{Line, Walk};
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use crate::memory::limits::PAIRS_TOGETHER;
use crate::query::Cast;
use crate::simd::kernels::{Kernels, run};

impl Kernels {
    /// Names the operations whose result differs from the scalar one, once for each time in so many rounds.
    #[doc(hidden)]
    pub fn disagreements(self, seed: u64, rounds: u32, tell: &mut dyn FnMut(&'static str)) {
        let rounds = Rounds { random: Random(seed), rounds, tell };
        run!(self, |simd| play(simd, rounds));
    }
}

struct Rounds<'t> {
    random: Random,
    rounds: u32,
    tell: &'t mut dyn FnMut(&'static str),
}

#[inline(always)]
fn play<S: Simd>(simd: S, mut rounds: Rounds<'_>) {
    for _ in 0..rounds.rounds {
        boxes(simd, &mut rounds);
        four_boxes(simd, &mut rounds);
        predictions(simd, &mut rounds);
        rows(simd, &mut rounds);
        records(simd, &mut rounds);
        candidates::<S, u16>(simd, &mut rounds);
        candidates::<S, u32>(simd, &mut rounds);
        overlaps::<S, u16>(simd, &mut rounds);
        overlaps::<S, u32>(simd, &mut rounds);
        lines(simd, &mut rounds);
    }
}

impl Rounds<'_> {
    fn check<const N: usize>(&mut self, results: [(&'static str, bool); N]) {
        results.into_iter().filter(|(_, same)| !same).for_each(|(name, _)| (self.tell)(name));
    }
}

#[inline(always)]
fn boxes<S: Simd>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let (a, mut b) = (random.bounds(), random.bounds());
    if random.below(2) == 0 {
        // Sides in common.
        b = KeyBox { min: a.min, max: [a.max[0], b.max[1].max(a.min[1]), b.max[2].max(a.min[2])] };
    }
    let (keys, other) = (simd.keys(&a), simd.keys(&b));
    let frame = random.frame();
    let tag = random.bits() as u32;
    rounds.check([
        ("above", simd.above(keys, other) == Scalar.above(a, b)),
        ("overlap", simd.overlap(&a, &b) == Scalar.overlap(&a, &b)),
        ("record", simd.record(&frame, keys, tag) == Scalar.record(&frame, a, tag)),
    ]);
}

#[inline(always)]
fn four_boxes<S: Simd>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let mut boxes = [(); 4].map(|()| random.bounds().to_aabb());
    if random.below(4) == 0 {
        // Bad, perhaps.
        boxes[random.below(4)].min[random.below(3)] = random.float();
        boxes[random.below(4)].max[random.below(3)] = random.float();
    }
    let keys = boxes.each_ref().map(KeyBox::from_aabb);
    let old = keys.map(|keys| {
        match random.below(16) {
            0..4 => Some(random.bounds()),
            4 => Some(KeyBox::free(random.bits() as u32)),
            6 => keys.map(|keys| keys.disabled().0),
            // One of six keys is another one.
            5 => keys.map(|mut keys| {
                keys.max[random.below(3)] = POSITIVE_INFINITY;
                keys
            }),
            _ => keys,
        }
        .unwrap_or_default()
    });
    let mut new = [KeyBox::EMPTY; 4];
    let padded = boxes.map(|Aabb { min: [a, b, c], max: [d, e, f] }| [a, b, c, f32::NAN, d, e, f]);
    let four = match random.below(2) {
        0 => Boxes::new(&boxes),
        _ => Boxes::strided(bytemuck::bytes_of(&padded), 28, 16).unwrap_or(Boxes::new(&boxes)),
    };
    let (all, near) = (random.below(2) == 0, keys.map(|keys| keys.unwrap_or_default()));
    let held = near.map(|near| match random.below(8) {
        _ if all => KeyBox::ALL,
        0 => random.bounds(),
        1 => KeyBox { max: near.max.map(|k| k.saturating_add(random.below(3) as i32 - 1)), ..near },
        2 => KeyBox { min: near.min.map(|k| k.saturating_sub(random.below(3) as i32 - 1)), ..near },
        _ => near,
    });
    let found = simd.encode_four(four, if all { None } else { Some(&held) }, &old, &mut new);
    let are_held = keys.iter().zip(&held).all(|(keys, held)| keys.is_some_and(|keys| held.contains(&keys)));
    let good = keys.iter().all(Option::is_some) && !old.iter().any(KeyBox::is_empty);
    let others = (0..4).map(|k| u32::from(keys[k] != Some(old[k])) << k).sum();
    let expected = if good && are_held && S::ENCODES_FOUR { Some(others) } else { None };
    let same = expected.is_none() || new.map(Some) == keys;
    rounds.check([("encode_four", found == expected && same)]);
}

#[inline(always)]
fn predictions<S: Simd>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let now = [(); 4].map(|()| random.bounds());
    // Some have gone a little way, on some axes.
    let old = now.map(|now| {
        let way = [(); 3].map(|()| (random.below(9) as f32 - 4.0) * [0.0, 0.01, 0.25, 1e30][random.below(4)]);
        let back = |sides: [i32; 3]| [0, 1, 2].map(|k| key(value(sides[k]) - way[k]));
        if random.below(4) == 0 { random.bounds() } else { KeyBox { min: back(now.min), max: back(now.max) } }
    });
    let margins = [(); 4].map(|()| [0.0, 0.125, 3.0, 1e-38, 1e30, f32::MAX][random.below(6)]);
    let (predicts, mut made) = (random.below(4) != 0, [KeyBox::EMPTY; 4]);
    simd.predicted(&now, &old, &margins, predicts, &mut made);
    let same = (0..4).all(|k| made[k] == KeyBox::predicted(&now[k], &old[k], margins[k], predicts));
    let (outer, inner) = if predicts { (&made, &now) } else { (&now, &old) };
    let inside = (0..4).map(|k| u32::from(outer[k].contains(&inner[k])) << k).sum();
    rounds.check([("predicted", same), ("inside", simd.inside(outer, inner) == inside)]);
}

#[inline(always)]
fn rows<S: Simd>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let record = random.record();
    let axis = random.below(3);
    let least = Scalar.query(axis, &record);
    let mut rows = [Row::default(); WINDOW];
    for row in &mut rows {
        // At least the query's; in about every second row one byte is less.
        *row = least.map(|byte| byte + random.below(256 - usize::from(byte)) as u8);
        let k = random.below(4);
        row[k] = row[k].min(least[k]).saturating_sub(random.below(2) as u8);
    }
    let count = random.below(WINDOW + 9);
    let query = simd.query(simd.axis(axis), &record);
    let half: &[Row; WINDOW / 2] = rows.first_chunk().unwrap();
    rounds.check([
        ("row", simd.row(simd.axis(axis), &record) == Scalar.row(axis, &record)),
        ("window", simd.window(&rows, count, query) == Scalar.window(&rows, count, least)),
        ("half_window", simd.window(half, count, query) == Scalar.window(half, count, least)),
    ]);
}

#[inline(always)]
fn records<S: Simd>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let eight = [(); EIGHT].map(|()| random.record());
    let [a, b, ..] = eight;
    let limit = limit(&random.record());
    rounds.check([
        ("contact", simd.contact(&a, &b) == Scalar.contact(&a, &b)),
        ("touching", simd.touching(&eight, limit) == Scalar.touching(&eight, limit)),
    ]);
}

#[inline(always)]
fn candidates<S: Simd, I: Index>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    const RECORDS: usize = 40;
    // Slots are less than what an index holds.
    let slots = if size_of::<I>() == 2 { !Record::SLOT | 0xffff } else { u32::MAX };
    let sorted = [(); RECORDS].map(|()| {
        let record = random.record();
        Record { tag: record.tag & slots, ..record }
    });
    let count = random.below(WINDOW);
    let mut lists = [[(); WINDOW].map(|()| (random.below(RECORDS) << 16 | random.below(RECORDS)) as u32); 2];
    let mut pairs = [[Pair::<I>::default(); WINDOW]; 2];
    let ([list, expected_list], [kept, expected_kept]) = (&mut lists, &mut pairs);
    let tested = simd.test_candidates(&sorted, &mut list[..count], &mut kept[..count]);
    let expected = Scalar.test_candidates(&sorted, &mut expected_list[..count], &mut expected_kept[..count]);
    let test_candidates = (tested.found, tested.tied) == (expected.found, expected.tied)
        && kept[..tested.found] == expected_kept[..tested.found]
        && list[..tested.tied] == expected_list[..tested.tied];
    // Of 40 records a window reaches up to 64, some of them behind the end.
    let base = (random.below(RECORDS) << 16 | random.below(RECORDS / 2)) as u32;
    let bits = random.bits() & random.bits() & if random.below(4) == 0 { u64::MAX } else { 0xf_ffff };
    let mut fours = [[Pair::<I>::default(); 4]; 2];
    let [kept, expected_kept] = &mut fours;
    let found = simd.four(&sorted, base, bits, kept);
    let four = found == Scalar.four(&sorted, base, bits, expected_kept)
        && kept.iter().zip(expected_kept).take(found.unwrap_or_default()).all(|(a, b)| a == b);
    rounds.check([("test candidates", test_candidates), ("four", four)]);
}

#[inline(always)]
fn overlaps<S: Simd, I: Index>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let mut boxes = [(); 99].map(|()| random.bounds());
    boxes[random.below(99)] = KeyBox::EMPTY;
    // The last one is rarely asked for.
    let most = 98 + usize::from(random.below(8) == 0);
    let pairs = [(); PAIRS_TOGETHER].map(|()| [(); 2].map(|()| I::from_slot(random.below(most) as u32)));
    let pairs = &pairs[..random.below(PAIRS_TOGETHER + 1)];
    let overlaps = simd.overlaps(&boxes, pairs);
    rounds.check([("overlaps", overlaps == Scalar.overlaps(&boxes, pairs))]);
}

#[inline(always)]
fn lines<S: Simd>(simd: S, rounds: &mut Rounds<'_>) {
    let random = &mut rounds.random;
    let direction = [(); 3].map(|()| [0.0, 1.0, -1.0, 0.3, -1e-3][random.below(5)]);
    let start =
        [(); 3].map(|()| [random.below(9) as f32 - 4.0, 1e-30, -3e20][random.below(8).saturating_sub(5)]);
    let cast = Cast::ray(start, direction, 1.0);
    let line = Line::new(&cast.start, cast.direction, cast.distance);
    let walk = Walk::new(&line);
    let until = [1.0, 7.5, f32::INFINITY][random.below(3)];
    let crossing = walk.crossing(&random.frame(), until);
    let records = [(); EIGHT].map(|()| random.record());
    let (times, crossed) = simd.met(&records, &crossing);
    let (expected_times, expected) = Scalar.met(&records, &crossing);
    let met = (times.map(f32::to_bits), crossed) == (expected_times.map(f32::to_bits), expected);
    let nodes = [(); 2].map(|()| if random.below(8) == 0 { KeyBox::NOTHING } else { random.bounds() });
    let entered = simd.enter(&walk, nodes.each_ref(), until).map(f32::to_bits);
    let enter = entered == Scalar.enter(&walk, nodes.each_ref(), until).map(f32::to_bits);
    rounds.check([("met", met), ("enter", enter)]);
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// Any float; special ones come more often.
    fn float(&mut self) -> f32 {
        let particular =
            [0.0, -0.0, 1.0, -1.0, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::from_bits(1), f32::NAN];
        match self.below(4) {
            0 => particular[self.below(particular.len())],
            1 => f32::from_bits(self.bits() as u32),
            _ => self.below(16) as f32 - 8.0,
        }
    }

    fn bounds(&mut self) -> KeyBox {
        let mut bounds = KeyBox::default();
        for k in 0..3 {
            let [a, b] = [(); 2].map(|()| key(self.float()).clamp(NEGATIVE_INFINITY, POSITIVE_INFINITY));
            // A side of less than four keys now and then.
            let b = if self.below(4) == 0 {
                a.saturating_add(self.below(5) as i32).min(POSITIVE_INFINITY)
            } else {
                b
            };
            (bounds.min[k], bounds.max[k]) = (a.min(b), a.max(b));
        }
        bounds
    }

    fn frame(&mut self) -> Frame {
        let origin = [(); 3].map(|()| self.below(9) as f32 - 8.0);
        let scale = [(); 3].map(|()| [0.0, 1.0, 1e-3, 4096.0, f32::MAX][self.below(5)]);
        let twice = |[x, y, z]: [f32; 3]| [x, y, z, x, y, z, 0.0, 0.0];
        Frame { origin: twice(origin), scale: twice(scale) }
    }

    /// Intervals on a coarse grid or on a fine one, so that many touch and some share a side.
    fn record(&mut self) -> Record {
        let (steps, shift) = [(24, 11), (1000, 6), (0x1_0000, 0)][self.below(3)];
        let mut lanes = [0; 6];
        for k in 0..3 {
            let low = self.below(steps);
            let high = low + self.below(steps - low);
            (lanes[k], lanes[3 + k]) = ((low << shift) as u16, !(high << shift) as u16);
        }
        let marks = if self.below(2) == 0 { 0 } else { Record::BELOW * self.below(8) as u32 };
        Record { lanes, tag: self.bits() as u32 & (Record::SLOT | Record::STRADDLES) | marks }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_levels_give_what_scalar_gives() {
        for level in Kernels::all() {
            level.disagreements(1, 20_000, &mut |operation| panic!("{operation} of {}", level.name()));
        }
    }
}
