use super::*;
use core::ops::ControlFlow;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use trisap_core::{Cast, Margin, Region, Serial};

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

/// Keys are numbers in the order in which they were inserted, which is that of the keys in a pair.
fn in_order(pairs: impl Iterator<Item = [u64; 2]>) -> Pairs {
    let mut count = 0;
    let set: Pairs = pairs.inspect(|_| count += 1).inspect(|[a, b]| assert!(a < b)).collect();
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
    let mut hits: Vec<_> =
        hits.iter().flatten().filter_map(|hit| Some((broad_phase.key(hit.id)?, hit.distance))).collect();
    assert_eq!(broad_phase.hits(&ray).expect("a ray"), hits);
    assert_eq!(broad_phase.first_hits(&[ray, ray]).expect("rays"), [hits.first().copied(); 2]);
    hits.retain(|(key, _)| wanted(*key));
    assert_eq!(among.hits(&ray).expect("a ray"), hits);
    assert_eq!(among.first_hit(&ray).expect("a ray"), hits.first().copied());

    let everything = Region::Aabb(Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]));
    let mut answers = broad_phase.overlaps_many(&[region, everything]).expect("regions");
    for (answer, region) in answers.iter_mut().zip([region, everything]) {
        let mut alone = broad_phase.overlaps(&region).expect("a region");
        let mut visited = Vec::new();
        let visit = &mut |key| {
            visited.push(key);
            ControlFlow::Continue(())
        };
        broad_phase.visit_overlaps(&region, visit).expect("a region");
        [&mut alone, &mut visited, &mut *answer].into_iter().for_each(|keys| keys.sort_unstable());
        assert!(*answer == alone && *answer == visited);
    }
    assert_eq!(answers[1], boxes.keys().copied().collect::<Vec<_>>());
    let mut seen = 0;
    let visit = &mut |_, far| {
        seen += 1;
        far
    };
    broad_phase.visit_nearest(point, f64::INFINITY, visit).expect("a point");
    broad_phase.visit_hits(&ray, visit).expect("a ray");
    assert!(seen >= usize::from(!boxes.is_empty()));
}

