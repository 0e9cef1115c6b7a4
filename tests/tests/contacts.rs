//! Contacts have one number for each pair from the step that finds it to the step that loses it, also after going back.

use std::collections::BTreeMap;
use trisap_contacts::Contacts;
use trisap_core::{Config, Error, Field, World};
use trisap_tests::lives::{act, configs, lived, saved};
use trisap_tests::scenes::Rng;
use trisap_tests::worlds::{Setup, Slab, ample};

const OBJECTS: u32 = 300;
const ROOM: u32 = 12_000;

/// Tells contacts of a step, and compares them with a map that is told the same.
fn follow(contacts: &mut Contacts<Vec<u32>>, world: &World<'_, u32>, model: &mut BTreeMap<[u32; 2], u32>) {
    let (mut ended, mut began) = (Vec::new(), Vec::new());
    contacts
        .update(
            world.lost(),
            world.found(),
            |pair, contact| ended.push((pair, contact)),
            |pair, contact| began.push((pair, contact)),
        )
        .expect("room");
    for (pair, contact) in &ended {
        assert_eq!(model.remove(pair), Some(*contact));
    }
    assert_eq!(ended.len(), world.lost().len());
    for (pair, contact) in &began {
        assert_eq!(contacts.pair(*contact), Some(*pair));
        assert_eq!(model.insert(*pair, *contact), None);
    }
    assert_eq!(began.len(), world.found().len());
    agree(contacts, world, model);
}

fn agree(contacts: &Contacts<Vec<u32>>, world: &World<'_, u32>, model: &BTreeMap<[u32; 2], u32>) {
    let mut pairs = world.pairs().to_vec();
    pairs.sort_unstable();
    assert!(pairs.iter().eq(model.keys()), "the contacts are those of the pairs");
    assert_eq!((contacts.len(), contacts.is_empty()), (model.len(), model.is_empty()));
    let mut of_all: Vec<([u32; 2], u32)> = Vec::new();
    for slot in 0..OBJECTS {
        let of = contacts.of(slot).map(|(contact, other)| ([slot.min(other), slot.max(other)], contact));
        of_all.extend(of);
    }
    of_all.sort_unstable();
    assert!(of_all.iter().copied().eq(model.iter().flat_map(|(pair, number)| [(*pair, *number); 2])));
    let mut numbers: Vec<u32> = model.values().copied().collect();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), model.len());
    assert!(numbers.iter().all(|number| *number < contacts.end()));
    for ([a, b], number) in model {
        assert_eq!((contacts.get(*a, *b), contacts.get(*b, *a)), (Some(*number), Some(*number)));
    }
    assert_eq!(contacts.get(0, 0), None);
    assert_eq!(contacts.get(OBJECTS, 5), None);
}

#[test]
fn numbers_stay_with_their_pairs() {
    let [_, events, margin, fat] = configs();
    for (at, config) in [events, margin.with_events(), fat.with_events()].into_iter().enumerate() {
        let config: Config = config.with_capacity(ample(OBJECTS as usize, ROOM as usize));
        let (mut slab, mut other) = (Slab::new::<u32>(&config), Slab::new::<u32>(&config));
        let mut world = lived::<u32>(&mut slab, &config, 250, at);
        let mut contacts =
            Contacts::new_in(vec![7; Contacts::words(OBJECTS, ROOM)], OBJECTS, ROOM).expect("room");
        let mut model = BTreeMap::new();
        // In a world that has pairs already.
        contacts
            .update(
                &[],
                world.pairs(),
                |_, _| unreachable!(),
                |pair, contact| assert_eq!(model.insert(pair, contact), None),
            )
            .expect("room");
        agree(&contacts, &world, &model);
        let rng = &mut Rng::new(at as u64);
        let mut kept = other.world::<u32>(&config);
        for _ in 0..5 {
            kept.copy_from(&world).expect("the same configuration");
            let before = (contacts.clone(), model.clone(), rng.clone());
            for _ in 0..8 {
                let _ = act(&mut world, rng, Setup::REFERENCE);
                follow(&mut contacts, &world, &mut model);
            }
            let (then, now) = (contacts.clone(), saved(&world));
            // Back, in a copy of the words, and on again: the same numbers.
            world.copy_from(&kept).expect("the same configuration");
            contacts = Contacts::open(before.0.memory().clone()).expect("a copy of contacts");
            (model, *rng) = (before.1, before.2);
            for _ in 0..8 {
                let _ = act(&mut world, rng, Setup::REFERENCE);
                follow(&mut contacts, &world, &mut model);
            }
            assert!(contacts == then && saved(&world) == now);
        }
        // Into more room, with the same numbers.
        let (objects, room) = (OBJECTS + 9, ROOM + 5);
        let moved = contacts.move_into(vec![3; Contacts::words(objects, room)], objects, room).expect("room");
        for ([a, b], number) in &model {
            assert_eq!(moved.get(*a, *b), Some(*number));
        }
        let again = moved.move_into(vec![3; Contacts::words(OBJECTS, ROOM)], OBJECTS, ROOM);
        assert_eq!(
            again.err(),
            Some(Error::NoRoom { field: Field::Objects, needed: objects, room: OBJECTS })
        );
        // All of one object.
        let slot = model.keys().next().expect("a pair")[0];
        let mut ended: Vec<u32> = Vec::new();
        contacts.remove_all(slot, |number, _| ended.push(number));
        assert_eq!(ended.len(), model.keys().filter(|pair| pair.contains(&slot)).count());
        assert_eq!((contacts.of(slot).count(), contacts.len()), (0, model.len() - ended.len()));
        contacts.clear();
        assert!(contacts.is_empty() && contacts.end() == 0);
        Contacts::open(contacts.memory().clone()).expect("contacts");
    }
}

