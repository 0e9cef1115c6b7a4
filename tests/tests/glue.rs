//! How many lines the example programs have for the library's sake.

use std::fs;
use std::path::Path;

/// A program: where it is, what it calls its world, what it calls the result of a step, and how many lines name the library, and are
/// glue.
struct Program {
    path: &'static str,
    names: &'static [&'static str],
    named: usize,
    glue: usize,
}

/// Balls with a ground that come, fall asleep and go; a picker and a sensor; rollback; a microcontroller's cell; an ECS.
const PROGRAMS: [Program; 5] = [
    Program { path: "std-adapter/examples/game.rs", names: &["broad_phase", "step"], named: 10, glue: 3 },
    Program { path: "std-adapter/examples/picker.rs", names: &["town", "Town", "ray"], named: 21, glue: 9 },
    Program { path: "std-adapter/examples/rollback.rs", names: &["broad_phase", "step"], named: 8, glue: 6 },
    Program {
        path: "core/examples/bare.rs",
        names: &["CONFIG", "BYTES", "memory", "world", "step"],
        named: 18,
        glue: 14,
    },
    Program { path: "std-adapter/examples/ecs.rs", names: &["broad_phase"], named: 4, glue: 1 },
];

/// Types and functions of the library.
const LIBRARY: [&str; 10] = [
    "Aabb",
    "Boxes",
    "BroadPhase",
    "Capacity",
    "Cast",
    "Config",
    "InlineWorld",
    "Region",
    "Snapshot",
    "layout",
];

/// Calls that a program makes of any library that does this: it says what there is, and asks.
const CALLS: [&str; 19] = [
    ".insert(",
    ".insert_many(",
    ".remove(",
    ".set_resting(",
    ".step()",
    ".step_over(",
    ".pairs()",
    ".found()",
    ".lost()",
    ".overlaps(",
    ".first_hit(",
    ".nearest(",
    ".among(",
    ".save()",
    ".restore(",
    ".keep_contacts(",
    ".found_contacts(",
    ".contacts_of(",
    ".contact(",
];

/// What turns the library's answers into the program's own.
const TURNS: [&str; 4] = [".map(", ".filter_map(", ".flatten(", ".collect"];

/// The lines that name the library, without imports, comments, checks and tests; and those of them that are not calls alone.
fn count(source: &str, names: &[&str]) -> [usize; 2] {
    let has = |line: &str, words: &[&str]| {
        line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| words.contains(&word))
    };
    let contains = |line: &str, parts: &[&str]| parts.iter().any(|part| line.contains(part));
    let program = source.split("#[test]").next().unwrap_or_default();
    let mut count = [0; 2];
    for line in program.lines().map(str::trim) {
        let is_code = !line.starts_with("//") && !line.starts_with("use ") && !line.contains("assert");
        if is_code && (has(line, &LIBRARY) || has(line, names)) {
            let is_call = contains(line, &CALLS) && !contains(line, &TURNS);
            count[0] += 1;
            count[1] += usize::from(!is_call);
        }
    }
    count
}

#[test]
fn programs_have_little_glue() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut all = [0; 2];
    for Program { path, names, named, glue } in PROGRAMS {
        let source = fs::read_to_string(folder.join(path)).expect(path);
        let counted = count(&source, names);
        println!("{path}: {} lines name the library, {} are glue", counted[0], counted[1]);
        assert_eq!(counted, [named, glue], "{path}: named, glue");
        all = [all[0] + named, all[1] + glue];
    }
    assert!(all[1] <= 40, "{all:?}");
}

#[test]
fn it_is_counted_as_it_says() {
    let source = "use trisap::BroadPhase;\nlet mut them = BroadPhase::new();\nthem.insert(1, box_of(1))?;\n\
        let found: Vec<_> = them.overlaps(&all)?.into_iter().map(entity).collect();\nlet theme = 1;\n// them\n\
        assert!(them.is_empty());\n#[test]\nfn f() { them.remove(1); }";
    assert_eq!(count(source, &["them"]), [3, 2]);
}
