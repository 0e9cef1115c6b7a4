//! What the documents name exists: files, tests and programs, constants with their values, the sections of the slab.

#[path = "../peers/chart.rs"]
mod chart;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use trisap_core::{Capacity, Config, layout};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// All files and folders of the repository by their paths, without what builds leave.
fn entries() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut folders = vec![String::new()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).expect("a folder") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().into_string().expect("plain names");
            if ["target", "node_modules", ".git"].contains(&name.as_str()) {
                continue;
            }
            let path = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if entry.file_type().expect("a type").is_dir() {
                folders.push(path.clone());
            }
            found.insert(path);
        }
    }
    found
}

/// The documents: their paths and texts.
fn documents(entries: &BTreeSet<String>) -> Vec<(String, String)> {
    let documents: Vec<_> = (entries.iter())
        .filter(|path| path.ends_with(".md"))
        .map(|path| (path.clone(), read(path)))
        .collect();
    assert!(documents.len() > 10, "there are only {} documents", documents.len());
    documents
}

/// What a document shows as code or links to.
fn code(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (number, part) in text.split("```").enumerate() {
        if number % 2 == 1 {
            found.extend(part.lines().skip(1).map(str::to_owned));
            continue;
        }
        found.extend(part.split('`').skip(1).step_by(2).map(str::to_owned));
        let links = part.split("](").skip(1).filter_map(|link| link.split([')', '#']).next());
        found.extend(links.map(str::to_owned));
    }
    found
}

