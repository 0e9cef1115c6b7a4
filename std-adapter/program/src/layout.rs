//! `trisap layout`: prints the bytes that worlds need.

use crate::Outcome;
use crate::args::LayoutArgs;
use crate::figures::grouped;
use anyhow::Result;
use std::io::{Write, stdout};
use trisap::{Capacity, Config, Index};

/// Four pairs an object; a lean world; the widths of slots, each without and with found and lost pairs; bytes an object
/// of the first that there is.
const TITLES: [&str; 8] =
    ["objects", "pairs", "u16 lean", "u16", "u16 events", "u32", "u32 events", "an object"];

pub(crate) fn layout(args: &LayoutArgs) -> Result<Outcome> {
    let mut out = stdout().lock();
    row(&mut out, TITLES.map(String::from))?;
    for &objects in &args.objects {
        let capacity = Capacity::for_objects(objects).with_pairs(objects.saturating_mul(4));
        let exact = Config::new(capacity);
        let events = exact.with_events();
        let narrow = [&exact.with_lean(), &exact, &events].map(bytes::<u16>);
        let wide = [&exact, &events].map(bytes::<u32>);
        let bytes = [narrow[0], narrow[1], narrow[2], wide[0], wide[1]];
        let [a, b, c, d, e] = bytes.map(|bytes| or_dash(bytes.map(|bytes| grouped(bytes as u64))));
        let each = bytes.iter().flatten().next().map(|&bytes| bytes as f64 / f64::from(objects.max(1)));
        let each = or_dash(each.map(|each| format!("{each:.1}")));
        row(&mut out, [grouped(objects.into()), grouped(capacity.pairs.into()), a, b, c, d, e, each])?;
    }
    Ok(Outcome::Good)
}

fn row(out: &mut impl Write, cells: [String; TITLES.len()]) -> Result<()> {
    let line: Vec<String> = cells.iter().map(|cell| format!("{cell:>14}")).collect();
    Ok(writeln!(out, "{}", line.join(" "))?)
}

fn bytes<I: Index>(config: &Config) -> Option<usize> {
    trisap::layout::<I>(config).map(|layout| layout.bytes)
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".into())
}
