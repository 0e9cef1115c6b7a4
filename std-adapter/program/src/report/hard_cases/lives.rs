//! Hard lives of objects and worlds: capacities, ids.

use anyhow::{Result, ensure};
use trisap::{Aabb, Boxes, Capacity, Config, Error, Kernels, OwnedWorld};

pub(super) struct Life {
    pub(super) input: &'static str,
    /// What trisap does with it.
    pub(super) answer: &'static str,
    /// Fails where it does something else.
    pub(super) live: fn(Kernels) -> Result<()>,
}

pub(super) const LIVES: [Life; 4] = [
    Life {
        input: "0, 1, 2 and capacity objects, and one more",
        answer: "steps; one more is an error that says how many would have to fit",
        live: counts,
    },
    Life {
        input: "more pairs than the buffer holds",
        answer: "counts on; the error says how many there are; no false events afterwards",
        live: full_buffer,
    },
    Life {
        input: "a slot that is reused within a frame",
        answer: "old ids are stale; the pair is lost and found",
        live: reuse,
    },
    Life {
        input: "f64 boxes a billion units out, and a shift of the origin",
        answer: "rounds outward and misses nothing; exact after the shift; no false events",
        live: far_out,
    },
];

const CUBE: Aabb = Aabb::new([0.0; 3], [1.0; 3]);

fn counts(kernels: Kernels) -> Result<()> {
    const MOST: u32 = 100;
    let mut owned = OwnedWorld::<u16>::with_index(&Config::new(Capacity::for_objects(MOST)))?;
    let mut world = owned.world();
    let mut pairs = 0;
    for count in 0..=MOST {
        let seen = match world.set_kernels(kernels).step() {
            Ok(step) => step.pairs().len() as u32,
            Err(Error::PairsFull { needed, .. }) => needed as u32,
            Err(error) => return Err(error.into()),
        };
        ensure!(seen == pairs, "{count} objects have {seen} pairs instead of {pairs}");
        let inserted = world.insert(CUBE);
        if count < MOST {
            inserted?;
            pairs += count;
        } else {
            let full = Error::ObjectsFull { needed: u64::from(MOST) + 1, room: MOST };
            ensure!(inserted == Err(full), "{inserted:?}");
        }
    }
    Ok(())
}

fn full_buffer(kernels: Kernels) -> Result<()> {
    let config = Config::new(Capacity::for_objects(6).with_pairs(10)).with_events();
    let mut owned = OwnedWorld::<u16>::with_index(&config)?;
    let mut world = owned.world();
    let ids: Vec<_> = world.insert_many(Boxes::new(&[CUBE; 6]))?.collect();
    let error = world.set_kernels(kernels).step().err();
    ensure!(error == Some(Error::PairsFull { needed: 15, room: 10 }), "{error:?}");
    ensure!(world.pairs().len() == 10 && world.found().is_empty() && world.lost().is_empty(), "the prefix");
    for id in ids.iter().take(2) {
        world.remove(*id)?;
    }
    let step = world.set_kernels(kernels).step()?;
    ensure!(step.pairs().len() == 6 && step.found().len() == 6 && step.lost().is_empty(), "the events");
    Ok(())
}

fn reuse(kernels: Kernels) -> Result<()> {
    let mut owned = OwnedWorld::<u16>::with_index(&Config::new(Capacity::for_objects(4)).with_events())?;
    let mut world = owned.world();
    let (old, _) = (world.insert(CUBE)?, world.insert(CUBE)?);
    world.set_kernels(kernels).step()?;
    world.remove(old)?;
    let new = world.insert(CUBE)?;
    ensure!(new.slot() == old.slot() && !world.contains(old) && world.contains(new), "the ids");
    let step = world.set_kernels(kernels).step()?;
    ensure!(step.pairs() == [[0, 1]] && step.found() == [[0, 1]] && step.lost() == [[0, 1]], "the events");
    Ok(())
}

fn far_out(kernels: Kernels) -> Result<()> {
    const FAR: f64 = 1e9;
    // Each touches the next one.
    let cube = |i: u32, origin: f64| {
        let low = FAR + f64::from(i);
        Aabb::from_f64([low, 0.0, 0.0], [low + 1.0, 1.0, 1.0], [origin, 0.0, 0.0])
    };
    let count = 200;
    let frame = |origin| -> Vec<Aabb> { (0..count).map(|i| cube(i, origin)).collect() };
    let config = Config::new(Capacity::for_objects(count).with_pairs(40_000)).with_events();
    let mut owned = OwnedWorld::<u16>::with_index(&config)?;
    let mut world = owned.world();
    world.insert_many(Boxes::new(&frame(0.0)))?;
    let step = world.set_kernels(kernels).step()?;
    let coarse = step.is_coarse();
    let touching = |pairs: &[[u16; 2]]| (1..count as u16).all(|b| pairs.contains(&[b - 1, b]));
    ensure!(coarse && touching(step.pairs()), "outward rounding has lost a pair or has not warned");
    ensure!(world.shift_origin([FAR, 0.0, 0.0])? == 0, "the shift was not exact");
    let step = world.set_kernels(kernels).step()?;
    ensure!(step.found().is_empty() && step.lost().is_empty(), "the shift has made events");
    let step = world.set_kernels(kernels).step_over(Boxes::new(&frame(FAR)))?;
    ensure!(touching(step.pairs()) && step.pairs().len() as u32 == count - 1, "not exact after the shift");
    ensure!(step.found().is_empty() && !step.is_coarse(), "after the shift");
    Ok(())
}
