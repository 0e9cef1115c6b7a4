//! `trisap pairs`: prints the pairs of one frame.

use crate::Outcome;
use crate::args::PairsArgs;
use crate::drive::{Frame, Visitor, drive};
use crate::progress;
use crate::setup::Engine;
use crate::source::Source;
use anyhow::{Result, ensure};
use indicatif::ProgressBar;
use std::io::{BufWriter, Write, stdout};
use trisap::{Capacity, Config, Pair};

pub(crate) fn pairs(args: &PairsArgs) -> Result<Outcome> {
    let engine = Engine::new(&args.engine)?;
    let mut source = Source::of(&args.scene, Some(args.frame.saturating_add(1)))?;
    let frames = source.frames();
    ensure!(
        args.frame < frames,
        "{}: there is no frame {}; there are frames 0 to {}",
        source.name(),
        args.frame,
        frames - 1
    );
    let config = Config::new(Capacity::for_objects(source.objects())).with_workers(args.engine.threads);
    let mut wanted =
        Wanted { frame: args.frame, pairs: Vec::new(), bar: progress::bar(args.frame + 1, "stepping") };
    drive(&mut source, config, &engine, &mut wanted)?;
    wanted.bar.finish_and_clear();

    let mut out = BufWriter::new(stdout().lock());
    for [a, b] in wanted.pairs {
        writeln!(out, "{a} {b}")?;
    }
    out.flush()?;
    Ok(Outcome::Good)
}

/// Keeps the pairs of one frame.
struct Wanted {
    frame: u32,
    pairs: Vec<Pair>,
    bar: ProgressBar,
}

impl Visitor for Wanted {
    fn start(&mut self) {
        self.bar.reset();
    }

    fn visit(&mut self, frame: &Frame<'_>) -> Result<bool> {
        self.bar.inc(1);
        let last = frame.number == self.frame;
        if last {
            self.pairs = frame.pairs.all.sorted();
        }
        Ok(!last)
    }
}
