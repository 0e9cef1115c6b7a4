//! Runs the recorded frames through a world in fixed RAM and prints a hash over all pairs, found pairs and lost pairs.
//!
//! With a hash as argument, compares: exit code 0 if it is the same, 1 if not, 2 if the world refused to work.

#![cfg_attr(target_os = "none", no_std, no_main)]

use trisap_core::{Capacity, Config, Error, InlineWorld, layout};
use trisap_firmware::digest::Digest;
use trisap_firmware::{board, entry, print, recording};

const OBJECTS: usize = 64;
const CONFIG: Config =
    Config::new(Capacity::for_objects(OBJECTS as u32).with_pairs(4 * OBJECTS as u32)).with_events();
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;

static mut MEMORY: InlineWorld<BYTES> = InlineWorld::EMPTY;

fn replay(memory: &mut InlineWorld<BYTES>) -> Result<Digest, Error> {
    let mut digest = Digest::default();
    let mut world = memory.init::<u16>(&CONFIG)?;
    for index in 0..recording::FRAMES {
        let Some(boxes) = recording::frame(index, OBJECTS) else { continue };
        if index == 0 {
            world.insert_many(boxes)?;
        }
        let step = world.step_over(boxes)?;
        digest.pairs(step.pairs());
        digest.pairs(step.found());
        digest.pairs(step.lost());
    }
    Ok(digest)
}

fn run() -> u8 {
    let memory = &raw mut MEMORY;
    // SAFETY: `run` is called once, and nothing else names the static.
    let memory = unsafe { &mut *memory };
    let Ok(Digest(hash)) = replay(memory) else {
        board::print("the world refused to work\n");
        return 2;
    };
    print::hexadecimal(hash);
    board::print("\n");

    let mut buffer = [0; 64];
    let expected = board::argument(&mut buffer);
    #[cfg(feature = "panic")]
    assert_ne!(expected, b"panic");
    let digits = (0..16).rev().map(|place| b"0123456789abcdef"[(hash >> (4 * place)) as usize & 15]);
    u8::from(!expected.is_empty() && !digits.eq(expected.iter().copied()))
}

entry!(run);