/// A path without `.` and `..`.
fn plain(path: &str) -> String {
    let mut parts = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// Files that the reader makes, or has elsewhere.
const OF_THE_READER: [&str; 3] = ["FILE.aabbs", "game.c", "./build.sh"];

const EXTENSIONS: [&str; 17] = [
    "aabbs", "c", "cmake", "cpp", "css", "h", "hpp", "html", "js", "json", "md", "mjs", "png", "rs", "sh",
    "toml", "txt",
];

#[test]
fn files_that_documents_name_exist() {
    let entries = entries();
    let names: BTreeSet<&str> = entries.iter().filter_map(|path| path.rsplit('/').next()).collect();
    let (mut missing, mut looked_for) = (Vec::new(), 0);
    for (document, text) in documents(&entries) {
        let folder = document.rsplit_once('/').map_or("", |(folder, _)| folder);
        let code = code(&text);
        for word in code.iter().flat_map(|code| code.split_whitespace()) {
            let word = word.trim_matches([',', ';', ':', '(', ')', '"', '\'']);
            if word.starts_with(['-', '/', '$', '~'])
                || word.contains(['*', '{', '=', '<', '>', '[', '|', '"'])
            {
                continue;
            }
            let extension = word.rsplit_once('.').map_or("", |(_, extension)| extension);
            let first = word.split('/').next().unwrap_or("");
            let is_below = |folder: &str| entries.contains(&plain(&format!("{folder}/{first}")));
            let is_path = word.contains('/') && (is_below("") || is_below(folder));
            if word.contains("://") || !is_path && !EXTENSIONS.contains(&extension) {
                continue;
            }
            looked_for += 1;
            // From the document, from the root, from the sources that it is about; or a name that says where it is.
            let places = [folder, "", &format!("{folder}/src"), "core/src", "include"];
            let exists = places.iter().any(|place| entries.contains(&plain(&format!("{place}/{word}"))))
                || plain(word).is_empty()
                || plain(&format!("{folder}/{word}")).is_empty()
                || !word.contains('/') && names.contains(word)
                || OF_THE_READER.contains(&word);
            if !exists {
                missing.push(format!("{document}: {word}"));
            }
        }
    }
    assert!(looked_for > 100, "only {looked_for} paths");
    assert!(missing.is_empty(), "{missing:#?}");
}

/// The folders of all packages, by name.
fn packages(entries: &BTreeSet<String>) -> BTreeMap<String, String> {
    let manifests = entries.iter().filter_map(|path| path.strip_suffix("/Cargo.toml"));
    let name = |folder: &str| {
        let manifest = read(&format!("{folder}/Cargo.toml"));
        let package = manifest.split_once("[package]")?.1;
        let name = package.lines().find_map(|line| line.strip_prefix("name = \""))?;
        Some(name.trim_end_matches('"').to_owned())
    };
    manifests.filter_map(|folder| Some((name(folder)?, folder.to_owned()))).collect()
}

/// The names of all functions in the tests and sources of a package as a test would have them: module, function.
fn functions(entries: &BTreeSet<String>, package: &str) -> Vec<String> {
    let mut names = Vec::new();
    for path in entries.iter().filter(|path| path.ends_with(".rs")) {
        let Some(file) =
            ["tests", "src"].iter().find_map(|part| path.strip_prefix(&format!("{package}/{part}/")))
        else {
            continue;
        };
        let file = file.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::");
        let mut module = file;
        for line in read(path).lines() {
            if line.starts_with("mod tests {") {
                module += "::tests";
            }
            if let Some(name) = line.trim_start().strip_prefix("fn ") {
                names.push(format!("{module}::{}", name.split(['(', '<']).next().unwrap_or("")));
            }
        }
    }
    names
}

/// A command of cargo as a document has it.
#[derive(Default)]
struct Command {
    options: BTreeMap<String, String>,
    filters: Vec<String>,
}

impl Command {
    fn of(words: &str) -> Self {
        let mut command = Self::default();
        let mut words = words.split_whitespace();
        while let Some(word) = words.next() {
            match word {
                "-p" | "--bin" | "--bench" | "--example" | "--test" | "--manifest-path" | "--features"
                | "-j" => {
                    command.options.insert(word.to_owned(), words.next().unwrap_or("").to_owned());
                }
                _ if word.starts_with('-') => {}
                _ => command.filters.push(word.to_owned()),
            }
        }
        command
    }

    /// What it names and there is not.
    fn missing(
        &self,
        entries: &BTreeSet<String>,
        packages: &BTreeMap<String, String>,
        is_test: bool,
    ) -> Vec<String> {
        let option = |name: &str| self.options.get(name);
        let mut missing = Vec::new();
        let manifest = option("--manifest-path");
        missing.extend(manifest.filter(|path| !entries.contains(*path)).cloned());
        let Some(name) = option("-p") else { return missing };
        let Some(package) = packages.get(name) else { return vec![name.clone()] };
        for (option, folder) in
            [("--bin", "src/bin"), ("--bench", "benches"), ("--example", "examples"), ("--test", "tests")]
        {
            let Some(target) = self.options.get(option) else { continue };
            let exists = entries.contains(&format!("{package}/{folder}/{target}.rs"))
                || entries.contains(&format!("{package}/{folder}/{target}/main.rs"))
                || read(&format!("{package}/Cargo.toml")).contains(&format!("name = \"{target}\"\npath"));
            if !exists {
                missing.push(format!("{target} of {name}"));
            }
        }
        if is_test {
            let functions = functions(entries, package);
            for filter in &self.filters {
                // The reader's choice.
                let filter = filter.trim_end_matches("NAME");
                if !functions.iter().any(|function| function.contains(filter)) {
                    missing.push(format!("{filter} of {name}"));
                }
            }
        }
        missing
    }
}

#[test]
fn tests_and_programs_that_documents_name_exist() {
    let entries = entries();
    let packages = packages(&entries);
    let (mut missing, mut looked_for) = (Vec::new(), 0);
    for (document, text) in documents(&entries) {
        for code in code(&text) {
            let code = code.split('#').next().unwrap_or("");
            for command in ["test", "run", "bench"] {
                let Some((_, words)) = code.split_once(&format!("cargo {command}")) else { continue };
                looked_for += 1;
                let found = Command::of(words).missing(&entries, &packages, command == "test");
                missing.extend(found.into_iter().map(|name| format!("{document}: {name}")));
            }
        }
    }
    assert!(looked_for > 20, "only {looked_for} commands");
    assert!(missing.is_empty(), "{missing:#?}");
}

/// The part of a document below a heading.
fn section<'t>(text: &'t str, heading: &str) -> &'t str {
    let (_, below) = text.split_once(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("no {heading}"));
    let level = heading.split(' ').next().unwrap_or("");
    below.split(&format!("\n{level} ")).next().unwrap_or("")
}

