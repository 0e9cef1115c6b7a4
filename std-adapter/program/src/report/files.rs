//! Writes the data beside the page.

use super::machine::Machine;
use super::result::{Section, Table, Value, Verdict};
use anyhow::{Context, Result};
use serde::Serialize;
use std::fs;
use std::path::Path;

/// All that the report has found out.
#[derive(Serialize)]
pub(super) struct Data<'r> {
    pub(super) machine: &'r Machine,
    pub(super) plan: &'r str,
    pub(super) verdict: Verdict,
    pub(super) sections: &'r [Section],
}

pub(super) fn write(folder: &Path, name: &str, content: &str) -> Result<()> {
    let path = folder.join(name);
    fs::write(&path, content).with_context(|| path.display().to_string())
}

/// `report.json`, and a CSV file for each table.
pub(super) fn write_data(folder: &Path, data: &Data<'_>) -> Result<()> {
    write(folder, "report.json", &(serde_json::to_string_pretty(data)? + "\n"))?;
    for table in data.sections.iter().flat_map(|section| &section.tables) {
        write(folder, &format!("{}.csv", table.id), &csv(table))?;
    }
    Ok(())
}

fn csv(table: &Table) -> String {
    let titles = table.columns.iter().map(|title| quoted(title)).collect::<Vec<_>>().join(",");
    let rows = table.rows.iter().map(|row| row.iter().map(cell).collect::<Vec<_>>().join(","));
    [titles].into_iter().chain(rows).map(|line| line + "\n").collect()
}

fn cell(value: &Value) -> String {
    match value {
        Value::Text(text) => quoted(text),
        Value::Count(count) => count.to_string(),
        Value::Number(number, _) => number.to_string(),
        Value::Missing => String::new(),
    }
}

/// As RFC 4180 has it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_keeps_what_is_in_the_cells() {
        let table = Table {
            id: "t",
            title: String::new(),
            columns: vec!["a, b", "c"],
            rows: vec![
                vec!["say \"so\"".into(), Value::Number(0.1 + 0.2, 1)],
                vec![Value::Missing, 7_u64.into()],
            ],
        };
        assert_eq!(csv(&table), "\"a, b\",c\n\"say \"\"so\"\"\",0.30000000000000004\n,7\n");
    }
}