/// From nothing on, with keys that come and go; now and then back to a snapshot. Returns to how many objects and pairs the room grew.
fn live(config: &Config, seed: u64, rounds: u64) -> Capacity {
    let mut numbers = Numbers(seed);
    let mut broad_phase = BroadPhase::with_config(config).expect("a small world");
    let (mut boxes, mut last, mut resting) = (BTreeMap::new(), Pairs::new(), BTreeSet::new());
    let (keeps_contacts, mut contacts) = (config.events && seed % 2 == 1, BTreeMap::new());
    let mut next = 0;
    let mut saved = None;
    let mut most = config.capacity;
    for round in 0..rounds {
        if round % 32 == 29 {
            // The crowd goes, in the midst of a frame.
            let gone: Vec<u64> = boxes.keys().copied().filter(|_| numbers.below(4) > 0).collect();
            let goes = numbers.below(3);
            if goes == 0 {
                broad_phase.clear();
                (boxes, resting) = Default::default();
            } else if goes == 1 {
                for key in gone {
                    assert!(broad_phase.remove(&key) && boxes.remove(&key).is_some());
                    resting.remove(&key);
                }
            }
            let old = broad_phase.config().capacity;
            most = Capacity::for_objects(old.objects.max(most.objects)).with_pairs(old.pairs.max(most.pairs));
            broad_phase.shrink_to_fit().expect("memory");
            let new = broad_phase.config().capacity;
            let fits = new.objects / 2 <= boxes.len().max(64) as u32;
            assert!((fits || keeps_contacts) && new.objects <= old.objects);
        }
        if keeps_contacts && round == 2 {
            broad_phase.keep_contacts().expect("memory");
            contacts =
                last.iter().map(|[a, b]| ([*a, *b], broad_phase.contact(b, a).expect("a number"))).collect();
        }
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
        if round % 8 == 5 {
            let moved: Vec<_> = boxes
                .keys()
                .map(|key| (*key, numbers.aabb(12)))
                .chain([(u64::MAX, Aabb::default())])
                .collect();
            assert_eq!(broad_phase.update_many(moved.iter().copied()), Ok(boxes.len()));
            boxes.extend(moved[..boxes.len()].iter().copied());
            resting.clear();
        }
        if round % 16 == 3 {
            let then = (boxes.clone(), last.clone(), resting.clone(), contacts.clone());
            saved = Some((broad_phase.save(), broad_phase.clone(), then));
        }
        if round % 16 == 13
            && let Some((snapshot, copy, then)) = &saved
        {
            let into_another = numbers.below(2) == 0;
            if into_another {
                broad_phase = BroadPhase::with_config(config).expect("a small world");
            }
            match numbers.below(3) {
                0 => broad_phase.restore(snapshot).expect("memory"),
                1 => {
                    let bytes = snapshot.to_bytes(|key| !key);
                    let snapshot = Snapshot::from_bytes(&bytes, |number| Some(!number)).expect("good bytes");
                    broad_phase.restore(&snapshot).expect("memory");
                }
                _ => broad_phase.clone_from(copy),
            }
            (boxes, last, resting, contacts) = then.clone();
        }
        let step = broad_phase.step().expect("memory");
        let expected = overlapping(&boxes);
        assert_eq!(in_order(step.pairs()), expected);
        assert!(step.pairs().all(|pair| pair.iter().all(|key| step.aabb(key) == boxes.get(key).copied())));
        let awake = expected.iter().filter(|pair| !pair.iter().all(|key| resting.contains(key)));
        assert_eq!(in_order(step.awake_pairs()), awake.copied().collect());
        if config.events {
            assert_eq!(in_order(step.found()), expected.difference(&last).copied().collect::<Pairs>());
            assert_eq!(in_order(step.lost()), last.difference(&expected).copied().collect::<Pairs>());
        }
        if keeps_contacts && round >= 2 {
            for (pair, number) in step.lost_contacts() {
                assert_eq!(contacts.remove(&pair), Some(number), "the number that it had");
            }
            for (pair, number) in step.found_contacts() {
                assert_eq!(contacts.insert(pair, number), None);
            }
            assert!(contacts.keys().eq(&expected));
            for ([a, b], number) in &contacts {
                assert_eq!((step.contact(a, b), step.contact_keys(*number)), (Some(*number), Some([*a, *b])));
            }
            for key in boxes.keys() {
                let of: BTreeSet<_> = step.contacts_of(key).map(|(_, number)| number).collect();
                let expected = contacts.iter().filter(|(pair, _)| pair.contains(key));
                assert_eq!(of, expected.map(|(_, number)| *number).collect());
            }
        }
        last = expected;
        assert_eq!(broad_phase.len(), boxes.len());
        assert_eq!(broad_phase.iter().collect::<BTreeMap<_, _>>(), boxes);
        let region = numbers.aabb(12);
        let inside: BTreeSet<u64> =
            broad_phase.overlaps(&Region::Aabb(region)).expect("a region").into_iter().collect();
        let expected = boxes.iter().filter(|(_, aabb)| aabb.overlaps(&region)).map(|(key, _)| *key);
        assert_eq!(inside, expected.collect());
        if let Some((key, aabb)) = boxes.iter().next() {
            let mut partners: Vec<_> = broad_phase.pairs_of(key).collect();
            partners.sort_unstable();
            assert!(
                partners.iter().copied().eq(last.range([*key, 0]..[*key + 1, 0]).map(|[_, other]| *other))
            );
            assert_eq!(broad_phase.aabb(key), Some(*aabb));
            let nearest = broad_phase.nearest(aabb.min, 1).expect("a point");
            assert_eq!(nearest[0].1, 0.0);
            ask_among(&broad_phase, &boxes, *aabb, numbers.below(3));
        }
        assert!(boxes.keys().all(|key| broad_phase.is_resting(key) == resting.contains(key)));
    }
    let last = broad_phase.config().capacity;
    Capacity::for_objects(last.objects.max(most.objects)).with_pairs(last.pairs.max(most.pairs))
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
    assert_eq!(step.found().collect::<Vec<_>>(), [['b', 'a']]);
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

/// Keys that were never in a step are in no lost pair.
#[test]
fn what_is_only_asked_does_not_grow() {
    let mut numbers = Numbers(3);
    let mut broad_phase = BroadPhase::new();
    broad_phase.extend((0..50).map(|key| (key, numbers.aabb(4))));
    for steps in [false, true] {
        for key in 100..20_000 {
            broad_phase.insert(key, numbers.aabb(4)).expect("room");
            assert_eq!(broad_phase.nearest([0.0; 3], 1).expect("a point").len(), 1);
            assert!(broad_phase.remove(&key));
            if key % 40 == 0 {
                broad_phase.remove(&(key / 40 % 50));
                broad_phase.insert(key / 40 % 50, numbers.aabb(4)).expect("room");
            }
            assert!(broad_phase.names.remembered() <= if steps { 50 } else { 0 });
        }
        broad_phase.step().expect("room");
    }
    assert_eq!(broad_phase.config().capacity.objects, 64);
}

#[test]
#[should_panic(expected = "with_events")]
fn events_that_were_not_asked_for_are_no_empty_answer() {
    let mut broad_phase = BroadPhase::<u8>::with_config(&Config::default()).expect("a small world");
    drop(broad_phase.step().expect("room").found());
}

#[test]
fn errors_name_the_key() {
    let (good, bad) = (Aabb::new([0.0; 3], [1.0; 3]), Aabb::new([f32::NAN; 3], [1.0; 3]));
    let mut broad_phase = BroadPhase::from_iter([(5, good), (7, good), (9, good)]);
    let refused = broad_phase.insert(7, bad).expect_err("a bad box");
    assert_eq!(refused, KeyedError { key: 7, error: Error::BadBox { index: 0 } });
    assert_eq!(refused.to_string(), "the box of 7 has NaN in it or a minimum above its maximum");
    let far = Aabb::new([8.0; 3], [9.0; 3]);
    let refused = broad_phase.update_many([(5, far), (7, bad), (9, bad), (11, far)]).expect_err("bad boxes");
    assert_eq!(refused.key, 7);
    assert_eq!([5, 7, 9].map(|key| broad_phase.aabb(&key)), [Some(far), Some(good), Some(good)]);
    let refused = broad_phase.set_filter(&9, Filter::ALL).expect_err("no filters");
    assert_eq!(refused.to_string(), "9: the world was made without filters");
    assert_eq!(Error::from(refused), Error::NoFilters);
    assert_eq!(broad_phase.update(&11, far), Ok(false));
    let refused = catch_unwind(AssertUnwindSafe(|| broad_phase.extend([(12, bad)]))).expect_err("a bad box");
    assert!(refused.downcast_ref::<String>().is_some_and(|text| text.contains("the box of 12")));
}

#[test]
fn a_crowd_that_has_gone_gives_its_memory_back() {
    let at = |x: f32| Aabb::from_center([x, 0.0, 0.0], [0.5; 3]);
    let config =
        Config::default().with_filters().with_values().with_events().with_margin(Margin::length(0.25));
    let mut broad_phase = BroadPhase::with_config(&config).expect("a small world");
    broad_phase.extend((0..20_000u16).map(|key| (key, at(f32::from(key)))));
    let mut meets = [u32::MAX; 32];
    meets[3] = 0;
    broad_phase.set_classes(&meets).expect("filters");
    let class = |key| (key, Filter::class(u32::from(key % 500 == 3) * 3));
    assert_eq!(broad_phase.set_filter_many((0..30_000).map(class)), Ok(20_000));
    assert!(broad_phase.set_margin(&17_000, 2.0).expect("a margin") && broad_phase.set_resting(&17_001));
    let id = broad_phase.id(&17_001).expect("its id");
    broad_phase.world().set_value(id, 4711).expect("values");
    broad_phase.step().expect("room");
    assert!(broad_phase.set_enabled(&17_005, false) && !broad_phase.set_enabled(&30_000, false));
    broad_phase.wake(&17_005);
    let bytes = broad_phase.owned.bytes();
    (0..20_000)
        .filter(|key| !(17_000..17_100).contains(key))
        .for_each(|key| assert!(broad_phase.remove(&key)));
    broad_phase.update(&17_099, at(17_096.0)).expect("a good box");
    broad_phase.shrink_to_fit().expect("memory");
    assert!(broad_phase.owned.bytes() < bytes / 20 && broad_phase.pairs().count() == 0);
    assert!(!broad_phase.is_enabled(&17_005) && broad_phase.is_enabled(&17_006));
    assert!(!broad_phase.is_resting(&17_005));
    assert!(!broad_phase.is_enabled(&30_000) && broad_phase.set_enabled(&17_005, true));
    assert_eq!(broad_phase.margin(&17_000), Some(2.0));
    assert!(broad_phase.is_resting(&17_001));
    let value = broad_phase.as_world().value(broad_phase.id(&17_001).expect("its id"));
    assert_eq!(value, Some(4711));
    let saved = broad_phase.save();
    for round in 0..2 {
        let step = broad_phase.on(&Serial).step().expect("room");
        // 97 pairs of neighbours were there: 17,003 has no partner. The last one has gone elsewhere.
        assert_eq!(step.pairs().count(), 96 + 3);
        let near = [17_095, 17_096, 17_097].map(|key| [key, 17_099]);
        assert_eq!(step.found().collect::<Vec<_>>(), near);
        let lost: BTreeSet<_> = step.lost().collect();
        assert!(
            lost.contains(&[16_999, 17_000]) && lost.contains(&[17_098, 17_099]) && lost.contains(&[0, 1])
        );
        assert_eq!(lost.len(), 19_999 - 2 * 40 - 96);
        assert_eq!(broad_phase.step().expect("room").lost().count(), 0);
        if round == 0 {
            broad_phase.restore(&saved).expect("memory");
        }
    }
    let id = broad_phase.id(&17_003).expect("its id");
    assert_eq!(broad_phase.as_world().filter(id), Some(Filter::class(3)));
}

#[test]
fn bytes_that_are_no_snapshot_are_refused() {
    let mut broad_phase = BroadPhase::new();
    for key in 0..9u32 {
        let x = key as f32 * 0.75;
        broad_phase.insert(key, Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])).expect("memory");
    }
    broad_phase.step().expect("memory");
    broad_phase.remove(&4);
    let bytes = broad_phase.save().to_bytes(u64::from);
    let read = |bytes: &[u8]| -> Result<BroadPhase<u32>, Error> {
        let snapshot = Snapshot::from_bytes(bytes, |number| u32::try_from(number).ok())?;
        let mut late = BroadPhase::new();
        late.restore(&snapshot).map(|()| late)
    };
    let mut late = read(&bytes).expect("a good snapshot");
    let [one, other] = [&mut broad_phase, &mut late].map(|broad_phase| {
        broad_phase.step().expect("memory");
        broad_phase.sort_results();
        [broad_phase.pairs().collect::<Vec<_>>(), broad_phase.lost().collect()]
    });
    assert_eq!((one[0].len(), one[1].len()), (6, 2));
    assert_eq!(one, other);
    for len in 0..bytes.len() {
        assert_eq!(read(&bytes[..len]).map(drop), Err(Error::BadSnapshot), "cut to {len}");
    }
    for at in 0..bytes.len() {
        let mut bytes = bytes.clone();
        bytes[at] ^= 1 << (at % 8);
        assert_eq!(read(&bytes).map(drop), Err(Error::BadSnapshot), "changed at {at}");
    }
    let narrow = Snapshot::from_bytes(&bytes, |number| u32::try_from(number).ok().filter(|key| *key < 8));
    assert_eq!(narrow.map(drop).err(), Some(Error::BadSnapshot), "a number that is no key");
}

