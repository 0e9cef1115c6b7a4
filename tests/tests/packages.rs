//! What a published crate brings with it.

use std::fs;
use std::path::Path;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn each_crate_has_the_licences_of_the_whole() {
    for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
        for package in ["core", "core/contacts", "std-adapter"] {
            assert!(read(&format!("{package}/{file}")) == read(file), "{package}/{file} differs");
        }
    }
}

/// The examples that a front page names are there.
#[test]
fn front_pages_name_examples_that_are_there() {
    let page = read("std-adapter/README.md");
    for example in ["game", "ecs", "picker", "balls", "rollback", "job_system", "task_graph"] {
        assert!(page.contains(&format!("`{example}`")), "{example}");
        assert!(read(&format!("std-adapter/examples/{example}.rs")).starts_with("//! "), "{example}");
    }
}

/// What `cargo add trisap` brings: three packages of ours and twelve others.
#[test]
fn a_plain_dependency_brings_few_packages() {
    let arguments = [
        "tree",
        "-p",
        "trisap",
        "-e",
        "normal,build",
        "--prefix",
        "none",
        "--offline",
        "--locked",
        "-f",
        "{p}",
    ];
    let tree = std::process::Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo");
    let tree = String::from_utf8(tree.stdout).expect("text");
    let packages: std::collections::BTreeSet<_> =
        tree.lines().filter_map(|line| line.split(' ').next()).collect();
    assert!(packages.contains("trisap-core") && packages.len() <= 3 + 12, "{packages:?}");
}
