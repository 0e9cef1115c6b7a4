//! The program as its users call it, in one program: `cargo test -p trisap-program page::` runs one file.

mod dump;
mod page;
mod program;