#[test]
fn an_object_comes_with_all_that_it_has_or_not_at_all() {
    let cube = Aabb::from_center([0.0; 3], [0.5; 3]);
    let config = Config::default().with_filters().with_values().with_margin(Margin::length(0.25));
    let mut broad_phase = BroadPhase::with_config(&config).expect("a small world");
    let object = Object::new(cube).with_filter(Filter::class(3)).with_value(7).with_margin(0.5);
    for (key, object) in [(1, object), (2, object.with_value(8)), (1, object.with_value(9).with_margin(1.0))]
    {
        broad_phase.insert(key, object).expect("a good object");
    }
    let bad = Object::new(Aabb::new([f32::NAN; 3], [1.0; 3])).with_value(1);
    for key in [1, 3] {
        let refused = |error| Err(KeyedError { key, error });
        assert_eq!(broad_phase.insert(key, bad), refused(Error::BadBox { index: 0 }));
        let filter = Filter::class(32);
        assert_eq!(
            broad_phase.insert(key, object.with_filter(filter)),
            refused(Error::BadClass { class: 32 })
        );
        assert_eq!(broad_phase.insert(key, object.with_margin(-1.0)), refused(Error::BadMargin));
    }
    assert_eq!((broad_phase.len(), broad_phase.margin(&1)), (2, Some(1.0)));
    let (world, [one, two]) =
        (broad_phase.as_world(), [1, 2].map(|key| broad_phase.id(&key).expect("its id")));
    assert_eq!((world.value(one), world.value(two), world.filter(two)), (Some(9), Some(8), object.filter));
    // What a box alone leaves out stays.
    broad_phase.insert(1, cube.translated([1.0; 3])).expect("a good box");
    let world = broad_phase.as_world();
    assert_eq!((world.value(one), world.margin(one), world.filter(one)), (Some(9), Some(1.0), object.filter));
    let stale = Id::from_bits(one.to_bits() + (1 << 32)).expect("of another generation");
    let said = broad_phase.world().set_object(stale, object);
    assert_eq!(said, Err(Error::StaleId { id: stale }));

    let mut plain = BroadPhase::new();
    for (object, error) in [
        (Object::new(cube).with_filter(Filter::ALL), Error::NoFilters),
        (Object::new(cube).with_value(1), Error::NoValues),
        (Object::new(cube).with_margin(1.0), Error::NoMargins),
    ] {
        assert_eq!(plain.insert(1, object), Err(KeyedError { key: 1, error }));
    }
    assert!(plain.is_empty());
}

