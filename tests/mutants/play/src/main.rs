//! Plays so many sequences of operations and prints what they come to. Fails at the first fault, or if it is not what the last
//! argument says: then the mutant finds what it should, but by other work than the core without it.
//!
//!     play FIRST COUNT OPERATIONS [HASH]

use std::{env, process};
use trisap_tests::sequence::{Tally, format, play};

fn main() {
    let words: Vec<String> = env::args().skip(1).collect();
    let number = |at: usize| words[at].parse::<u64>().expect("a number");
    let mut tally = Tally::default();
    for seed in number(0)..number(0) + number(1) {
        let bytes = format::random(seed, number(2) as usize);
        tally += &play(&if seed % 8 == 7 { format::forging(bytes) } else { bytes });
    }
    let hash = format!("{:016x}", tally.hash);
    println!("{tally}");
    if words.get(3).is_some_and(|expected| *expected != hash) {
        process::exit(3);
    }
}
