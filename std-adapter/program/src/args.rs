//! The command line.

pub(crate) use crate::scene_name::{BroadmarkName, SceneName};
use clap::{Args as Group, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use trisap::scene::Objects;

/// Finds all overlapping pairs of moving boxes, in recorded and synthetic scenes.
///
/// Without a command: `trisap run --check` on the recording that is built in.
///
/// Exit codes: 0 success, 1 a check failed, 2 wrong usage or input.
#[derive(Debug, Parser)]
#[command(name = "trisap", version)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Step through all frames of a scene and report times, counts and memory.
    ///
    /// The scene is a recording, a synthetic scene (--scene), or the recording that is built in. Synthetic scenes move
    /// boxes without a physics engine; for real motion, see `trisap record`.
    #[command(after_long_help = WORDS)]
    Run(RunArgs),
    /// Write a page that shows a scene in motion, boxes that overlap lit: for a browser, without a server.
    View(ViewArgs),
    /// Print the overlapping pairs of boxes: `a b` a line, a < b, ascending.
    ///
    /// Of a file of text, with six numbers a line (minimum x, y, z, maximum x, y, z, parted by commas, semicolons or blanks, in `f64`,
    /// rounded outward to `f32`), or of one frame of a scene. Lines that are empty or begin with # do not count, nor does a
    /// first line with names of columns.
    Pairs(PairsArgs),
    /// Record a rigid-body simulation.
    Record(RecordArgs),
    /// Print the bytes that a world needs.
    Layout(LayoutArgs),
    /// Measure how fast and how right trisap is here, and write a page with figures and the data beside it.
    ///
    /// Exit code 1 where a single pair is missed anywhere. The times are worth something where nothing else runs.
    Report(ReportArgs),
}

/// Of the report of `trisap run`.
const WORDS: &str = "\
Words of the report:
  stages      intake: reads the boxes and sees who has moved. build: chooses the planes of the tree. fill: brings moved boxes to
              their leaves. sweep: finds the pairs, leaf by leaf. results: sorts out pairs and events.
  path        how a step found its pairs. unchanged: nobody has moved. lists: a small world, swept as one list. movers: few have
              moved, and each was tested alone. movers by leaf: more have, and most pairs stay. full: all leaves were swept.
              rebuilt: the same after new planes, as in the first step.
  leaves      parts of space, each with some hundred objects.
  copies      boxes that were also swept in leaves other than their own, as they reach into these.
  candidates  pairs that overlap on one axis and were tested on the others. Few more than pairs is good.
  surplus     pairs of boxes with their margins whose boxes do not overlap.
  large       boxes that reach into so many leaves that they stand in a list of their own.";

impl Command {
    /// What happens without a command.
    pub(crate) fn shipped() -> Self {
        Self::Run(RunArgs { check: true, ..RunArgs::default() })
    }
}

/// Where boxes come from.
#[derive(Debug, Default, Group)]
pub(crate) struct SceneArgs {
    /// A recording; without it, and without --scene, the one that is built in. For `pairs` also boxes as text, or CSV.
    #[arg(value_name = "FILE", conflicts_with = "scene")]
    pub(crate) file: Option<PathBuf>,
    /// A synthetic scene.
    #[arg(long, value_name = "KIND")]
    pub(crate) scene: Option<SceneName>,
    /// The boxes of brownian, freefall and gravity [default: cubes].
    #[arg(long, requires = "scene")]
    pub(crate) objects: Option<ObjectsName>,
    /// The number of boxes of the synthetic scene [default: 1000].
    #[arg(short, value_name = "N", requires = "scene", value_parser = clap::value_parser!(u32).range(1..=MAX_COUNT))]
    pub(crate) n: Option<u32>,
    /// The seed of the synthetic scene [default: 1].
    #[arg(long, requires = "scene")]
    pub(crate) seed: Option<u64>,
}

#[derive(Debug, Default, Group)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The most frames to step [default: all of a recording, 100 of a synthetic scene].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub(crate) frames: Option<u32>,
    #[command(flatten)]
    pub(crate) engine: EngineArgs,
    /// Whether pairs are those of the boxes, or those of the boxes with their margins.
    #[arg(long, default_value = "exact")]
    pub(crate) mode: ModeName,
    /// How far a box may move before it counts as moved, as a share of its largest extent [default: none in exact
    /// mode, 0.1 in fat mode].
    #[arg(long, value_parser = margin)]
    pub(crate) margin: Option<f32>,
    /// Also find out which pairs are new and which are gone.
    #[arg(long)]
    pub(crate) events: bool,
    /// Compare the pairs of every frame with an independent method: brute force up to 4,000 boxes, an own sweep above.
    #[arg(long)]
    pub(crate) check: bool,
    /// Print the report as JSON.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print what a step would take with 1 to 32 workers, by stage: a model, beside two threads of this machine.
    #[arg(long, conflicts_with_all = ["check", "json", "dump_svg", "threads"])]
    pub(crate) workers_model: bool,
    /// With it, also the jobs of a step and its serial parts, in microseconds.
    #[arg(long, requires = "workers_model")]
    pub(crate) jobs: bool,
    /// Draw a frame, counted from 0, cut through its middle across its thinnest axis: the leaves and planes of the tree, and
    /// the boxes.
    #[arg(long, num_args = 2, value_names = ["FRAME", "FILE.svg"])]
    pub(crate) dump_svg: Option<Vec<String>>,
}

