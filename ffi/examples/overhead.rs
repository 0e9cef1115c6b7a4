//! What the C border costs: one `update_many` and one `step` over 8,000 objects, through the C functions and through the
//! Rust API, in turns, on the recorded frames of a scene where everything moves. Exit code 1 where the C functions take
//! 2 % more at the median; a machine that is busy with other things spreads its results further than that.
//!
//! ```sh
//! cargo run --release -p trisap-ffi --example overhead
//! ```

#![allow(unsafe_code, reason = "calls the C ABI")]

use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;
use std::ptr::null;
use std::time::Instant;
use trisap_core::{Boxes, Capacity, Config, Error, Id, World, layout};
use trisap_ffi::objects::{trisap_default_boxes, trisap_world_insert_many, trisap_world_update_many};
use trisap_ffi::status::trisap_status;
use trisap_ffi::step::{trisap_default_result, trisap_world_step};
use trisap_ffi::structs::{trisap_boxes, trisap_config, trisap_default_config, trisap_id};
use trisap_ffi::world::{trisap_world, trisap_world_init, trisap_world_size};

const OBJECTS: usize = 8000;
/// Steps of each side in a contest.
const ROUNDS: usize = 80;
const CONTESTS: usize = 25;

type Frame = Vec<[f32; 8]>;

fn frames() -> Vec<Frame> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/recordings/brownian_cubes_8000.aabbs");
    let bytes = std::fs::read(path).expect("the repository's recording");
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
    let aabb = |b: &[u8]| std::array::from_fn(|k| number(&b[4 * k..4 * k + 4]));
    bytes[304..].chunks_exact(OBJECTS * 32).map(|frame| frame.chunks_exact(32).map(aabb).collect()).collect()
}

#[repr(align(4096))]
#[derive(Clone)]
struct Page(#[expect(dead_code, reason = "it is memory")] [u8; 4096]);

/// Memory that starts on a page, so that no world is luckier than another.
fn pages(bytes: usize) -> Vec<Page> {
    vec![Page([0; 4096]); bytes.div_ceil(4096)]
}

fn view(frame: &Frame) -> trisap_boxes {
    let packed = trisap_default_boxes(null(), frame.len());
    trisap_boxes { first: frame.as_ptr().cast(), stride: 32, max_offset: 16, ..packed }
}

/// A world behind the C functions, which are called by pointers that the optimiser cannot see through.
struct Foreign {
    world: *mut trisap_world,
    ids: Vec<trisap_id>,
    _memory: Vec<Page>,
}

impl Foreign {
    fn new(config: &trisap_config, first: &Frame) -> Self {
        // SAFETY: a configuration of this version, memory as large and aligned as asked for, room for as many ids as boxes.
        unsafe {
            let bytes = trisap_world_size(config);
            let mut memory = pages(bytes);
            let mut world = std::ptr::null_mut();
            let made = trisap_world_init(memory.as_mut_ptr().cast(), bytes, config, &mut world);
            assert_eq!(made, trisap_status::Ok);
            let mut ids = vec![0; first.len()];
            assert_eq!(trisap_world_insert_many(world, &view(first), ids.as_mut_ptr()), trisap_status::Ok);
            Self { world, ids, _memory: memory }
        }
    }

    #[inline(never)]
    fn step(&mut self, frame: &Frame) -> usize {
        let update_many: unsafe extern "C" fn(_, _, _) -> _ = black_box(trisap_world_update_many);
        let step: unsafe extern "C" fn(_, _, _) -> _ = black_box(trisap_world_step);
        let mut result = trisap_default_result();
        // SAFETY: the world of `new`, as many boxes as ids, a result of this version.
        unsafe {
            assert_eq!(update_many(self.world, self.ids.as_ptr(), &view(frame)), trisap_status::Ok);
            assert_eq!(step(self.world, null(), &mut result), trisap_status::Ok);
        }
        result.pair_count
    }
}

/// A world behind the Rust API.
struct Native<'m> {
    world: World<'m>,
    ids: Vec<Id>,
}

impl<'m> Native<'m> {
    fn new(config: &Config, memory: &'m mut [u8], first: &Frame) -> Self {
        let mut world = World::new_in(memory, config).expect("enough memory");
        let ids = world.insert_many(Boxes::padded(first)).expect("enough room").collect();
        Self { world, ids }
    }

    #[inline(never)]
    fn step(&mut self, frame: &Frame) -> usize {
        // Called as it stands, not compiled anew for this caller and its layout of boxes.
        let update_many: fn(&mut World<'m>, &[Id], Boxes<'_>) -> Result<(), Error> =
            |world, ids, boxes| world.update_many(ids, boxes);
        black_box(update_many)(&mut self.world, &self.ids, Boxes::padded(frame)).expect("good boxes");
        self.world.step().expect("room for all pairs").pairs().len()
    }
}

/// Seconds of a step: C, Rust. Medians of a contest in which they step in turns.
fn contest(frames: &[Frame], c_first: bool) -> [f64; 2] {
    let new_foreign = || Foreign::new(&trisap_default_config(OBJECTS as u32), &frames[0]);
    let early = c_first.then(new_foreign);
    let config = Config::new(Capacity::for_objects(OBJECTS as u32));
    // Where the other world's slab starts behind its header.
    const HEADER: usize = 64;
    let bytes = HEADER + layout::<u32>(&config).expect("a possible configuration").bytes;
    let mut memory = pages(bytes);
    // SAFETY: the same memory as bytes, for as long as it is borrowed.
    let memory = unsafe { std::slice::from_raw_parts_mut(memory.as_mut_ptr().cast::<u8>(), bytes) };
    let mut native = Native::new(&config, &mut memory[HEADER..], &frames[0]);
    let mut foreign = early.unwrap_or_else(new_foreign);

    let mut times = [const { Vec::new() }; 2];
    for round in 0..ROUNDS {
        // There and back, so that no step is longer than those of the recording.
        let there_and_back = 2 * frames.len() - 2;
        let at = round % there_and_back;
        let frame = &frames[at.min(there_and_back - at)];
        let mut pairs = [0; 2];
        // Who comes first loads the frame: for each frame in turns.
        for who in if (round + round / there_and_back).is_multiple_of(2) { [0, 1] } else { [1, 0] } {
            let start = Instant::now();
            pairs[who] = black_box(if who == 0 { foreign.step(frame) } else { native.step(frame) });
            times[who].push(start.elapsed().as_secs_f64());
        }
        assert_eq!(pairs[0], pairs[1], "round {round}");
    }
    times.map(median)
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn main() -> ExitCode {
    let frames = frames();
    // Where a world's memory comes to lie makes a difference of some per cent, so one contest says nothing.
    let contests: Vec<[f64; 2]> = (0..CONTESTS).map(|turn| contest(&frames, turn % 2 == 0)).collect();
    let micros = |who: usize| 1e6 * median(contests.iter().map(|times| times[who]).collect());
    let more = 100.0 * (median(contests.iter().map(|[c, rust]| c / rust).collect()) - 1.0);
    println!("{OBJECTS} objects, update_many + step, medians of {CONTESTS} contests:");
    println!("C {:.1} us, Rust {:.1} us: {more:+.2} %", micros(0), micros(1));
    if more < 2.0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