/// The constants of a file and what they are, in plain numbers where builds for tests have other ones.
fn constants(file: &str) -> BTreeMap<String, String> {
    let text = read(file);
    let constants = text.split("const ").skip(1).filter_map(|text| {
        let (name, rest) = text.split_once(':')?;
        let (_, value) = rest.split_once(" = ")?;
        let value = value.split(';').next()?;
        let value = value.replace(['_', ','], "");
        let value = match value.trim().strip_prefix("Duration::from") {
            Some(time) => time.trim_end_matches(')').split('(').rev().collect::<Vec<_>>().join(" "),
            None => value.trim().to_owned(),
        };
        let is_name = name.chars().all(|letter| letter.is_ascii_uppercase() || letter == '_');
        (is_name && !name.is_empty()).then(|| (name.to_owned(), value))
    });
    constants.collect()
}

/// The files that hold nothing but constants that were chosen, each of which is in the table.
const CHOSEN: [&str; 2] = ["core/src/memory/limits.rs", "core/src/tree/limits.rs"];

#[test]
fn constants_are_as_the_table_says() {
    let text = read("core/NOTEBOOK.md");
    let mut listed = BTreeSet::new();
    for row in section(&text, "## Constants").lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, name, value, file, measured, _] = cells[..] else { panic!("{row}: not four cells") };
        let (name, file) = (name.trim_matches('`'), file.trim_matches('`'));
        let file = if file.starts_with("std-adapter") { file.to_owned() } else { format!("core/src/{file}") };
        let value = value.trim_matches('`').replace([',', '_'], "");
        let constants = constants(&file);
        let known = constants.get(name).unwrap_or_else(|| panic!("{file} has no {name}"));
        assert_eq!(*known, value, "{name} of {file}");
        assert!(!measured.is_empty(), "{name}: not even that it was not measured");
        listed.insert((file, name.to_owned()));
    }
    for file in CHOSEN {
        for name in constants(file).into_keys() {
            assert!(
                listed.contains(&(file.to_owned(), name.clone())),
                "{name} of {file} is not in the table"
            );
        }
    }
}

/// The names of all arrays as the table has them, a group a line; those that are in no group come first.
fn sections() -> Vec<Vec<String>> {
    let text = read("core/src/memory/sections.rs");
    let mut groups = vec![vec!["world".to_owned(), "state".to_owned()]];
    for line in text.lines().map(str::trim).filter(|line| !line.starts_with("//")) {
        let Some((name, rest)) = line.split_once(": ") else { continue };
        match rest {
            rest if rest.ends_with('{') => groups.push(vec![name.to_owned()]),
            rest if rest.contains(" = [") => groups.last_mut().expect("a group").push(name.to_owned()),
            _ => {}
        }
    }
    groups
}

#[test]
fn the_figure_of_the_slab_has_its_sections_in_order() {
    let text = read("core/ARCHITECTURE.md");
    let figure = section(&text, "## The slab").split("```").nth(1).expect("a figure");
    let shown: Vec<Vec<&str>> = (figure.lines())
        .filter(|line| line.contains('│'))
        .map(|line| line.split('│').map(str::trim).filter(|cell| !cell.is_empty()).collect())
        .collect();
    assert!(sections().len() > 5);
    let lines: Vec<String> = sections().iter().map(|group| format!(" {} │", group.join(" │ "))).collect();
    assert_eq!(shown, sections(), "the figure is\n{}", lines.join("\n"));
}