/// The numbers stayed in the order of the step.
#[test]
fn sorted_events_have_their_numbers() {
    let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
    let mut broad_phase = BroadPhase::new();
    broad_phase.keep_contacts().expect("memory");
    for round in 0..4u8 {
        // Pairs of neighbours come and go, in another order than that of their slots.
        broad_phase.extend((0..200u8).map(|key| {
            let place = f32::from(key.wrapping_mul(37));
            (key, cube(place * if round % 2 == 0 { 0.75 } else { 3.0 }))
        }));
        let numbers: BTreeMap<_, _> =
            broad_phase.pairs().map(|pair| (pair, broad_phase.contact(&pair[0], &pair[1]))).collect();
        broad_phase.step().expect("memory");
        broad_phase.sort_results();
        assert!(broad_phase.found().eq(broad_phase.found_contacts().map(|(pair, _)| pair)));
        for ([a, b], number) in broad_phase.found_contacts() {
            assert_eq!(broad_phase.contact(&a, &b), Some(number));
        }
        assert_eq!(broad_phase.lost_contacts().count(), broad_phase.lost().count());
        for (pair, number) in broad_phase.lost_contacts() {
            assert_eq!(numbers[&pair], Some(number));
        }
    }
}

/// After a shrink all pairs are new to the world, but not to those who ask.
#[test]
fn contacts_that_are_asked_for_after_a_shrink_begin_with_found_pairs() {
    let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
    let mut broad_phase = BroadPhase::new();
    broad_phase.reserve(1000).expect("memory");
    broad_phase.extend([0u8, 1, 2].map(|key| (key, cube(0.75 * f32::from(key)))));
    assert_eq!(broad_phase.step().expect("memory").found().count(), 2);
    broad_phase.shrink_to_fit().expect("memory");
    broad_phase.keep_contacts().expect("memory");
    broad_phase.update(&2, cube(0.5)).expect("a good box");
    broad_phase.step().expect("memory");
    assert!(broad_phase.found().eq([[0, 2]]) && broad_phase.contact(&0, &1).is_some());
    let number = broad_phase.contact(&0, &2).expect("a pair");
    assert!(broad_phase.found_contacts().eq([([0, 2], number)]));
    assert_eq!(broad_phase.lost_contacts().count(), 0);
}

