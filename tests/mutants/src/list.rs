//! The mutants as `cargo mutants --list --json` names them.

use serde::Deserialize;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// A place in a file, both counted from one.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Hash)]
pub struct Place {
    pub line: usize,
    pub column: usize,
}

#[derive(Debug, Deserialize)]
struct Span {
    start: Place,
}

/// One change to one expression, arm or function.
#[derive(Debug, Deserialize)]
pub struct Mutant {
    pub name: String,
    pub file: String,
    span: Span,
    pub replacement: String,
    pub genre: String,
}

/// All mutants. The number of one is its place in the list, counted from one.
pub fn read(path: &Path) -> Vec<Mutant> {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("a list of cargo-mutants")
}

/// A mutant with its number.
pub type Numbered<'l> = (u32, &'l Mutant);

/// The mutants of one file by genre and place.
pub fn by_place<'l>(
    list: &'l [Mutant],
    file: &str,
    keep: impl Fn(u32) -> bool,
) -> HashMap<(String, Place), Vec<Numbered<'l>>> {
    let mut places: HashMap<_, Vec<_>> = HashMap::new();
    for (mutant, number) in list.iter().zip(1..) {
        if mutant.file == file && keep(number) {
            places.entry((mutant.genre.clone(), mutant.span.start)).or_default().push((number, mutant));
        }
    }
    places
}
