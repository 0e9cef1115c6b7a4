use super::*;
use std::collections::{BTreeMap, BTreeSet};
use trisap_core::{Cast, Margin, Region};

/// Numbers that look random (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb) >> 33) % end
    }

    fn aabb(&mut self, side: u64) -> Aabb {
        let corner = [(); 3].map(|()| self.below(side) as f32 * 0.5);
        Aabb::new(corner, corner.map(|low| low + 1.0))
    }
}

type Pairs = BTreeSet<[u64; 2]>;

fn in_order(pairs: impl Iterator<Item = [u64; 2]>) -> Pairs {
    let mut count = 0;
    let set: Pairs = pairs.inspect(|_| count += 1).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    assert_eq!(set.len(), count, "no pair twice");
    set
}

/// What brute force finds.
fn overlapping(boxes: &BTreeMap<u64, Aabb>) -> Pairs {
    let mut pairs = Pairs::new();
    for (a, one) in boxes {
        for (b, other) in boxes.range(a + 1..) {
            if one.overlaps(other) {
                pairs.insert([*a, *b]);
            }
        }
    }
    pairs
}

/// As if keys were not there that leave `rest` when divided by three.
fn ask_among(broad_phase: &BroadPhase<u64>, boxes: &BTreeMap<u64, Aabb>, around: Aabb, rest: u64) {
    let wanted = |key: u64| key % 3 != rest;
    let among = broad_phase.among(wanted);
    let region = Region::Aabb(around.grown(1.5));
    let mut found = broad_phase.overlaps(&region).expect("a region");
    found.retain(|key| wanted(*key));
    assert_eq!(among.overlaps(&region).expect("a region"), found);

    let point = around.max.map(|x| x + 0.25);
    let gap = |aabb: &Aabb, k: usize| f64::from(point[k] - point[k].clamp(aabb.min[k], aabb.max[k])).powi(2);
    let distance = |aabb: &Aabb| (gap(aabb, 0) + gap(aabb, 1) + gap(aabb, 2)).sqrt();
    let mut distances: Vec<f64> =
        boxes.iter().filter(|(key, _)| wanted(**key)).map(|(_, aabb)| distance(aabb)).collect();
    distances.sort_by(f64::total_cmp);
    distances.truncate(3);
    let nearest = among.nearest(point, 3).expect("a point");
    assert!(nearest.iter().all(|(key, far)| wanted(*key) && distance(&boxes[key]) == *far));
    assert_eq!(nearest.iter().map(|near| near.1).collect::<Vec<_>>(), distances);

    let ray = Cast::ray(around.min, [1.0, 0.5, 0.0], f32::INFINITY);
    let mut hits = vec![None; boxes.len()];
    broad_phase.as_world().hits(&ray, &mut hits).expect("a ray");
    let mut hits = hits.iter().flatten().filter_map(|hit| Some((broad_phase.key(hit.id)?, hit.distance)));
    assert_eq!(among.first_hit(&ray).expect("a ray"), hits.find(|(key, _)| wanted(*key)));
}

