//! Checks a linked binary: `inspect BINARY [--sizes FILE] [--stack LIMIT] [--measured FILE] [--integers NAME]`.
//!
//! - No function that panics or allocates is in it; where one is, its callers are named.
//! - With `--sizes`: no section is larger than the file allows, which has lines of target, program, section and bytes.
//! - With `--stack`: the stack of every function of a module `api` is bounded by the frames along its deepest chain of
//!   calls, and the bound is at most `LIMIT`. Thumb only. With `--measured`, a run's output with lines of call and
//!   bytes: what was seen is at most what was computed.
//! - With `--integers`: the function of this name in a module `api` reaches none that computes with floats.
//!
//! Exit code 0 if all holds, 1 if not, and an error's text.

mod binary;
mod calls;
mod stack;
mod thumb;

use anyhow::{Context, Result, bail};
use binary::Binary;
use std::collections::HashMap;
use std::process::ExitCode;
use std::{env, fs};

const OPTIONS: [&str; 4] = ["--sizes", "--stack", "--measured", "--integers"];

/// What is in the name of a function that computes with floats where the processor cannot: the names of the ABI, and
/// those of the compiler's own library.
const FLOATS: [&str; 7] = [
    "__aeabi_f",
    "__aeabi_d",
    "__aeabi_i2f",
    "__aeabi_ui2",
    "__aeabi_i2d",
    "__aeabi_l2",
    "compiler_builtins::float",
];

/// What is in the name of a function that must not be there.
const PANICS: [&str; 3] = ["core::panicking", "core::slice::index::slice_", "::unwrap_failed"];
const ALLOCATES: [&str; 4] = ["__rust_alloc", "__rdl_", "alloc::", "malloc"];

fn main() -> Result<ExitCode> {
    let mut arguments = env::args().skip(1);
    let path =
        arguments.next().with_context(|| format!("usage: inspect BINARY [{}]", OPTIONS.join(" ...] [")))?;
    let mut options = HashMap::new();
    while let Some(option) = arguments.next() {
        let value = arguments.next().with_context(|| format!("{option} needs a value"))?;
        options.insert(option, value);
    }
    if let Some(option) = options.keys().find(|name| !OPTIONS.contains(&name.as_str())) {
        bail!("unknown option {option}");
    }

    let binary = Binary::read(&fs::read(&path)?)?;
    let mut faults = unwanted(&binary);
    if let Some(file) = options.get("--sizes") {
        faults.extend(sizes(&binary, &path, &fs::read_to_string(file)?)?);
    }
    if let Some(limit) = options.get("--stack") {
        let measured = options.get("--measured").map(fs::read_to_string).transpose()?;
        faults.extend(stack::check(&binary, limit.parse()?, measured.as_deref().unwrap_or_default())?);
    }
    if let Some(name) = options.get("--integers") {
        faults.extend(floats(&binary, name));
    }
    for fault in &faults {
        println!("FAULT: {fault}");
    }
    Ok(ExitCode::from(u8::from(!faults.is_empty())))
}

/// Functions that must not be there, with those that call them.
fn unwanted(binary: &Binary) -> Vec<String> {
    let mut faults = Vec::new();
    for function in &binary.functions {
        if !PANICS.iter().chain(&ALLOCATES).any(|part| function.name.contains(part)) {
            continue;
        }
        faults.push(format!("{} is linked", function.name));
        let callers = binary.functions.iter().flat_map(|caller| {
            let places =
                calls::of(binary, caller).into_iter().filter(|call| call.target == Some(function.start));
            places.map(move |call| format!("    called by {} at {:#x}", caller.name, call.from))
        });
        faults.extend(callers);
    }
    faults
}

/// Functions that compute with floats, among those that a public call reaches.
fn floats(binary: &Binary, name: &str) -> Vec<String> {
    let call = format!("::api::{name}");
    let mut reached: Vec<_> =
        binary.functions.iter().filter(|function| function.name.ends_with(&call)).collect();
    if reached.is_empty() {
        return vec![format!("there is no public call {name}")];
    }
    let mut faults = Vec::new();
    let mut next = 0;
    while let Some(function) = reached.get(next).copied() {
        next += 1;
        if FLOATS.iter().any(|part| function.name.contains(part)) {
            faults.push(format!("{name} reaches {}", function.name));
        }
        for call in calls::of(binary, function) {
            match call.target.and_then(|target| binary.function_at(target)) {
                Some(called) if reached.iter().all(|known| known.start != called.start) => {
                    reached.push(called)
                }
                Some(_) => {}
                None => faults.push(format!("{name} calls nobody knows whom at {:#x}", call.from)),
            }
        }
    }
    faults
}

/// Prints the sections and compares them with their ceilings.
fn sizes(binary: &Binary, path: &str, ceilings: &str) -> Result<Vec<String>> {
    let mut parts = path.rsplit('/');
    let (program, target) = (parts.next().unwrap_or_default(), parts.nth(1).unwrap_or_default());
    let mut faults = Vec::new();
    let mut known = false;
    for line in ceilings.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let [for_target, for_program, section, ceiling] = fields[..] else { bail!("not a ceiling: {line}") };
        if (for_target, for_program) != (target, program) {
            continue;
        }
        known = true;
        let size = binary.sections.get(section).copied().unwrap_or_default();
        println!("{target} {program} {section} {size} bytes of {ceiling}");
        if size > ceiling.parse()? {
            faults.push(format!("{section} has {size} bytes, more than {ceiling}"));
        }
    }
    if !known {
        faults.push(format!("no ceilings are recorded for {target} {program}"));
    }
    Ok(faults)
}
