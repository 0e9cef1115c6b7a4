//! A world in fixed memory, with nothing but `core`: tells when two of a few vehicles come near each other.
//!
//! Runs on the host as it is; on bare metal the reset code calls `main`. `tests/firmware` has whole programs, with
//! reset code and linker scripts.

#![cfg_attr(target_os = "none", no_std, no_main)]

use trisap_core::{Aabb, Boxes, Capacity, Config, Error, InlineWorld, layout};

const VEHICLES: usize = 8;
/// Room for as many pairs as there can be, so that no step ever fails.
const CONFIG: Config =
    Config::new(Capacity::for_objects(VEHICLES as u32).with_pairs((VEHICLES * (VEHICLES - 1) / 2) as u32))
        .with_events();
/// All the memory there is, known when the program is built.
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;

/// The space around a vehicle that nobody else may enter.
fn safe_space(vehicle: usize, tick: usize) -> Aabb {
    // Each on a lane of its own, at a speed of its own.
    let (x, y) = (tick as f32 * (1.0 + vehicle as f32 / 4.0), vehicle as f32 * 3.0);
    Aabb::new([x - 4.0, y - 2.0, 0.0], [x + 4.0, y + 2.0, 2.0])
}

/// Drives for some ticks; returns how many times two have come near each other, and how many times apart.
fn drive(memory: &mut InlineWorld<BYTES>, ticks: usize) -> Result<[usize; 2], Error> {
    let mut world = memory.init::<u16>(&CONFIG)?;
    let (mut near, mut apart) = (0, 0);
    for tick in 0..ticks {
        let spaces: [Aabb; VEHICLES] = core::array::from_fn(|vehicle| safe_space(vehicle, tick));
        if world.is_empty() {
            world.insert_many(Boxes::new(&spaces))?;
        }
        let step = world.step_over(Boxes::new(&spaces))?;
        near += step.found().len();
        apart += step.lost().len();
    }
    Ok([near, apart])
}

#[cfg(not(target_os = "none"))]
fn main() {
    let mut memory = InlineWorld::EMPTY;
    let result = drive(&mut memory, 100);
    println!("a world of {BYTES} bytes: near and apart {result:?}");
    // Neighbours start side by side, and the faster one of two leaves the other behind.
    assert_eq!(result, Ok([VEHICLES - 1; 2]));
}

/// For the reset code to call.
#[cfg(target_os = "none")]
#[unsafe(no_mangle)]
extern "C" fn main() -> bool {
    // A static lands in `.bss`, where the linker tells whether it fits.
    let mut memory = InlineWorld::EMPTY;
    drive(&mut memory, 100).is_ok()
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
