//! The conformance tests, one module a file, in one program: what a test uses of the core is compiled for the program
//! that it is in, so a program for each file would compile the core fifteen times.
//!
//! `cargo test -p trisap-tests filters::` runs one file. A new file needs a line here.

mod allocation;
mod among;
mod asked;
mod by_leaf;
mod capacity;
mod choices;
mod cliffs;
mod contacts;
mod contents;
mod copies;
mod documents;
mod edges;
mod enabled;
mod errata;
mod events;
mod executors;
mod filters;
mod flat;
mod forged;
mod glue;
mod golden;
mod growth;
mod large;
mod layers;
mod meeting;
mod numerics;
mod packages;
mod panics;
mod properties;
mod queries;
mod real_scenes;
mod recordings;
mod regressions;
mod resting;
mod sequences;
mod snapshots;
mod tree;
mod values;
mod workers;

/// A file without a line in its `main.rs` would be no test at all, and nobody would know.
#[test]
fn every_file_is_a_module() {
    let repository = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for folder in ["tests/tests", "core/tests", "ffi/tests", "std-adapter/program/tests"] {
        let folder = repository.join(folder);
        let main = std::fs::read_to_string(folder.join("main.rs")).expect("the program of the tests");
        let mut modules: Vec<String> =
            main.lines().filter_map(|line| Some(line.strip_prefix("mod ")?.replace(';', ".rs"))).collect();
        modules.push("main.rs".to_owned());
        modules.sort();
        let entries = std::fs::read_dir(&folder).expect("the folder of the tests");
        let names = entries.map(|entry| entry.expect("a file").file_name().to_string_lossy().into_owned());
        let mut files: Vec<String> = names.filter(|name| name.ends_with(".rs")).collect();
        files.sort();
        assert_eq!(files, modules, "main.rs in {} has a line for each file", folder.display());
    }
}
