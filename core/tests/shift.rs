//! Worlds whose origin moves, beside worlds whose origin stays.

use proptest::prelude::*;
use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Id, Margin, Mode, World, layout};

#[repr(C, align(64))]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Line([u8; 64]);

type Pairs = Vec<[u32; 2]>;

fn slab(config: &Config) -> Vec<Line> {
    vec![Line([0; 64]); layout::<u32>(config).expect("a layout").bytes / 64]
}

fn open<'m>(slab: &'m mut [Line], config: &Config) -> World<'m> {
    World::new_in(bytemuck::cast_slice_mut(slab), config).expect("a world")
}

fn sorted(pairs: &[[u32; 2]]) -> Pairs {
    let mut pairs = pairs.to_vec();
    pairs.sort_unstable();
    pairs
}

/// Pairs, found and lost pairs of a step, each ascending. All invariants hold before and after it.
fn step(world: &mut World<'_>) -> [Pairs; 3] {
    world.validate().expect("valid before the step");
    let step = world.step().expect("room");
    let result = [sorted(step.pairs()), sorted(step.found()), sorted(step.lost())];
    world.validate().expect("valid after the step");
    result
}

struct Random(u64);

impl Random {
    fn below(&mut self, end: i32) -> i32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) % end as u64) as i32
    }

    /// A box on a grid of 1/64, so that it can be shifted along that grid exactly.
    fn boxed(&mut self, side: i32) -> Aabb {
        let min = [(); 3].map(|()| self.below(64 * side) as f32 / 64.0);
        Aabb::new(min, min.map(|x| x + (32 + self.below(64)) as f32 / 64.0))
    }
}

fn configs(count: usize) -> Vec<Config> {
    let plain = Config::new(Capacity::for_objects(count as u32 + 8)).with_events();
    let margin = Margin::length(0.25);
    vec![plain, plain.with_margin(margin), plain.with_margin(margin).with_mode(Mode::Fat)]
}

fn moved(aabb: Aabb, by: [f64; 3]) -> Aabb {
    let shift = |x: [f32; 3]| [0, 1, 2].map(|k| (f64::from(x[k]) - by[k]) as f32);
    Aabb::new(shift(aabb.min), shift(aabb.max))
}

/// Two worlds of the same life. The origin of one of them is shifted again and again.
#[test]
fn exact_shifts_change_neither_pairs_nor_events() {
    for count in [20, 300, 3000] {
        for config in configs(count) {
            let mut random = Random(count as u64);
            let side = (count as f64 * 5.0).cbrt() as i32;
            let (mut here, mut there) = (slab(&config), slab(&config));
            let (mut here, mut there) = (open(&mut here, &config), open(&mut there, &config));
            let boxes: Vec<_> = (0..count).map(|_| random.boxed(side)).collect();
            let ids: Vec<Id> = here.insert_many(Boxes::new(&boxes)).expect("room").collect();
            there.insert_many(Boxes::new(&boxes)).expect("room");
            let mut origin = [0.0; 3];
            let mut events = 0;
            for round in 0..12 {
                let result = step(&mut here);
                assert_eq!(step(&mut there), result, "{config:?}, round {round}");
                events += result[1].len() + result[2].len();
                // Some objects move before the shift, some after it, some creep within their margins, most rest.
                let mut give = |here: &mut World<'_>, there: &mut World<'_>, origin: [f64; 3]| {
                    for _ in 0..count / 16 {
                        let at = random.below(count as i32) as usize;
                        let aabb = if round % 3 == 0 {
                            moved(here.aabb(ids[at]).expect("alive"), [1.0 / 64.0; 3])
                        } else {
                            random.boxed(side)
                        };
                        here.set_aabb(ids[at], aabb).expect("alive");
                        there.set_aabb(ids[at], moved(aabb, origin)).expect("alive");
                    }
                };
                give(&mut here, &mut there, origin);
                let by = [256.0, -0.25 * f64::from(round), 3.0 / 64.0];
                assert_eq!(there.shift_origin(by), Ok(0), "{config:?}");
                origin = [0, 1, 2].map(|k| origin[k] + by[k]);
                if round % 2 == 0 {
                    give(&mut here, &mut there, origin);
                }
                for id in ids.iter().step_by(7) {
                    assert_eq!(there.aabb(*id), here.aabb(*id).map(|aabb| moved(aabb, origin)));
                }
            }
            assert!(events > count / 8, "{events} events: nothing happened");
        }
    }
}

#[test]
fn a_shift_alone_is_no_event() {
    for config in configs(3000) {
        let mut slab = slab(&config);
        let mut world = open(&mut slab, &config);
        let mut random = Random(5);
        let boxes: Vec<_> = (0..3000).map(|_| random.boxed(24)).collect();
        let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
        let first = step(&mut world);
        assert!(!first[0].is_empty());
        assert_eq!(world.shift_origin([-4096.0, 64.0, 0.5]), Ok(0));
        // The result of the last step stays until the next one.
        assert_eq!(sorted(world.pairs()), first[0]);
        let [pairs, found, lost] = step(&mut world);
        assert_eq!((pairs, found.len(), lost.len()), (first[0].clone(), 0, 0), "{config:?}");
        // Removed before and inserted after a shift: lost and found.
        let [a, b] = first[0][0];
        world.remove(ids[a as usize]).expect("alive");
        world.shift_origin([64.0, 0.0, 0.0]).expect("finite");
        let again = moved(boxes[a as usize], [-4032.0, 64.0, 0.5]);
        assert_eq!(world.insert(again).expect("room").slot(), a);
        let [pairs, found, lost] = step(&mut world);
        assert_eq!(pairs, first[0]);
        assert!(found.contains(&[a, b]) && lost.contains(&[a, b]) && found == lost);
    }
}

