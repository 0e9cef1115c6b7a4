//! Eight vehicles on lanes side by side, in a world of fixed memory: tells when two come near each other, and when they part.

#![no_std]
#![no_main]

// They bring the critical sections of a single core, which `static_cell` takes on an M0.
#[cfg(target_arch = "arm")]
use cortex_m as _;
#[cfg(target_arch = "riscv32")]
use riscv as _;
use semihosting::{print, println, process};
use static_cell::ConstStaticCell;
use trisap_core::{Aabb, Boxes, Capacity, Config, Error, InlineWorld, layout};

const VEHICLES: usize = 8;
/// Room for as many pairs as there can be, so that no step ever fails.
const CONFIG: Config =
    Config::new(Capacity::for_objects(VEHICLES as u32).with_pairs((VEHICLES * (VEHICLES - 1) / 2) as u32))
        .with_events();
const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;

/// All the memory there is. It lands in `.bss`, and the linker says if it does not fit.
static MEMORY: ConstStaticCell<InlineWorld<BYTES>> = ConstStaticCell::new(InlineWorld::EMPTY);

/// In fixed point, Q16.16: 1 is `ONE`.
const ONE: i32 = 1 << 16;

/// The space around a vehicle that nobody else may enter. Each has a lane and a speed of its own.
fn safe_space(vehicle: i32, tick: i32) -> Aabb {
    let (x, y) = (tick * (ONE + vehicle * ONE / 4), vehicle * 3 * ONE);
    Aabb::from_fixed([x - 4 * ONE, y - 2 * ONE, 0], [x + 4 * ONE, y + 2 * ONE, 2 * ONE], 16)
}

fn drive(memory: &mut InlineWorld<BYTES>) -> Result<(), Error> {
    let mut world = memory.init::<u16>(&CONFIG)?;
    for tick in 0..64 {
        let spaces: [Aabb; VEHICLES] = core::array::from_fn(|vehicle| safe_space(vehicle as i32, tick));
        if tick == 0 {
            world.insert_many(Boxes::new(&spaces))?;
        }
        let step = world.step_over(Boxes::new(&spaces))?;
        for [a, b] in step.lost() {
            println!("tick {tick}: {a} and {b} part");
        }
        for [a, b] in step.found() {
            println!("tick {tick}: {a} and {b} are near");
        }
    }
    Ok(())
}

#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    println!("a world of {BYTES} bytes");
    // Taken once: a second time would be a panic.
    match drive(MEMORY.take()) {
        Ok(()) => process::exit(0),
        Err(error) => {
            print!("{error}");
            process::exit(1)
        }
    }
}