#[derive(Debug, Group)]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The most frames to show.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1 << 12))]
    pub(crate) frames: u32,
    /// The page to write.
    #[arg(long, value_name = "FILE.html", default_value = "trisap-view.html")]
    pub(crate) out: PathBuf,
    /// Also open it in the browser.
    #[arg(long)]
    pub(crate) open: bool,
}

#[derive(Debug, Group)]
pub(crate) struct EngineArgs {
    /// Threads to step with.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(crate) threads: u32,
    /// Instruction set: auto, scalar, sse4.1, avx2, as far as this CPU has it.
    #[arg(long, default_value = "auto")]
    pub(crate) kernels: String,
}

impl Default for EngineArgs {
    fn default() -> Self {
        Self { threads: 1, kernels: "auto".into() }
    }
}

#[derive(Debug, Group)]
pub(crate) struct PairsArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The frame of a scene, counted from 0. All frames before it are stepped too.
    #[arg(long, value_parser = clap::value_parser!(u32).range(0..1 << 20))]
    pub(crate) frame: Option<u32>,
    #[command(flatten)]
    pub(crate) engine: EngineArgs,
}

#[derive(Debug, Group)]
pub(crate) struct RecordArgs {
    /// What happens.
    #[arg(long)]
    pub(crate) scene: BroadmarkName,
    /// Which boxes there are.
    #[arg(long, default_value = "cubes")]
    pub(crate) objects: ObjectsName,
    /// The number of boxes. Above 32,000 they must come from splitting fewer bodies into 8 boxes each, once or more often.
    #[arg(short, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=MAX_COUNT))]
    pub(crate) n: u32,
    /// The number of frames, at 30 a second.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub(crate) frames: u32,
    /// Frames to simulate before the first one that is recorded.
    #[arg(long, default_value_t = 0)]
    pub(crate) skip: u32,
    /// The seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The file to write.
    #[arg(long, value_name = "FILE.aabbs")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Group)]
pub(crate) struct LayoutArgs {
    /// Numbers of objects; four pairs an object.
    #[arg(required = true, value_name = "N")]
    pub(crate) objects: Vec<u32>,
}

#[derive(Debug, Group)]
pub(crate) struct ReportArgs {
    /// Leaves out recorded simulations, worlds of more than 64,000 boxes and points between others on most charts, and times
    /// each a tenth as long: less than 45 seconds where nothing else runs.
    #[arg(long)]
    pub(crate) quick: bool,
    /// The folder for report.html, report.json, the tables as CSV, and the recordings that were made.
    #[arg(long, value_name = "DIR", default_value = "trisap-report")]
    pub(crate) out: PathBuf,
    /// Only this section; may be given more than once [default: all].
    #[arg(long = "section", value_name = "NAME")]
    pub(crate) sections: Vec<SectionName>,
    /// As little as possible, to see whether all experiments work.
    #[arg(long, hide = true)]
    pub(crate) least: bool,
}

/// The sections of a report, in their order on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SectionName {
    RealScenes,
    Scaling,
    Paper,
    Movers,
    Speeds,
    Threads,
    Parts,
    HardCases,
    Precision,
    Ties,
    Margins,
}

/// The most objects that a world can hold.
const MAX_COUNT: i64 = 1 << 27;

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ObjectsName {
    /// Unit cubes.
    Cubes,
    /// Cubes, bars, planks, squares and random boxes.
    Assorted,
}

impl From<ObjectsName> for Objects {
    fn from(name: ObjectsName) -> Self {
        match name {
            ObjectsName::Cubes => Self::Cubes,
            ObjectsName::Assorted => Self::Assorted,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum)]
pub(crate) enum ModeName {
    /// Exactly the overlaps of the boxes.
    #[default]
    Exact,
    /// The overlaps of the boxes with their margins.
    Fat,
}

fn margin(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(margin) if (0.0..=f32::MAX).contains(&margin) => Ok(margin),
        _ => Err("a margin is a finite number, 0 or more".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Args::command().debug_assert();
    }
}