#[test]
fn infinite_bounds_stay_and_large_ones_leave_outwards() {
    let config = Config::new(Capacity::for_objects(8));
    let mut slab = slab(&config);
    let mut world = open(&mut slab, &config);
    let infinite = f32::INFINITY;
    let ground = Aabb::new([-infinite; 3], [infinite, 0.0, infinite]);
    let nowhere = Aabb::new([infinite; 3], [infinite; 3]);
    let [ground, nowhere, low] = [ground, nowhere, Aabb::new([f32::MIN; 3], [f32::MIN; 3])]
        .map(|aabb| world.insert(aabb).expect("room"));
    assert_eq!(world.shift_origin([1e9, 2.0, 0.0]), Ok(1), "the lowest box alone is between two floats");
    assert_eq!(world.aabb(ground), Some(Aabb::new([-infinite; 3], [infinite, -2.0, infinite])));
    assert_eq!(world.aabb(nowhere), Some(Aabb::new([infinite; 3], [infinite; 3])));
    world.shift_origin([f64::from(f32::MAX), 0.0, 0.0]).expect("finite");
    let low = world.aabb(low).expect("alive");
    assert_eq!((low.min[0], low.max[0]), (-infinite, f32::MIN));
    assert!(step(&mut world)[0].contains(&[0, 2]));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let before = world.aabb(ground);
        assert_eq!(world.shift_origin([0.0, bad, 0.0]), Err(Error::BadShift));
        assert_eq!(world.aabb(ground), before);
    }
}

fn brute_force(boxes: &[Aabb]) -> Pairs {
    let pairs = (0..boxes.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
    pairs.filter(|&[a, b]| boxes[a].overlaps(&boxes[b])).map(|pair| pair.map(|at| at as u32)).collect()
}

proptest! {
    /// Whatever the shift: no pair is lost, boxes hold what they held, and events are the differences of the results.
    #[test]
    fn shifts_that_round_lose_nothing(
        by in prop::collection::vec(prop::array::uniform3(prop_oneof![
            -1e3..1e3, -1e9..1e9, -1e40..1e40, any::<i8>().prop_map(f64::from), Just(0.1), Just(-1e-40),
        ]), 1..4),
        seed in any::<u64>(),
        count in prop_oneof![Just(12usize), Just(200), Just(1500)],
    ) {
        for config in configs(count) {
            let mut random = Random(seed);
            let mut slab = slab(&config);
            let mut world = open(&mut slab, &config);
            let boxes: Vec<_> = (0..count).map(|_| random.boxed((count as f64 * 5.0).cbrt() as i32)).collect();
            let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
            let overlapping = brute_force(&boxes);
            let mut last = Pairs::new();
            let mut exact = true;
            for by in [[0.0; 3]].iter().chain(&by) {
                let before: Vec<_> = ids.iter().map(|id| world.aabb(*id).expect("alive")).collect();
                let rounded = world.shift_origin(*by).expect("finite");
                exact &= rounded == 0;
                for (id, before) in ids.iter().zip(&before) {
                    let now = world.aabb(*id).expect("alive");
                    for k in 0..3 {
                        // The difference of an `f32` and a small `f64` may be rounded itself, so only where it is not.
                        let (low, high) = (f64::from(before.min[k]) - by[k], f64::from(before.max[k]) - by[k]);
                        let exactly = |difference: f64, x: f32| f64::from(x) - difference == by[k];
                        prop_assert!(!exactly(low, before.min[k]) || f64::from(now.min[k]) <= low);
                        prop_assert!(!exactly(high, before.max[k]) || f64::from(now.max[k]) >= high);
                        prop_assert!(now.min[k] <= now.max[k]);
                    }
                }
                // Everything may overlap now.
                world.validate().expect("valid before the step");
                let Ok(step) = world.step() else { break };
                let [pairs, found, lost] = [step.pairs(), step.found(), step.lost()].map(sorted);
                world.validate().expect("valid after the step");
                let within = |inner: &Pairs, outer: &Pairs| inner.iter().all(|p| outer.binary_search(p).is_ok());
                let mut overlapping = overlapping.clone();
                overlapping.sort_unstable();
                prop_assert!(within(&overlapping, &pairs), "a pair is lost");
                if exact && config.mode == Mode::Exact {
                    prop_assert_eq!(&pairs, &overlapping);
                }
                let only = |a: &Pairs, b: &Pairs| -> Pairs {
                    a.iter().filter(|p| b.binary_search(p).is_err()).copied().collect()
                };
                prop_assert_eq!(found, only(&pairs, &last));
                prop_assert_eq!(lost, only(&last, &pairs));
                last = pairs;
            }
        }
    }
}