/// From nothing on, with keys that come and go; now and then back to a snapshot. Returns to how many objects and pairs the room grew.
fn live(config: &Config, seed: u64, rounds: u64) -> Capacity {
    let mut numbers = Numbers(seed);
    let mut broad_phase = BroadPhase::with_config(config).expect("a small world");
    let (mut boxes, mut last, mut resting) = (BTreeMap::new(), Pairs::new(), BTreeSet::new());
    let mut next = 0;
    let mut saved = None;
    for round in 0..rounds {
        for _ in 0..numbers.below(12) {
            let aabb = numbers.aabb(12);
            broad_phase.insert(next, aabb).expect("memory");
            boxes.insert(next, aabb);
            next += 1;
        }
        for _ in 0..numbers.below(8) {
            let key = numbers.below(next.max(1));
            if numbers.below(2) == 0 {
                assert_eq!(broad_phase.remove(&key), boxes.remove(&key).is_some());
                resting.remove(&key);
                continue;
            }
            resting.remove(&key);
            let aabb = numbers.aabb(12);
            let known = broad_phase.update(&key, aabb).expect("a good box");
            assert_eq!(known, boxes.contains_key(&key));
            boxes.entry(key).and_modify(|old| *old = aabb);
        }
        for _ in 0..numbers.below(6) {
            let key = numbers.below(next.max(1));
            let known = boxes.contains_key(&key);
            if numbers.below(3) == 0 {
                assert_eq!(broad_phase.wake(&key), known);
                resting.remove(&key);
            } else {
                assert_eq!(broad_phase.set_resting(&key), known);
                resting.extend(known.then_some(key));
            }
        }
        if round % 16 == 3 {
            saved = Some((broad_phase.save(), boxes.clone(), last.clone(), resting.clone()));
        }
        if round % 16 == 13
            && let Some((snapshot, then, pairs, asleep)) = &saved
        {
            let into_another = numbers.below(2) == 0;
            if into_another {
                broad_phase = BroadPhase::with_config(config).expect("a small world");
            }
            broad_phase.restore(snapshot).expect("memory");
            (boxes, last, resting) = (then.clone(), pairs.clone(), asleep.clone());
        }
        let step = broad_phase.step().expect("memory");
        let expected = overlapping(&boxes);
        assert_eq!(in_order(step.pairs()), expected);
        let awake = expected.iter().filter(|pair| !pair.iter().all(|key| resting.contains(key)));
        assert_eq!(in_order(step.awake_pairs()), awake.copied().collect());
        if config.events {
            assert_eq!(in_order(step.found()), expected.difference(&last).copied().collect::<Pairs>());
            assert_eq!(in_order(step.lost()), last.difference(&expected).copied().collect::<Pairs>());
        }
        last = expected;
        assert_eq!(broad_phase.len(), boxes.len());
        let region = numbers.aabb(12);
        let inside: BTreeSet<u64> =
            broad_phase.overlaps(&Region::Aabb(region)).expect("a region").into_iter().collect();
        let expected = boxes.iter().filter(|(_, aabb)| aabb.overlaps(&region)).map(|(key, _)| *key);
        assert_eq!(inside, expected.collect());
        if let Some((key, aabb)) = boxes.iter().next() {
            assert_eq!(broad_phase.aabb(key), Some(*aabb));
            let nearest = broad_phase.nearest(aabb.min, 1).expect("a point");
            assert_eq!(nearest[0].1, 0.0);
            ask_among(&broad_phase, &boxes, *aabb, numbers.below(3));
        }
        assert!(boxes.keys().all(|key| broad_phase.is_resting(key) == resting.contains(key)));
    }
    broad_phase.config().capacity
}

/// All that brute force says, by key, in worlds that begin with next to nothing.
#[test]
fn it_says_what_brute_force_says() {
    let tiny = Config::new(Capacity::for_objects(1).with_leaf_refs(0).with_pairs(1));
    let margin = tiny.with_margin(Margin::length(0.25)).with_events();
    for (seed, config) in
        [tiny, tiny.with_events(), margin, tiny.with_events().with_workers(3)].iter().enumerate()
    {
        for round in 0..20 {
            let grown = live(config, seed as u64 * 100 + round, 60);
            assert!(grown.objects >= 64 && grown.pairs > 500, "{grown:?}");
        }
    }
    // Beyond the size of one leaf.
    let grown = live(&tiny.with_events(), 7, 400);
    assert!(grown.objects > 512, "{grown:?}");
}

#[test]
fn a_key_that_comes_back_is_another_object() {
    let cube = Aabb::new([0.0; 3], [1.0; 3]);
    let mut broad_phase = BroadPhase::default();
    for key in ['a', 'b'] {
        broad_phase.insert(key, cube).expect("room");
    }
    assert_eq!(broad_phase.step().expect("room").found().count(), 1);
    assert!(broad_phase.remove(&'a') && !broad_phase.remove(&'a'));
    broad_phase.insert('a', cube).expect("room");
    let step = broad_phase.step().expect("room");
    assert_eq!(step.found().collect::<Vec<_>>(), [['a', 'b']]);
    assert_eq!(step.lost().collect::<Vec<_>>(), [['a', 'b']]);
}

/// As systems of an ECS look at a resource.
#[test]
fn several_threads_look_at_once() {
    let mut broad_phase = BroadPhase::new();
    for x in 0..100u8 {
        broad_phase.insert(x, Aabb::from_center([f32::from(x), 0.0, 0.0], [0.5; 3])).expect("room");
    }
    broad_phase.step().expect("room");
    let shared = &broad_phase;
    std::thread::scope(|scope| {
        for x in 0..100u8 {
            scope.spawn(move || {
                let at = [f32::from(x), 0.0, 0.0];
                assert_eq!(shared.nearest(at, 1).expect("a point"), [(x, 0.0)]);
                assert_eq!(shared.overlaps(&Region::Point(at)).expect("a point"), [x]);
                let ray = Cast::ray([at[0], 9.0, 0.0], [0.0, -1.0, 0.0], 20.0);
                assert_eq!(shared.first_hit(&ray).expect("a ray"), Some((x, 8.5)));
                assert!(shared.aabb(&x).expect("its box").contains(&Aabb::new(at, at)));
                let pairs = shared.as_world().pairs_of(shared.id(&x).expect("its id"));
                assert_eq!(pairs.count(), if x % 99 == 0 { 1 } else { 2 });
            });
        }
    });
}
