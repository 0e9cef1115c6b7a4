//! `trisap layout`: prints the bytes that worlds need.

use crate::Outcome;
use crate::args::LayoutArgs;
use crate::figures::grouped;
use anyhow::Result;
use std::io::{Write, stdout};
use trisap::{Capacity, Config, Index};

pub(crate) fn layout(args: &LayoutArgs) -> Result<Outcome> {
    let mut out = stdout().lock();
    writeln!(
        out,
        "{:>11} {:>11} {:>15} {:>15} {:>11}",
        "objects", "pairs", "u16 bytes", "u32 bytes", "an object"
    )?;
    for &objects in &args.objects {
        let capacity = Capacity { pairs: objects.saturating_mul(4), ..Capacity::for_objects(objects) };
        let config = Config::new(capacity);
        let (narrow, wide) = (bytes::<u16>(&config), bytes::<u32>(&config));
        let an_object = narrow.or(wide).map(|bytes| bytes as f64 / f64::from(objects.max(1)));
        writeln!(
            out,
            "{:>11} {:>11} {:>15} {:>15} {:>11}",
            grouped(objects.into()),
            grouped(capacity.pairs.into()),
            or_dash(narrow.map(|bytes| grouped(bytes as u64))),
            or_dash(wide.map(|bytes| grouped(bytes as u64))),
            or_dash(an_object.map(|bytes| format!("{bytes:.1}"))),
        )?;
    }
    Ok(Outcome::Good)
}

fn bytes<I: Index>(config: &Config) -> Option<usize> {
    trisap::layout::<I>(config).map(|layout| layout.bytes)
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".into())
}
