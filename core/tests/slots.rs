//! Objects in slots that the caller names.

use trisap_core::{Aabb, Capacity, Config, Error, Id, InlineWorld, World, layout};

const CONFIG: Config = Config::new(Capacity::for_objects(100).with_pairs(5000)).with_events();
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;

fn cube(x: f32) -> Aabb {
    Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
}

fn living(world: &World<'_, u16>) -> Vec<(u32, Aabb)> {
    world.iter().map(|(id, aabb)| (id.slot(), aabb)).collect()
}

#[test]
fn an_object_comes_into_the_slot_that_is_named() {
    let mut memory = InlineWorld::<BYTES>::EMPTY;
    let mut world = memory.init::<u16>(&CONFIG).unwrap();
    let id = world.insert_at(7, cube(0.0)).unwrap();
    assert_eq!((id.slot(), world.len()), (7, 1));
    assert_eq!(world.insert_at(7, cube(0.5)), Err(Error::SlotTaken { id }));
    assert_eq!(world.insert_at(100, cube(0.5)), Err(Error::ObjectsFull { needed: 101, room: 100 }));
    let bad = Aabb::new([1.0; 3], [0.0; 3]);
    assert_eq!(world.insert_at(8, bad), Err(Error::BadBox { index: 0 }));
    world.validate().unwrap();
    // The slots below are given out from the lowest one on, but for one that is named.
    world.insert_at(1, cube(0.25)).unwrap();
    world.validate().unwrap();
    let slots: Vec<u32> = (0..7).map(|_| world.insert(cube(0.5)).unwrap().slot()).collect();
    assert_eq!(slots, [0, 2, 3, 4, 5, 6, 8]);
    assert_eq!(world.step().unwrap().pairs().len(), 9 * 8 / 2);
    world.validate().unwrap();
    // The free slot that has the link to the named one has not moved.
    for slot in [3, 5] {
        world.remove(world.id_at(slot).unwrap()).unwrap();
    }
    assert_eq!(world.step().unwrap().stats().moved, 2);
    world.insert_at(3, cube(0.5)).unwrap();
    assert_eq!(world.step().unwrap().stats().moved, 1);
    assert_eq!(world.insert(cube(0.5)).unwrap().slot(), 5);
    world.validate().unwrap();
}

/// A client that hears of objects late and in any order has the same pairs as its server, also from a snapshot on.
#[test]
fn a_server_and_a_client_agree_on_slots() {
    let mut memories = [InlineWorld::<BYTES>::EMPTY, InlineWorld::<BYTES>::EMPTY];
    let [mut server, mut client] = memories.each_mut().map(|memory| memory.init::<u16>(&CONFIG).unwrap());
    let mut seed = 7u32;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as usize % below
    };
    let mut bytes = vec![0; 1 << 16];
    for frame in 0..300 {
        let before: Vec<Id> = server.ids().collect();
        for _ in 0..random(6) {
            let ids: Vec<Id> = server.ids().collect();
            if ids.len() > 40 || ids.len() > 10 && random(2) == 0 {
                server.remove(ids[random(ids.len())]).unwrap();
            } else if random(3) == 0 {
                _ = server.insert_at(random(100) as u32, cube(random(40) as f32 * 0.5));
            } else {
                server.insert(cube(random(40) as f32 * 0.5)).unwrap();
            }
        }
        // Those that went, then those that came, from the highest slot down.
        for id in before.iter().filter(|id| !server.contains(**id)) {
            client.remove(client.id_at(id.slot()).unwrap()).unwrap();
        }
        let new: Vec<Id> = server.ids().filter(|id| !before.contains(id)).collect();
        for id in new.into_iter().rev() {
            client.insert_at(id.slot(), server.aabb(id).unwrap()).unwrap();
            client.validate().unwrap();
        }
        if frame % 50 == 49 {
            let len = client.save(&mut bytes).unwrap();
            client.load(&bytes[..len]).unwrap();
        }
        for world in [&mut server, &mut client] {
            world.step().unwrap();
            world.sort_results();
            world.validate().unwrap();
        }
        assert_eq!(living(&server), living(&client));
        assert_eq!(server.pairs(), client.pairs());
        assert_eq!(server.found(), client.found());
        assert_eq!(server.lost(), client.lost());
    }
}
