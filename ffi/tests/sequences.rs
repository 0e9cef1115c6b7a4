//! Random sequences of operations, the same bytes through Rust and through the C ABI under sanitizers: the counts of what ran and the
//! hash of all that was said must agree. A compiler whose sanitizers call the wrong functions would be found out.

use crate::c_and_cpp::{Program, SANITIZERS, STATIC, available, scratch, succeed};
use std::process::Command;
use trisap_tests::effort;
use trisap_tests::sequence::{Tally, format, play};

/// Operations of a sequence.
const OPERATIONS: usize = 100;

#[test]
fn c_says_what_rust_says() {
    let mut file = Vec::new();
    let (mut tally, mut hashes) = (Tally::default(), Vec::new());
    for seed in 0..200 * u64::from(effort()) {
        let mut bytes = format::wide(format::random(seed, OPERATIONS));
        // C has no door to fix what steps choose.
        bytes[2] = 0;
        bytes[4] &= !16;
        file.extend((bytes.len() as u32).to_ne_bytes());
        file.extend(&bytes);
        let played = play(&bytes);
        hashes.push(format!("sequence {}", played.hash));
        tally += &played;
    }
    let path = scratch("sequences.bin");
    std::fs::write(&path, file).expect("a folder of this test");
    let mut counts: Vec<String> = tally.numbers().iter().map(u64::to_string).collect();
    counts.pop();
    for compiler in ["clang++", "g++"] {
        if !available(compiler, "its sanitizers watch no sequences") {
            continue;
        }
        let program =
            Program::cpp_by(compiler, "-std=c++17", "sequences.cpp", &format!("sequences_{compiler}"));
        let program = program.with(SANITIZERS).with(["-O1"]).with(STATIC).build();
        let printed = succeed(Command::new(program.get_program()).arg(&path));
        let lines: Vec<&str> = printed.lines().collect();
        let (last, others) = lines.split_last().expect("something printed");
        let wrong = others.iter().zip(&hashes).position(|(one, other)| one != other);
        assert_eq!(wrong, None, "the first sequence that C tells otherwise ({compiler})");
        assert_eq!(others.len(), hashes.len());
        assert_eq!(*last, format!("counts {}", counts.join(" ")), "what ran ({compiler})");
    }
}
