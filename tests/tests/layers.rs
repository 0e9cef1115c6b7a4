//! The layers of the core: each file uses only layers below its own. In no crate do two files need each other.
//!
//! Read from the `use` lines and the paths in the code, without the tests in the files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// From the ground up. What stands beside each other does not know each other.
const LAYERS: [&[&str]; 12] = [
    &["access", "config", "error", "filter", "id", "sort"],
    &["geometry"],
    &["object", "simd"],
    &["parallel"],
    &["memory"],
    &["objects"],
    &["tree"],
    &["pairs"],
    &["sweep"],
    &["step"],
    &["world"],
    &["query", "snapshot", "validate"],
];

/// The crates of the project that others link.
const CRATES: [&str; 4] = ["core", "std-adapter", "ffi", "std-adapter/mpi"];

/// The files of a crate by their module path, without the tests in them.
fn files(of: &str) -> BTreeMap<String, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(of).join("src");
    let mut files = BTreeMap::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                // Programs are crates of their own.
                if !path.ends_with("src/bin") {
                    folders.push(path);
                }
                continue;
            }
            let name = path.strip_prefix(&root).expect("below the root").with_extension("");
            let name = name.to_str().expect("plain names").replace('/', "::");
            let name = name.strip_suffix("::mod").unwrap_or(&name).to_owned();
            if name == "lib" || name.ends_with("tests") {
                continue; // The list of all modules, and tests.
            }
            let text = fs::read_to_string(&path).expect("a file");
            let text: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or("")).collect();
            let text = text.join("\n");
            let end = text.find("#[cfg(test)]\nmod tests").or(text.find("#[cfg(all(test"));
            files.insert(name, text[..end.unwrap_or(text.len())].to_owned());
        }
    }
    files
}

