//! What `trisap run` has found out, for people and for programs.

use crate::figures::{counted, grouped, median, quantile};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};

#[derive(Serialize)]
pub(crate) struct Summary {
    pub(crate) scene: String,
    pub(crate) objects: u32,
    pub(crate) frames: usize,
    pub(crate) settings: Settings,
    /// Times of a step, the intake of all boxes included.
    pub(crate) step_ms: Times,
    pub(crate) ns_per_object: f64,
    /// The median time of each stage.
    pub(crate) stages_ms: BTreeMap<String, f64>,
    /// With several threads: the median time of what only one of them can do.
    pub(crate) unshared_ms: Option<f64>,
    pub(crate) pairs: Counts,
    pub(crate) found: Option<Counts>,
    pub(crate) lost: Option<Counts>,
    /// The median share of the objects that moved.
    pub(crate) moved_share: f64,
    /// Frames by path.
    pub(crate) paths: BTreeMap<String, u32>,
    /// Medians of a frame.
    pub(crate) leaves: u32,
    pub(crate) copies: u64,
    pub(crate) candidates: u64,
    pub(crate) surplus: u64,
    pub(crate) large: u32,
    pub(crate) bytes: Bytes,
    /// Boxes that were refused, in all frames.
    pub(crate) rejected: u64,
    /// Frames with boxes that are too small for `f32` where they stand.
    pub(crate) coarse_frames: usize,
    pub(crate) check: Option<Check>,
}

#[derive(Serialize)]
pub(crate) struct Settings {
    pub(crate) mode: &'static str,
    /// Share of the largest extent.
    pub(crate) margin: Option<f32>,
    pub(crate) events: bool,
    pub(crate) threads: u32,
    pub(crate) kernels: &'static str,
    pub(crate) index_bits: u32,
    pub(crate) pair_capacity: u32,
}

/// The first step builds the tree; the other figures are of the steps after it.
#[derive(Serialize)]
pub(crate) struct Times {
    first: f64,
    median: f64,
    p95: f64,
    worst: f64,
}

impl Times {
    pub(crate) fn of(values: &[f64]) -> Self {
        let later = after_first(values);
        Self {
            first: values.first().copied().unwrap_or_default(),
            median: median(later),
            p95: quantile(later, 0.95),
            worst: quantile(later, 1.0),
        }
    }

    pub(crate) fn median(&self) -> f64 {
        self.median
    }
}

/// All but the first value, as far as there are others.
pub(crate) fn after_first<T>(values: &[T]) -> &[T] {
    match values {
        [_, later @ ..] if !later.is_empty() => later,
        all => all,
    }
}

#[derive(Serialize)]
pub(crate) struct Counts {
    median: u64,
    most: u64,
    total: u64,
}

impl Counts {
    pub(crate) fn of(values: impl Iterator<Item = u64>) -> Self {
        let values: Vec<_> = values.collect();
        Self { median: median(&values), most: quantile(&values, 1.0), total: values.iter().sum() }
    }
}

#[derive(Serialize)]
pub(crate) struct Bytes {
    pub(crate) world: usize,
    pub(crate) per_object: f64,
    /// The same with room for no pair.
    pub(crate) per_object_without_pairs: f64,
}

#[derive(Serialize)]
pub(crate) struct Check {
    /// What the pairs were compared with.
    pub(crate) method: &'static str,
    pub(crate) passed: bool,
    pub(crate) pairs: u64,
    /// What is wrong.
    pub(crate) wrong: Option<String>,
}

impl Summary {
    pub(crate) fn write_json(&self, mut out: impl Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut out, self)?;
        writeln!(out)
    }

    pub(crate) fn write_text(&self, mut out: impl Write) -> io::Result<()> {
        let set = &self.settings;
        let margin = set.margin.map_or("no margin".into(), |share| format!("margin {share} of the extent"));
        let events = if set.events { "events" } else { "no events" };
        let objects = counted(u64::from(self.objects), "object");
        let frames = counted(self.frames as u64, "frame");
        writeln!(out, "{}: {objects}, {frames}", self.scene)?;
        writeln!(
            out,
            "world    {} pairs, {margin}, {events}; {} kernels, {}, {}-bit indices",
            set.mode,
            set.kernels,
            counted(u64::from(set.threads), "thread"),
            set.index_bits
        )?;
        let step = &self.step_ms;
        writeln!(
            out,
            "step     median {:.3} ms ({:.1} ns an object), 95 % within {:.3} ms, worst {:.3} ms; the first took {:.3} ms",
            step.median, self.ns_per_object, step.p95, step.worst, step.first
        )?;
        let mut stages: Vec<_> = self.stages_ms.iter().filter(|(_, time)| **time > 0.0).collect();
        stages.sort_by(|a, b| b.1.total_cmp(a.1));
        let stages: Vec<_> = stages.iter().map(|(stage, time)| format!("{stage} {time:.3} ms")).collect();
        writeln!(out, "stages   medians: {}", stages.join(", "))?;
        if let Some(unshared) = self.unshared_ms {
            writeln!(out, "serial   median {unshared:.3} ms of a step are not shared")?;
        }
        let an_object = self.pairs.median as f64 / f64::from(self.objects);
        writeln!(
            out,
            "pairs    median {} ({an_object:.2} an object), most {}",
            grouped(self.pairs.median),
            grouped(self.pairs.most)
        )?;
        if let (Some(found), Some(lost)) = (&self.found, &self.lost) {
            writeln!(
                out,
                "events   median {} found and {} lost; {} and {} in all",
                grouped(found.median),
                grouped(lost.median),
                grouped(found.total),
                grouped(lost.total)
            )?;
        }
        let paths: Vec<_> = self.paths.iter().map(|(path, frames)| format!("{path} {frames}")).collect();
        writeln!(
            out,
            "moved    median {:.1} % of the objects; frames by path: {}",
            100.0 * self.moved_share,
            paths.join(", ")
        )?;
        writeln!(
            out,
            "work     medians: {}, {}, {}, {}, {}",
            match self.leaves {
                1 => "1 leaf".into(),
                leaves => format!("{} leaves", grouped(u64::from(leaves))),
            },
            match self.copies {
                1 => "1 copy".into(),
                copies => format!("{} copies", grouped(copies)),
            },
            counted(self.candidates, "candidate"),
            counted(self.surplus, "surplus pair"),
            counted(u64::from(self.large), "large object"),
        )?;
        writeln!(
            out,
            "memory   {:.1} bytes an object, {:.1} without the pairs; {} in all, with room for {} pairs",
            self.bytes.per_object,
            self.bytes.per_object_without_pairs,
            grouped(self.bytes.world as u64),
            grouped(u64::from(set.pair_capacity))
        )?;
        if self.rejected > 0 {
            writeln!(
                out,
                "refused  {} times a box with NaN or a minimum above its maximum",
                grouped(self.rejected)
            )?;
        }
        if self.coarse_frames > 0 {
            writeln!(
                out,
                "warning  boxes too far from the origin for their size in {}",
                counted(self.coarse_frames as u64, "frame")
            )?;
        }
        match &self.check {
            Some(Check { wrong: Some(wrong), method, .. }) => {
                writeln!(out, "check    FAILED against {method}: {wrong}")
            }
            Some(check) => writeln!(
                out,
                "check    passed: the pairs of every frame are those of {} ({} pairs compared)",
                check.method,
                grouped(check.pairs)
            ),
            None => Ok(()),
        }
    }
}
