//! Draws the table of `tests/peers`, which it reads from its input, as a chart: some scenes that everybody understands, beside
//! the best-known peers. `run.sh --chart` compiles it alone, as the peers take minutes to build.

use std::fmt::Write;

#[allow(dead_code, reason = "a test takes the chart alone")]
fn main() {
    let drawn = std::io::read_to_string(std::io::stdin()).map_err(|error| error.to_string());
    match drawn.and_then(|table| svg(&table)) {
        Ok(svg) => print!("{svg}"),
        Err(error) => {
            eprintln!("no chart: {error}");
            std::process::exit(1);
        }
    }
}

/// Scenes by their names in the table, and in plain words.
const SCENES: [(&str, &str); 6] = [
    ("synthetic pile", "A heap of cubes settles"),
    ("synthetic town", "A town: houses, crowds, triggers"),
    ("synthetic level", "A level: floors, walls, walkers"),
    ("brownian cubes", "Loose cubes, from a physics engine"),
    ("synthetic parking", "Parked cars, few of which move"),
    ("synthetic ground inf", "Cubes shiver in place on a plane"),
];
/// Peers by their columns, and by the names that fit.
const PEERS: [(&str, &str); 5] = [
    ("PhysX ABP", "PhysX"),
    ("rapier3d", "rapier"),
    ("Jolt", "Jolt"),
    ("Bullet DBVT", "Bullet"),
    ("Box3D", "Box3D"),
];

const WIDTH: usize = 820;
const PANEL: (usize, usize) = (WIDTH / 2, 168);
/// Of the head, and from one bar to the next.
const HEAD: usize = 64;
const ROW: usize = 19;
/// Where bars start in their panel, and the length of the longest.
const BARS: (usize, f64) = (74, 260.0);

const STYLE: &str = "text{font:13px system-ui,-apple-system,'Segoe UI',sans-serif;fill:#1f2328}\
    .h{font-size:18px;font-weight:600}.t{font-weight:600;font-size:14px}.s{fill:#59636e;font-size:12px}\
    .e{text-anchor:end}.us{fill:#0969da}text.us{font-weight:600}.peer{fill:#a8b1bb}\
    @media(prefers-color-scheme:dark){text{fill:#e6edf3}.s{fill:#9198a1}.us{fill:#58a6ff}.peer{fill:#57606a}}";

/// The chart of a table as `run.sh --table` prints it; or which scene or peer is not in it.
pub(crate) fn svg(table: &str) -> Result<String, String> {
    let rows = table.lines().filter(|line| line.starts_with('|'));
    let mut rows = rows.map(|line| line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>());
    let head = rows.find(|row| row.first() == Some(&"scene")).ok_or("there is no table of scenes")?;
    let rows: Vec<_> = rows.filter(|row| row.len() == head.len()).collect();
    let mut panels = Vec::new();
    let mut longest: f64 = 1.0;
    for (name, words) in SCENES {
        let row = rows.iter().find(|row| row[0] == name).ok_or(format!("no scene {name}"))?;
        let mut bars = Vec::new();
        for (column, peer) in PEERS {
            let at = head
                .iter()
                .position(|cell| cell.trim_end_matches(" ⊇") == column)
                .ok_or(format!("no peer {column}"))?;
            let ratio = row[at].parse::<f64>().map_err(|_| format!("{name}, {column}: {:?}", row[at]))?;
            longest = longest.max(ratio);
            bars.push((peer, ratio));
        }
        panels.push((words, &row[1..4], bars));
    }
    let height = HEAD + panels.len().div_ceil(2) * PANEL.1;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\n\
         <title>Time of a frame in trisap and five other broad phases</title>\n<style>{STYLE}</style>\n\
         <text class=\"h\" x=\"0\" y=\"20\">Time of a frame, as a multiple of trisap's. Shorter is better.</text>\n\
         <text class=\"s\" x=\"0\" y=\"40\">The same boxes, side by side in one process on one thread; every pair of every side is checked.</text>\n"
    );
    for (number, (words, figures, bars)) in panels.iter().enumerate() {
        let (x, y) = (number % 2 * PANEL.0, HEAD + number / 2 * PANEL.1);
        let [objects, pairs, ms] = figures else { unreachable!("three figures") };
        let (objects, pairs) = (grouped(objects), grouped(pairs));
        _ = writeln!(
            svg,
            "<g transform=\"translate({x} {y})\"><text class=\"t\" x=\"0\" y=\"14\">{words}</text>"
        );
        _ = writeln!(
            svg,
            "<text class=\"s\" x=\"0\" y=\"31\">{objects} boxes, {pairs} pairs; trisap {ms} ms</text>"
        );
        for (row, (who, ratio)) in [("trisap", 1.0)].iter().chain(bars).enumerate() {
            let (class, y) = (if row == 0 { "us" } else { "peer" }, 40 + row * ROW);
            let (length, text) = ((ratio * BARS.1 / longest).max(1.0), y + 12);
            let digits = if *ratio < 10.0 && row > 0 { 1 + usize::from(*ratio < 1.0) } else { 0 };
            _ = writeln!(
                svg,
                "<text class=\"e {class_of_text}\" x=\"{}\" y=\"{text}\">{who}</text>\
                 <rect class=\"{class}\" x=\"{}\" y=\"{y}\" width=\"{length:.1}\" height=\"15\" rx=\"2\"/>\
                 <text class=\"{class_of_text}\" x=\"{:.1}\" y=\"{text}\">{ratio:.digits$}</text>",
                BARS.0 - 6,
                BARS.0,
                BARS.0 as f64 + length + 5.0,
                class_of_text = if row == 0 { "us" } else { "" },
            );
        }
        svg += "</g>\n";
    }
    Ok(svg + "</svg>\n")
}

/// A whole number with commas.
fn grouped(number: &str) -> String {
    let mut text = String::new();
    for (at, digit) in number.chars().enumerate() {
        if at > 0 && (number.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_in_the_table_is_named() {
        let head = "| scene | objects | pairs | trisap, ms | PhysX ABP |\n|---|--:|\n";
        assert_eq!(svg(""), Err("there is no table of scenes".to_owned()));
        assert_eq!(svg(head), Err("no scene synthetic pile".to_owned()));
        let row = format!("{head}| synthetic pile | 8000 | 5 | 0.1 | wrong |\n");
        assert_eq!(svg(&row), Err("synthetic pile, PhysX ABP: \"wrong\"".to_owned()));
        assert_eq!(["8", "800", "8000", "1234567"].map(grouped), ["8", "800", "8,000", "1,234,567"]);
    }
}
