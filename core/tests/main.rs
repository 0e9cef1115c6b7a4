//! Steps against brute force, in one program: `cargo test -p trisap-core shift::` runs one file.

mod boxes;
mod faults;
mod levels;
mod shift;
mod slots;
mod snapshot;
mod step;
