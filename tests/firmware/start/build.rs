//! Hands the memory of the board to the linker, as `memory.x`.

use std::path::Path;
use std::{env, fs};

fn main() {
    let variable = |name: &str| env::var(name).unwrap_or_default();
    let board = match variable("TARGET").as_str() {
        "thumbv6m-none-eabi" => "microbit",
        "riscv32imac-unknown-none-elf" => "virt",
        _ => "mps2",
    };
    let out = variable("OUT_DIR");
    fs::copy(format!("boards/{board}.x"), Path::new(&out).join("memory.x")).expect("the file of the board");
    println!("cargo::rustc-link-search={out}");
    println!("cargo::rerun-if-changed=boards");
}
