//! `trisap pairs`: prints the pairs of boxes in a file of text, or of one frame of a scene.

use crate::Outcome;
use crate::args::PairsArgs;
use crate::drive::{Frame, Visitor, drive};
use crate::progress;
use crate::setup::Engine;
use crate::source::Source;
use anyhow::{Context, Result, bail, ensure};
use indicatif::ProgressBar;
use std::fs;
use std::io::{BufWriter, Write, stdout};
use trisap::{Capacity, Config, Pair, Scratch};

pub(crate) fn pairs(args: &PairsArgs) -> Result<Outcome> {
    let pairs = match text(args)? {
        Some(boxes) => once(&boxes, args)?,
        None => of_frame(args)?,
    };
    let mut out = BufWriter::new(stdout().lock());
    for [a, b] in pairs {
        writeln!(out, "{a} {b}")?;
    }
    out.flush()?;
    Ok(Outcome::Good)
}

/// The boxes of a file of text; `None` of anything else, and where a frame is asked for, which only recordings have.
fn text(args: &PairsArgs) -> Result<Option<Vec<[f64; 6]>>> {
    let Some(path) = args.scene.file.as_ref().filter(|_| args.frame.is_none()) else { return Ok(None) };
    let name = path.display();
    let bytes = fs::read(path).with_context(|| name.to_string())?;
    // The names in the header of a recording end with zeros.
    let Some(text) = str::from_utf8(&bytes).ok().filter(|text| !text.contains('\0')) else { return Ok(None) };
    let (mut boxes, mut first) = (Vec::new(), true);
    for (number, line) in text.lines().map(str::trim).enumerate() {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let parts = line.split([',', ';', ' ', '\t']).map(str::trim).filter(|part| !part.is_empty());
        let numbers: Result<Vec<f64>, _> = parts.map(str::parse).collect();
        match numbers.ok().and_then(|numbers| numbers.try_into().ok()) {
            Some(numbers) => boxes.push(numbers),
            None if first && line.contains(char::is_alphabetic) => {}
            None => bail!("{name}, line {}: not six numbers: {line}", number + 1),
        }
        first = false;
    }
    Ok(Some(boxes))
}

/// The pairs of boxes without a scene, ascending.
fn once(boxes: &[[f64; 6]], args: &PairsArgs) -> Result<Vec<Pair>> {
    let engine = Engine::new(&args.engine)?;
    let mut pairs = engine
        .with_executor(|executor| Scratch::new().on(executor).pairs(boxes).map(|pairs| pairs.to_vec()))?;
    pairs.sort_unstable();
    Ok(pairs)
}

fn of_frame(args: &PairsArgs) -> Result<Vec<Pair>> {
    let frame = args.frame.context("--frame says which frame of the scene")?;
    let engine = Engine::new(&args.engine)?;
    let mut source = Source::of(&args.scene, Some(frame.saturating_add(1)))?;
    let frames = source.frames();
    ensure!(
        frame < frames,
        "{}: there is no frame {frame}; there are frames 0 to {}",
        source.name(),
        frames - 1
    );
    let config = Config::new(Capacity::for_objects(source.objects())).with_workers(args.engine.threads);
    let mut wanted = Wanted { frame, pairs: Vec::new(), bar: progress::bar(frame + 1, "stepping") };
    drive(&mut source, config, &engine, &mut wanted)?;
    wanted.bar.finish_and_clear();
    Ok(wanted.pairs)
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