/// The paths that a `use` line names: `a::{b, c::{d, e}}` names `a::b`, `a::c::d` and `a::c::e`.
fn expand(path: &str, into: &mut Vec<String>) {
    let Some(open) = path.find('{') else {
        into.push(path.split(" as ").next().unwrap_or("").trim().to_owned());
        return;
    };
    let (prefix, body) = (&path[..open], &path[open + 1..path.rfind('}').expect("a closing brace")]);
    let (mut depth, mut start) = (0, 0);
    for (at, letter) in body.char_indices().chain([(body.len(), ',')]) {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !body[start..at].trim().is_empty() {
                    expand(&format!("{prefix}{}", body[start..at].trim()), into);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

/// All paths in a file that begin in this crate.
fn paths(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for part in text.split("use ").skip(1) {
        let path = part.split(';').next().unwrap_or("").trim();
        if ["crate::", "super::", "self::"].iter().any(|start| path.starts_with(start)) {
            expand(path, &mut found);
        }
    }
    for (at, _) in text.match_indices("crate::").chain(text.match_indices("super::")) {
        let is_path = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
        let end = text[at..].find(|letter| !is_path(letter)).map_or(text.len(), |len| at + len);
        found.push(text[at..end].trim_end_matches(':').to_owned());
    }
    found
}

/// The file that a path from a file leads to.
fn target(files: &BTreeMap<String, String>, from: &str, path: &str) -> Option<String> {
    let mut place: Vec<&str> = from.split("::").collect();
    let mut names = path.split("::").peekable();
    match names.next()? {
        "crate" => place.clear(),
        "super" => {
            place.pop();
            while names.next_if_eq(&"super").is_some() {
                place.pop();
            }
        }
        _ => {}
    }
    place.extend(names);
    while !place.is_empty() {
        let name = place.join("::");
        if files.contains_key(&name) {
            return Some(name);
        }
        place.pop();
    }
    None
}

fn layer(file: &str) -> usize {
    let folder = file.split("::").next().unwrap_or("");
    let layer = LAYERS.iter().position(|layer| layer.contains(&folder));
    layer.unwrap_or_else(|| panic!("{file} is in no layer"))
}

/// Which files of a crate each of its files uses.
fn uses(krate: &str) -> BTreeMap<String, BTreeSet<String>> {
    let files = files(krate);
    assert!(files.len() > 5, "there are only {} files in {krate}", files.len());
    let of = |name: &String, text: &String| {
        let targets = paths(text).into_iter().filter_map(|path| target(&files, name, &path));
        targets.filter(|used| used != name).collect()
    };
    files.iter().map(|(name, text)| (name.clone(), of(name, text))).collect()
}

#[test]
fn files_use_only_layers_below() {
    let uses = uses("core");
    // So that the test sees what there is to see.
    assert!(uses["step::full"].contains("tree::assign") && uses["memory::layout"].contains("config"));
    let upwards: Vec<String> = (uses.iter())
        .flat_map(|(file, used)| used.iter().map(move |used| (file, used)))
        .filter(|(file, used)| layer(used) > layer(file))
        .map(|(file, used)| format!("{file} uses {used}"))
        .collect();
    assert!(upwards.is_empty(), "{upwards:#?}");
}

#[test]
fn no_files_need_each_other() {
    let circles: Vec<_> = CRATES
        .map(|krate| (krate, circle(uses(krate))))
        .into_iter()
        .filter(|(_, circle)| !circle.is_empty())
        .collect();
    assert!(circles.is_empty(), "in or above a circle: {circles:#?}");
}

/// The files that are in a circle, or use one that is.
fn circle(mut uses: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    // What uses nothing more is taken away until nothing is left, or a circle is.
    loop {
        let ends: Vec<String> =
            uses.iter().filter(|(_, used)| used.is_empty()).map(|(file, _)| file.clone()).collect();
        if ends.is_empty() {
            return uses;
        }
        for end in &ends {
            uses.remove(end);
        }
        for used in uses.values_mut() {
            used.retain(|file| !ends.contains(file));
        }
    }
}

#[test]
fn no_file_is_too_long() {
    let long: Vec<(String, usize)> = (CRATES.iter())
        .flat_map(|krate| {
            files(krate).into_iter().map(move |file| (if *krate == "core" { 400 } else { 450 }, file))
        })
        .map(|(most, (name, text))| (most, name, text.lines().count()))
        .filter(|(most, _, lines)| lines > most)
        .map(|(_, name, lines)| (name, lines))
        .collect();
    assert!(long.is_empty(), "{long:?}");
}

/// Lines that each folder of the core may have, unit tests and comments included. Raise a number only where what is new is worth
/// its lines.
const BUDGETS: [(&str, usize); 14] = [
    ("", 1127),
    ("geometry", 1060),
    ("memory", 1805),
    ("objects", 642),
    ("pairs", 605),
    ("parallel", 492),
    ("query", 1163),
    ("simd", 1964),
    ("snapshot", 598),
    ("step", 731),
    ("sweep", 1428),
    ("tree", 2201),
    ("validate", 374),
    ("world", 1580),
];

#[test]
fn folders_keep_to_their_budgets() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src");
    let mut lines = BTreeMap::<String, usize>::new();
    let mut folders = vec![(root, String::new())];
    while let Some((folder, top)) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                let name = path.file_name().expect("a name").to_string_lossy().into_owned();
                folders.push((path, if top.is_empty() { name } else { top.clone() }));
            } else {
                *lines.entry(top.clone()).or_default() +=
                    fs::read_to_string(&path).expect("a file").lines().count();
            }
        }
    }
    let budgets: BTreeMap<String, usize> = BUDGETS.map(|(name, most)| (name.to_owned(), most)).into();
    let over: Vec<_> =
        lines.iter().filter(|(name, lines)| budgets.get(*name).is_none_or(|most| *lines > most)).collect();
    assert!(over.is_empty(), "more lines than their folders may have: {over:?}");
}
