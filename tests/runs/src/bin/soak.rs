//! Random sequences of operations for a long time: `tests/soak.sh` says how.
//!
//! ```sh
//! soak SECONDS [FIRST_SEED]           # stops at the first fault, and writes the sequence to soak-fault.bin
//! soak SECONDS FIRST_SEED forgeries   # every second operation loads a forged snapshot
//! soak FILE                           # plays a sequence, also one that a fuzzer has found
//! ```

use std::num::NonZero;
use std::panic::{self, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};
use std::{env, fs, process, thread};
use trisap_tests::sequence::{Tally, format, play};

/// Operations of a sequence.
const OPERATIONS: usize = 200;

/// Time from one report to the next.
const REPORT: Duration = Duration::from_secs(60);

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let Some(first) = arguments.first() else {
        eprintln!("usage: soak SECONDS [FIRST_SEED [forgeries]] | soak FILE");
        process::exit(2);
    };
    match first.parse() {
        Ok(seconds) => {
            let seed = arguments.get(1).map_or(0, |seed| seed.parse().expect("a number"));
            let forging = arguments.get(2).is_some_and(|word| word == "forgeries");
            soak(Duration::from_secs(seconds), seed, forging);
        }
        Err(_) => println!("{}", play(&fs::read(first).expect("a file"))),
    }
}

/// Each processor has a thread, which plays the next sequence.
fn soak(time: Duration, first: u64, forging: bool) {
    let start = Instant::now();
    let next = AtomicU64::new(first);
    let sum = Mutex::new((Tally::default(), start));
    let work = || {
        while start.elapsed() < time {
            let seed = next.fetch_add(1, Relaxed);
            let mut bytes = format::random(seed, OPERATIONS);
            if forging {
                bytes = format::forging(bytes);
            }
            let played = catch_unwind(|| play(&bytes));
            // Where a sequence is at fault, the others wait here until the program has ended.
            let mut sum = sum.lock().expect("nobody panics who has it");
            let (tally, told) = &mut *sum;
            match played {
                Ok(played) => *tally += &played,
                Err(_) => {
                    fs::write("soak-fault.bin", least(bytes)).expect("a folder that can be written to");
                    eprintln!("sequence {seed} is at fault: `soak soak-fault.bin` repeats it");
                    report(tally, first, seed, start);
                    process::exit(1);
                }
            }
            if told.elapsed() > REPORT {
                report(tally, first, seed, start);
                *told = Instant::now();
            }
        }
    };
    thread::scope(|scope| {
        let threads = thread::available_parallelism().map_or(1, NonZero::get);
        (0..threads).for_each(|_| drop(scope.spawn(work)));
    });
    let (tally, _) = sum.into_inner().expect("nobody panics who has it");
    report(&tally, first, next.into_inner(), start);
}

/// The sequence without the operations that it is at fault without.
fn least(mut bytes: Vec<u8>) -> Vec<u8> {
    panic::set_hook(Box::new(|_| {}));
    let mut len = OPERATIONS / 2;
    while len > 0 {
        let mut at = format::HEADER;
        while at < bytes.len() {
            let mut fewer = bytes.clone();
            fewer.drain(at..(at + len * format::OPERATION).min(bytes.len()));
            if catch_unwind(|| play(&fewer)).is_err() {
                bytes = fewer;
            } else {
                at += len * format::OPERATION;
            }
        }
        len /= 2;
    }
    bytes
}

fn report(tally: &Tally, first: u64, end: u64, start: Instant) {
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "sequences {first} to {end}, {seconds:.0} s, {:.0} operations a second",
        tally.operations() as f64 / seconds
    );
    println!("{tally}\n");
}
