//! Names the linker script of the board that stands for the target.

use std::env;

fn main() {
    let variable = |name| env::var(name).unwrap_or_default();
    println!("cargo::rerun-if-changed=boards");
    if variable("CARGO_CFG_TARGET_OS") != "none" {
        return;
    }
    let (board, large) = match variable("TARGET").as_str() {
        "thumbv6m-none-eabi" => ("microbit", "microbit"),
        "riscv32imac-unknown-none-elf" => ("virt", "virt"),
        _ => ("mps2", "mps2-large"),
    };
    println!("cargo::rustc-link-arg-bins=-L{}/boards", variable("CARGO_MANIFEST_DIR"));
    for program in ["replay", "calls", "around", "flash"] {
        println!("cargo::rustc-link-arg-bin={program}=-T{board}.ld");
    }
    println!("cargo::rustc-link-arg-bin=measure=-T{large}.ld");
}