#[test]
fn what_does_not_fit_changes_nothing() {
    let words = Contacts::words(4, 2);
    assert_eq!(
        Contacts::new_in(vec![0; words - 1], 4, 2).err(),
        Some(Error::SlabTooSmall { needed: 4 * words, given: 4 * words - 4 })
    );
    let mut contacts = Contacts::new_in(vec![0; words], 4, 2).expect("room");
    let mut update = |lost: &[[u32; 2]], found: &[[u32; 2]]| {
        let mut told = Vec::new();
        let said = contacts.update(lost, found, |_, _| {}, |_, number| told.push(number));
        (said.err(), told, contacts.len())
    };
    let full = |needed| Some(Error::NoRoom { field: Field::Contacts, needed, room: 2 });
    assert_eq!(update(&[], &[[0, 1], [1, 2]]), (None, vec![0, 1], 2));
    assert_eq!(update(&[], &[[1, 3]]), (full(3), vec![], 2));
    assert_eq!(update(&[[0, 1]], &[[1, 3], [2, 3]]), (full(3), vec![], 2));
    let outside = Error::NoRoom { field: Field::Objects, needed: 5, room: 4 };
    assert_eq!(update(&[[0, 1]], &[[0, 4]]), (Some(outside), vec![], 2));
    assert_eq!(update(&[[0, 1]], &[[3, 3]]), (Some(Error::BadPair), vec![], 2));
    // What was removed since and comes again has a number of its own, the last that became free.
    assert_eq!(update(&[[0, 1], [1, 2]], &[[1, 2]]), (None, vec![1], 1));
    assert_eq!(update(&[[0, 1]], &[[0, 3]]), (None, vec![0], 2));
    // A pair with a number needs no room; one that is lost twice makes room once.
    assert_eq!(update(&[], &[[0, 3]]), (None, vec![0], 2));
    assert_eq!(update(&[[0, 3]], &[[0, 3]]), (None, vec![0], 2));
    assert_eq!(update(&[[0, 3], [3, 0]], &[[0, 1], [0, 2]]), (Some(Error::BadPair), vec![0], 2));
    assert!(Contacts::open(contacts.memory()).is_ok());
}

#[test]
fn forged_contacts_are_refused_or_harmless() {
    let mut contacts = Contacts::new_in(vec![0; Contacts::words(6, 8)], 6, 8).expect("room");
    let found = [[0u32, 1], [1, 2], [2, 3], [0, 5], [1, 5]];
    contacts.update(&[[0, 1]], &found, |_, _| {}, |_, _| {}).expect("room");
    contacts.update(&[[1u32, 2], [0, 5]], &[], |_, _| {}, |_, _| {}).expect("room");
    let good = contacts.memory().clone();
    for at in 0..good.len() {
        for value in [0, 1, 2, 3, 4, 5, 7, 8, 9, u32::MAX, u32::MAX - 1, 1 << 31] {
            let mut forged = good.clone();
            forged[at] = value;
            let Ok(mut contacts) = Contacts::open(forged) else { continue };
            for slot in 0..6 {
                assert!(contacts.of(slot).count() <= 8);
            }
            let _ = contacts.update(&found, &[[3, 4], [4, 5], [0, 2]], |_, _| {}, |_, _| {});
            let _ = contacts.update(&[], &found, |_, _| {}, |_, _| {});
            contacts.remove_all(1, |_, _| {});
        }
    }
    assert_eq!(Contacts::open(vec![]).err(), Some(Error::BadSnapshot));
    assert_eq!(Contacts::open(good[..good.len() - 1].to_vec()).err(), Some(Error::BadSnapshot));
}
