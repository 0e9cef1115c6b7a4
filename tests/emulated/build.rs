//! Links the program for the emulated machine.

fn main() {
    println!("cargo::rerun-if-changed=machine.ld");
    for argument in ["-nostartfiles", "-nostdlib", "-static", "-no-pie", "-Wl,--build-id=none", "-Wl,-n"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    // In the folder of the package, where it is linked: the same for a copy that is built into the same target folder.
    println!("cargo::rustc-link-arg-bins=-Tmachine.ld");
}