/// Contacts that are kept by events are right only if the lost pairs are taken first: a slot or a key may have been used again.
#[test]
fn examples_take_the_lost_pairs_before_the_found_ones() {
    let mut seen = 0;
    let mut look = |path: &str, text: &str| {
        let lines = text.lines().filter(|line| line.trim_start().starts_with("for "));
        let place = |what: &str| lines.clone().position(|line| line.contains(what));
        if let (Some(lost), Some(found)) = (place("lost"), place("found")) {
            assert!(lost <= found, "{path}: found pairs are taken before the lost ones");
            seen += 1;
        }
    };
    for entry in entries() {
        if entry.ends_with(".md") {
            read(&entry).split("```").skip(1).step_by(2).for_each(|part| look(&entry, part));
        } else if entry.contains("examples/") && entry.ends_with("pp") | entry.ends_with(".rs") {
            look(&entry, &read(&entry));
        }
    }
    assert!(seen >= 4, "{seen} loops over events");
}

#[test]
fn the_chart_of_peers_is_drawn_from_the_table() {
    let drawn = chart::svg(&read("tests/peers/README.md")).unwrap_or_else(|error| panic!("{error}"));
    assert!(read("tests/peers/chart.svg") == drawn, "`tests/peers/run.sh --chart` draws it anew");
}

/// The words of other libraries, which the search of the documentation knows.
const ALIASES: [&str; 16] = [
    "raycast",
    "cast_ray",
    "sleep",
    "wake_up",
    "is_sleeping",
    "user_data",
    "intersects",
    "refit",
    "pool",
    "merged",
    "loosened",
    "memberships",
    "max_toi",
    "create_proxy",
    "started",
    "set_collision_groups",
];

#[test]
fn words_of_other_libraries_are_found() {
    let sources: Vec<String> = (entries().iter())
        .filter(|path| {
            path.ends_with(".rs") && (path.starts_with("core/src/") || path.starts_with("std-adapter/src/"))
        })
        .flat_map(|path| {
            read(path)
                .lines()
                .filter(|line| line.contains("doc(alias"))
                .map(str::to_owned)
                .collect::<Vec<_>>()
        })
        .collect();
    for word in ALIASES {
        let word = format!("\"{word}\"");
        assert!(sources.iter().any(|line| line.contains(&word)), "{word} is no alias");
    }
}

/// Room for four pairs an object; small worlds are lean.
#[test]
fn the_bytes_of_small_worlds_are_as_the_table_says() {
    let readme = read("tests/firmware/README.md");
    let mut rows = 0;
    for row in section(&readme, "## Memory").lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<Option<u32>> =
            row.split('|').map(|cell| cell.trim().replace(',', "").parse().ok()).collect();
        let [_, Some(objects), Some(pairs), lean, exact, events, _] = cells[..] else { continue };
        let config = Config::new(Capacity::for_objects(objects).with_pairs(pairs));
        let bytes = |config: &Config| Some(layout::<u16>(config).expect("a world").bytes as u32);
        let may = (objects <= 256).then(|| config.with_lean());
        let told = [may.and_then(|config| bytes(&config)), bytes(&config), bytes(&config.with_events())];
        assert_eq!([lean, exact, events], told, "{objects} objects");
        rows += 1;
    }
    assert!(rows >= 7, "{rows} rows");
    for (objects, bytes) in [(256, "23,040"), (128, "10,688")] {
        let config =
            Config::new(Capacity::for_objects(objects).with_pairs(4 * objects)).with_lean().with_events();
        let told = layout::<u16>(&config).expect("a world").bytes;
        assert_eq!(bytes.replace(',', ""), told.to_string(), "{objects} objects, with events");
        assert!(readme.contains(bytes), "{bytes} is not in the document");
    }
}
