//! The world goes to other memory, and into other capacities.

use super::format::Header;
use super::life::Past;
use crate::checked::slots;
use crate::lives::saved;
use crate::model::Model;
use crate::worlds::Slab;
use trisap_core::{Config, Error, Field, Index, World};

/// The world goes to other memory, without its tree; by a snapshot that is loaded there, or at once.
pub(super) fn moved<I: Index>(
    slab: &mut Slab,
    configure: impl Fn(Config) -> Config,
    by_snapshot: bool,
) -> Result<Slab, Error> {
    let world = World::<I>::open(slab.bytes_mut()).expect("the world that is there");
    let before = saved(&world);
    let config = configure(world.config());
    let mut room = Slab::new::<I>(&config);
    let there = if by_snapshot {
        let mut there = room.world::<I>(&config);
        there.load(&before).map(|()| there)
    } else {
        world.move_into(room.bytes_mut(), &config)
    };
    assert!(saved(&world) == before, "the old world has changed");
    let there = there?;
    there.validate().expect("a valid world");
    let result = |world: &World<'_, I>| [slots(world.pairs()), slots(world.found()), slots(world.lost())];
    assert_eq!(result(&there), result(&world), "the last result comes along");
    assert!(there.found_ids().eq(world.found_ids()), "the ids of found pairs");
    assert!(there.lost_ids().eq(world.lost_ids()), "the ids of lost pairs, also of objects that are no more");
    assert!(there.found_values().eq(world.found_values()), "the values of found pairs");
    assert!(
        there.lost_values().eq(world.lost_values()),
        "the values of lost pairs, also of objects that are no more"
    );
    assert_eq!(there.config(), config);
    Ok(room)
}

/// The world and its twin go into other capacities, if they fit.
pub(super) fn grow<I: Index>(
    header: &Header,
    argument: usize,
    slabs: &mut [Slab; 2],
    past: &mut Past,
    model: &Model,
) {
    let live = model.ids().len();
    // What moves along: the result, and the pairs that are lost; or, after a step without room, those of the last complete one.
    let world = World::<I>::open(slabs[0].bytes_mut()).expect("the world that is there");
    let pairs = world.pairs().len();
    let moving = [world.lost().len(), model.last_pairs()].map(|others| others.max(pairs) as u32);
    let grown = slabs.each_mut().map(|slab| {
        let configure = |config| header.grown(&config, argument);
        moved::<I>(slab, configure, argument / 64 % 2 == 1)
    });
    let said: [Result<(), Error>; 2] =
        grown.each_ref().map(|slab| slab.as_ref().map(|_| ()).map_err(|error| *error));
    assert_eq!(said[0], said[1], "the twin says something else");
    past.tally.say_status(&said[0]);
    match (said[0], grown) {
        (Ok(()), [Ok(one), Ok(two)]) => {
            *slabs = [one, two];
            past.config = header.grown(&past.config, argument);
            let objects = past.config.capacity.objects as usize;
            assert!(live <= objects, "more objects than there is room for");
            past.known.resize(past.known.len().max(objects), None);
            past.tally.grown += 1;
        }
        (Err(Error::NoRoom { field, needed, room }), _) => {
            assert!(needed > room && [Field::Objects, Field::Pairs].contains(&field));
            assert!(field == Field::Objects || moving.contains(&needed), "{needed}, not one of {moving:?}");
        }
        (said, _) => panic!("{said:?}"),
    }
}
