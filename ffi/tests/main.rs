//! The C ABI, in one program: `cargo test -p trisap-ffi border::` runs one file.

mod border;
mod c_and_cpp;
mod sequences;
