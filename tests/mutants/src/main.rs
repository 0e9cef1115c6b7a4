//! See `tests/mutants.sh`.

mod list;
mod run;
mod switch;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::{env, fs, io};
use syn::visit_mut::VisitMut;

const USAGE: &str = "usage: trisap-mutants switch LIST SOURCE TREE UNVIABLE | blame TREE UNVIABLE | exclude LIST UNVIABLE PART \
    | run LIST EXCLUDED STAGES RESULTS JOBS SAMPLE";

fn main() {
    let words: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["switch", list, source, tree, unviable] => switch(list, source, tree, unviable),
        ["blame", tree, unviable] => blame(tree, unviable),
        ["exclude", list, unviable, part] => {
            let unviable = numbers(unviable);
            let list = list::read(Path::new(list));
            // Files of several folders: their parts of paths, divided by commas.
            let wanted = |file: &str| part == "." || part.split(',').any(|part| file.contains(part));
            let out = list
                .iter()
                .zip(1..)
                .filter(|(mutant, number)| unviable.contains(number) || !wanted(&mutant.file));
            out.for_each(|(_, number)| println!("{number}"));
        }
        ["run", list, unviable, stages, results, jobs, one_in] => {
            let list = list::read(Path::new(list));
            let unviable = numbers(unviable);
            let one_in: u32 = one_in.parse().expect("a number");
            let numbers: Vec<u32> = (1..=list.len() as u32)
                .filter(|n| !unviable.contains(n) && mixed(*n).is_multiple_of(one_in))
                .collect();
            run::all(&list, &numbers, Path::new(stages), Path::new(results), jobs.parse().expect("a number"));
        }
        _ => panic!("{USAGE}"),
    }
}

/// Spreads a sample over all files.
fn mixed(number: u32) -> u32 {
    number.wrapping_mul(0x9e37_79b9) >> 8
}

/// The numbers of mutants that cannot be switched: those that do not compile, and those of constant expressions.
fn numbers(file: &str) -> HashSet<u32> {
    let text = fs::read_to_string(file).unwrap_or_default();
    text.lines().filter_map(|line| line.split_whitespace().next()?.parse().ok()).collect()
}

/// Writes the files of the core into the tree with all mutants of the list that compile.
fn switch(list: &str, source: &str, tree: &str, unviable: &str) {
    let list = list::read(Path::new(list));
    let dropped = numbers(unviable);
    let files: BTreeSet<&str> = list.iter().map(|mutant| mutant.file.as_str()).collect();
    let mut constant = Vec::new();
    let mut all = 0;
    for file in files {
        let text = fs::read_to_string(Path::new(source).join(file)).expect("a file of the list");
        let mut parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
        let mut places = list::by_place(&list, file, |number| !dropped.contains(&number));
        all += places.values().map(Vec::len).sum::<usize>();
        switch::Switch { places: &mut places }.visit_file_mut(&mut parsed);
        constant.extend(places.into_values().flatten());
        put(&Path::new(tree).join(file), &prettyplease::unparse(&parsed));
    }
    for (number, mutant) in &constant {
        add(unviable, &format!("{number} not switched: {}\n", mutant.name));
    }
    let root = "core/src/lib.rs";
    let text = fs::read_to_string(Path::new(source).join(root)).expect("the root");
    put(&Path::new(tree).join(root), &(text + &switch::module()));
    println!("{} mutants switched, {} not", all - constant.len(), constant.len());
}

/// A file is written only if it has changed.
fn put(path: &Path, text: &str) {
    if fs::read_to_string(path).is_ok_and(|old| old == text) {
        return;
    }
    fs::write(path, text).expect("room on the disk");
}

fn add(file: &str, line: &str) {
    use io::Write;
    let mut file = fs::OpenOptions::new().create(true).append(true).open(file).expect("a file");
    file.write_all(line.as_bytes()).expect("room on the disk");
}

/// Reads the compiler's messages (JSON) and finds the mutants that do not compile: the last switch before each error.
fn blame(tree: &str, unviable: &str) {
    let mut texts: BTreeMap<PathBuf, String> = BTreeMap::new();
    let mut blamed = BTreeSet::new();
    for line in io::stdin().lines() {
        let Ok(message) = serde_json::from_str::<serde_json::Value>(&line.expect("a line")) else { continue };
        let message = &message["message"];
        if message["level"] != "error" {
            continue;
        }
        let spans = message["spans"].as_array().cloned().unwrap_or_default();
        for span in spans.iter().filter(|span| span["is_primary"] == true) {
            let path = Path::new(tree).join(span["file_name"].as_str().unwrap_or_default());
            let at = span["byte_start"].as_u64().unwrap_or(0) as usize;
            let text =
                texts.entry(path.clone()).or_insert_with(|| fs::read_to_string(&path).unwrap_or_default());
            let before = text.get(..at).unwrap_or_default();
            let number = before.rfind("mutant::on(").and_then(|at| {
                let rest = &before[at + "mutant::on(".len()..];
                rest.split(|c: char| !c.is_ascii_digit()).next()?.parse::<u32>().ok()
            });
            match number {
                Some(number) => {
                    blamed.insert((number, message["message"].as_str().unwrap_or_default().to_owned()));
                }
                None => panic!("no mutant is to blame for {}", message["rendered"]),
            }
        }
    }
    for (number, why) in &blamed {
        add(unviable, &format!("{number} does not compile: {}\n", why.lines().next().unwrap_or_default()));
    }
    println!("{} do not compile", blamed.len());
}
