//! The smallest program that steps: 64 objects, 256 pairs. Its text is what a world costs, and with a feature what that adds:
//! see `flash.sh`.
//!
//! Exit code 1 if the pairs are not as many as in the recording, 2 if the world refused to work.

#![cfg_attr(target_os = "none", no_std, no_main)]

use trisap_core::{Capacity, Config, Error, InlineWorld, layout};
use trisap_firmware::{entry, recording};

const OBJECTS: usize = 64;
const CONFIG: Config = {
    let config = Config::new(Capacity::for_objects(OBJECTS as u32).with_pairs(4 * OBJECTS as u32));
    #[cfg(feature = "events")]
    let config = config.with_events();
    #[cfg(feature = "margins")]
    let config = config.with_margin(trisap_core::Margin::length(0.01));
    #[cfg(feature = "filters")]
    let config = config.with_filters();
    #[cfg(feature = "values")]
    let config = config.with_values();
    config
};
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
/// The pairs of all frames, by brute force.
const PAIRS: usize = 3051;

static mut MEMORY: InlineWorld<BYTES> = InlineWorld::EMPTY;

fn replay(memory: &mut InlineWorld<BYTES>) -> Result<usize, Error> {
    let mut world = memory.init::<u16>(&CONFIG)?;
    let mut sum = 0;
    for index in 0..recording::FRAMES {
        let Some(boxes) = recording::frame(index, OBJECTS) else { continue };
        while let Some(aabb) = boxes.get(world.len() as usize).filter(|_| index == 0) {
            let _id = world.insert(aabb)?;
            #[cfg(feature = "filters")]
            world.set_filter(_id, trisap_core::Filter::groups(1, 1))?;
            #[cfg(feature = "values")]
            world.set_value(_id, 1)?;
        }
        #[cfg(feature = "rest")]
        world.wake(&[world.id_at(0).ok_or(Error::NotAWorld)?])?;
        #[cfg(feature = "shifts")]
        world.shift_origin([0.0; 3])?;
        sum += world.step_over(boxes)?.pairs().len();
        #[cfg(feature = "queries")]
        world.overlaps(
            &trisap_core::Region::Aabb(boxes.get(0).ok_or(Error::NotAWorld)?),
            &mut [None; OBJECTS],
        )?;
        #[cfg(feature = "events")]
        if index == 0 && world.found().len() != sum + world.lost().len() {
            return Ok(0);
        }
        #[cfg(feature = "values")]
        if world.pair_values().any(|values| values != [1; 2]) {
            return Ok(0);
        }
    }
    Ok(sum)
}

fn run() -> u8 {
    let memory = &raw mut MEMORY;
    // SAFETY: `run` is called once, and nothing else names the static.
    let memory = unsafe { &mut *memory };
    match replay(memory) {
        Ok(PAIRS) => 0,
        Ok(_) => 1,
        Err(_) => 2,
    }
}

entry!(run);
