//! The conformance tests, one module a file, in one program: what a test uses of the core is compiled for the program
//! that it is in, so a program for each file would compile the core fifteen times.
//!
//! `cargo test -p trisap-tests filters::` runs one file. A new file needs a line here.

mod allocation;
mod capacity;
mod choices;
mod errata;
mod executors;
mod filters;
mod golden;
mod large;
mod numerics;
mod properties;
mod queries;
mod recordings;
mod resting;
mod snapshots;
mod tree;

/// A file without a line here would be no test at all, and nobody would know.
#[test]
fn every_file_is_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let modules: Vec<&str> =
        include_str!("main.rs").lines().filter_map(|line| line.strip_prefix("mod ")).collect();
    for entry in std::fs::read_dir(folder).expect("the folder of this file") {
        let path = entry.expect("a folder's entry").path();
        let name = path.file_stem().expect("a file's name").to_string_lossy().into_owned();
        assert!(
            name == "main" || modules.contains(&format!("{name};").as_str()),
            "main.rs has no line: mod {name};"
        );
    }
}