/// A forged snapshot takes no more memory than its bytes.
#[test]
fn slots_beyond_a_snapshot_are_refused() {
    let mut broad_phase = BroadPhase::new();
    broad_phase.insert(7u8, Aabb::new([0.0; 3], [1.0; 3])).expect("a good box");
    let bytes = broad_phase.save().to_bytes(u64::from);
    let read = |words: &[u64]| {
        let front: Vec<u8> = words.iter().flat_map(|word| word.to_ne_bytes()).collect();
        Snapshot::from_bytes(&[&front, &bytes[front.len()..]].concat(), |number| u8::try_from(number).ok())
    };
    let mut words: Vec<u64> = bytes.as_chunks().0.iter().map(|word| u64::from_ne_bytes(*word)).collect();
    words.truncate(usize::try_from(words[2]).expect("few"));
    let slot = words.iter().position(|word| *word == broad_phase.id(&7).expect("its id").to_bits());
    assert!(read(&words).is_ok());
    (words[3], words[slot.expect("it is named")]) = (u32::MAX.into(), (1 << 32) + 4_000_000_000);
    words[1] = super::bytes::sum(&words[2..]);
    assert_eq!(read(&words).map(drop), Err(Error::BadSnapshot));
}

/// A step that panics leaves no result: contacts that are asked for then have the numbers of all pairs after the next one.
#[test]
fn contacts_begin_after_a_step_that_was_given_up() {
    let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
    let config = Config::default().with_events().with_filters();
    let mut broad_phase = BroadPhase::with_config(&config).expect("a small world");
    broad_phase.extend((0..4u8).map(|key| (key, cube(0.75 * f32::from(key)))));
    broad_phase.with_rule(&|_, _| true).step().expect("memory");
    broad_phase.insert(4, cube(3.0)).expect("a box");
    let panics = |_, _| std::panic::resume_unwind(Box::new(()));
    let given_up = catch_unwind(AssertUnwindSafe(|| broad_phase.with_rule(&panics).step().map(drop)));
    assert!(given_up.is_err() && broad_phase.pairs().count() == 0);
    broad_phase.keep_contacts().expect("memory");
    broad_phase.with_rule(&|_, _| true).step().expect("memory");
    let number = |broad_phase: &BroadPhase<u8>, key: u8| broad_phase.contact(&key, &(key + 1));
    let numbers: BTreeSet<_> = (0..4).map(|key| number(&broad_phase, key).expect("a pair")).collect();
    assert_eq!(numbers.len(), 4);
    let last = number(&broad_phase, 3).expect("a pair");
    assert!(broad_phase.found_contacts().eq([([3, 4], last)]));
    broad_phase.insert(4, cube(9.0)).expect("a box");
    broad_phase.with_rule(&|_, _| true).step().expect("memory");
    assert!(broad_phase.lost_contacts().eq([([3, 4], last)]));
}

/// Room that was asked for stays where the world moves to more.
#[test]
fn growth_keeps_the_room_that_there_was() {
    let config = Config::new(Capacity::for_objects(100).with_leaf_refs(500).with_pairs(9000));
    let mut broad_phase = BroadPhase::<u8>::with_config(&config).expect("a small world");
    broad_phase.reserve(200).expect("memory");
    let Capacity { objects, leaf_refs, pairs, .. } = broad_phase.config().capacity;
    assert_eq!((objects, leaf_refs, pairs), (200, 500, 9000));
}
