//! Compares the tables of a document with those that a program prints, which come on the standard input:
//! `measure | table README.md`. A figure may be off by one in [`NEAR`], since compilers and small changes move all
//! of them a little. With `--write` the document gets the tables as they are.
//!
//! Exit code 1 if a figure or a row is another one, or a table is not in the document.

use std::process::ExitCode;
use std::{env, fs, io};

/// The part of itself that a figure may be off by.
const NEAR: i64 = 50;

/// The cells of a row.
fn cells(row: &str) -> Vec<&str> {
    row.trim().trim_matches('|').split('|').map(str::trim).collect()
}

fn is_near(told: &str, is: &str) -> bool {
    let number = |cell: &str| cell.replace(',', "").parse::<i64>();
    match (number(told), number(is)) {
        (Ok(told), Ok(is)) => (told - is).abs() * NEAR <= is.abs().max(NEAR),
        _ => told == is,
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [document, options @ ..] = &arguments[..] else {
        eprintln!("usage: table DOCUMENT [--write] <TABLES");
        return ExitCode::from(2);
    };
    let writes = options.contains(&"--write".to_owned());
    let text = fs::read_to_string(document).expect("a document");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let printed = io::read_to_string(io::stdin()).expect("text");
    let printed: Vec<&str> = printed.lines().collect();
    let mut result = ExitCode::SUCCESS;
    for table in printed.chunk_by(|a, b| a.starts_with('|') && b.starts_with('|')) {
        if !table[0].starts_with('|') {
            continue;
        }
        let Some(start) =
            lines.iter().position(|line| line.starts_with('|') && cells(line) == cells(table[0]))
        else {
            eprintln!("{document} has no table {}", table[0]);
            return ExitCode::FAILURE;
        };
        let len = lines[start..].iter().take_while(|line| line.starts_with('|')).count();
        if writes {
            lines.splice(start..start + len, table.iter().map(|row| (*row).to_owned()));
            continue;
        }
        let told = &lines[start..start + len];
        for (told, is) in told.iter().zip(table).skip(2) {
            let (told_cells, is_cells) = (cells(told), cells(is));
            let near = told_cells.iter().zip(&is_cells).all(|(told, is)| is_near(told, is));
            if !near || told_cells.len() != is_cells.len() {
                eprintln!("{document} says\n{told}\nbut it is\n{is}");
                result = ExitCode::FAILURE;
            }
        }
        if told.len() != table.len() {
            eprintln!(
                "{document} has {} lines where {} are printed below {}",
                told.len(),
                table.len(),
                table[0]
            );
            result = ExitCode::FAILURE;
        }
    }
    if writes {
        fs::write(document, lines.join("\n") + "\n").expect("a document");
    }
    result
}
