//! The command line.

use crate::{clock::Clock, peers, scenes};
use std::path::PathBuf;

pub(crate) const USAGE: &str = "\
usage: trisap-peers [options] SCENE...
       trisap-peers --table [options] [SCENE...]
a scene: a recording (FILE.aabbs), or KIND:OBJECTS:COUNT for a synthetic one, as in brownian:cubes:32000
(kinds: brownian, freefall, gravity; objects: cubes, assorted), or SCENE:COUNT
for one of those of games, as in town:28000 (`trisap run --help` lists them), or speed:EDGES:COUNT for cubes that go on
by so many of their edges a frame
  --kernels auto|NAME   the level that trisap uses (scalar, avx2, ...); auto: the best of this CPU
  --events auto|on|off  whether trisap tells found and lost pairs; auto: against peers that do
  --margin SHARE        the margin of trisap's objects as a share of their extent, in exact mode; by default none
  --movers N            only N objects move, and only their boxes are handed over, to peers that can be told of few
  --threads 1|2         threads for trisap and for the peers; peers without threads are left out at 2
  --peers A,B           only peers whose names contain one of these
  --table               a line for each scene, with nothing but ratios; all recordings of the repository and a synthetic
                        scene of each kind, if no scene is given
  --once                pairs of boxes that are there once, in processes of their own (parry3d, rstar, CGAL); takes no scene
  --queries             box queries and rays on the first frame instead of the race (trisap, parry3d, Embree)
  --clock wall|cpu      cpu: the time that the process has had of the CPU, for machines where others run; one thread only
  --frames N            timed frames a peer; by default about two million boxes, 15 to 300 frames
  --json FILE           writes the results as JSON as well";

/// Whether trisap tells found and lost pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Events {
    /// Against peers that do.
    Auto,
    On,
    Off,
}

#[derive(Debug)]
pub(crate) struct Options {
    pub(crate) scenes: Vec<String>,
    /// `None`: the best of this CPU.
    pub(crate) kernels: Option<String>,
    pub(crate) events: Events,
    /// Of the objects of trisap, a share of their extent.
    pub(crate) margin: Option<f32>,
    /// How many objects move; `None`: all.
    pub(crate) movers: Option<usize>,
    pub(crate) threads: u32,
    /// Ratios alone, with a line for each scene.
    pub(crate) table: bool,
    /// Queries instead of frames.
    pub(crate) queries: bool,
    /// Boxes that are there once instead of scenes; and in a process for one side of that, which one, with how many boxes.
    pub(crate) once: bool,
    pub(crate) once_side: Option<[usize; 2]>,
    peers: Vec<String>,
    pub(crate) clock: Clock,
    pub(crate) frames: Option<usize>,
    pub(crate) json: Option<PathBuf>,
}

impl Options {
    pub(crate) fn parse(arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            scenes: Vec::new(),
            kernels: None,
            events: Events::Auto,
            margin: None,
            movers: None,
            threads: 1,
            table: false,
            queries: false,
            once: false,
            once_side: None,
            peers: Vec::new(),
            clock: Clock::Wall,
            frames: None,
            json: None,
        };
        let mut arguments = arguments;
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
            match argument.as_str() {
                "--kernels" => options.kernels = Some(value()?).filter(|name| name != "auto"),
                "--events" => {
                    options.events = match value()?.as_str() {
                        "auto" => Events::Auto,
                        "on" => Events::On,
                        "off" => Events::Off,
                        other => return Err(format!("--events {other}: auto, on or off")),
                    }
                }
                "--margin" => {
                    let share = value()?;
                    options.margin =
                        Some(share.parse().map_err(|_| format!("--margin {share}: a share of the extent"))?);
                }
                "--threads" => {
                    options.threads = match value()?.as_str() {
                        "1" => 1,
                        "2" => 2,
                        other => return Err(format!("--threads {other}: 1 or 2")),
                    }
                }
                "--clock" => {
                    options.clock = match value()?.as_str() {
                        "wall" => Clock::Wall,
                        "cpu" => Clock::Cpu,
                        other => return Err(format!("--clock {other}: wall or cpu")),
                    }
                }
                "--table" => options.table = true,
                "--queries" => options.queries = true,
                "--once" => options.once = true,
                "--once-side" => {
                    let number = |value: String| value.parse().map_err(|_| format!("{value}: no number"));
                    options.once_side = Some([number(value()?)?, above_zero("--once-side", &value()?)?]);
                }
                "--peers" => options.peers = value()?.split(',').map(str::to_lowercase).collect(),
                "--frames" => options.frames = Some(above_zero("--frames", &value()?)?),
                "--movers" => options.movers = Some(above_zero("--movers", &value()?)?),
                "--json" => options.json = Some(value()?.into()),
                flag if flag.starts_with('-') => return Err(format!("unknown option {flag}")),
                _ => options.scenes.push(argument),
            }
        }
        if options.threads > 1 && options.clock == Clock::Cpu {
            return Err("--clock cpu adds up the threads: it is for one".into());
        }
        if options.table && options.scenes.is_empty() {
            options.scenes =
                scenes::all().map_err(|error| format!("the recordings of the repository: {error}"))?;
        }
        if options.scenes.is_empty() && !options.once && options.once_side.is_none() {
            return Err("no scene given".into());
        }
        Ok(options)
    }

    /// The peers that were asked for.
    pub(crate) fn entries(&self) -> Vec<peers::Entry> {
        let asked = |name: &str| self.peers.iter().any(|part| name.to_lowercase().contains(part));
        peers::all().into_iter().filter(|entry| self.peers.is_empty() || asked(entry.name)).collect()
    }
}

fn above_zero(option: &str, value: &str) -> Result<usize, String> {
    value.parse().ok().filter(|&count| count > 0).ok_or_else(|| format!("{option}: a number above zero"))
}
