//! The command line.

use clap::Parser;
use std::path::PathBuf;
use std::str::FromStr;

/// Runs a scene on the ranks of mpirun, and tells what each of them had to do.
#[derive(Clone, Debug, Parser)]
#[command(name = "trisap-mpi-run")]
pub(crate) struct Args {
    /// brownian, freefall, gravity; one of the scenes of games (town, level, ground:inf, ...); or one for tests: scatter,
    /// unbounded, corner, lives
    #[arg(long, default_value = "brownian", conflicts_with = "file")]
    pub(crate) scene: String,
    /// A recording instead of a scene
    #[arg(long)]
    pub(crate) file: Option<PathBuf>,
    /// Boxes of different shapes, in brownian, freefall and gravity
    #[arg(long)]
    pub(crate) assorted: bool,
    /// How many boxes
    #[arg(short, default_value_t = 1000)]
    pub(crate) n: u32,
    /// How many frames; all of a recording
    #[arg(long)]
    pub(crate) frames: Option<u64>,
    /// Another seed gives other random numbers
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Compares pairs, found and lost with those of one world in each frame
    #[arg(long)]
    pub(crate) check: bool,
    /// Frames at the start that do not count in the table
    #[arg(long, default_value_t = 3)]
    pub(crate) warm_up: u64,
    /// Leaves the planes where the first frame puts them
    #[arg(long)]
    pub(crate) fixed_planes: bool,
    /// Threads of each rank. Times of the processor are those of the thread that calls, without the others
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(crate) threads: u32,
    /// Whether to sweep while messages travel: auto, never or always
    #[arg(long, default_value = "auto", value_parser = ["auto", "never", "always"])]
    pub(crate) overlap: String,
    /// Room for so many objects and pairs at first, on each rank
    #[arg(long)]
    pub(crate) room: Option<u32>,
    /// Ends all ranks after so many seconds without an answer
    #[arg(long, default_value_t = 60.0)]
    pub(crate) timeout: f32,
    /// Has each rank save its objects in this folder after the last frame
    #[arg(long)]
    pub(crate) save: Option<PathBuf>,
    /// Goes on from the objects in this folder
    #[arg(long)]
    pub(crate) load: Option<PathBuf>,
    /// The frame after which they were saved
    #[arg(long, default_value_t = 0)]
    pub(crate) from: u64,
    /// Prints what messages between ranks cost, and nothing else
    #[arg(long)]
    pub(crate) network: bool,
    /// Prints the process of each rank
    #[arg(long)]
    pub(crate) processes: bool,
    /// For tests, KIND@RANK:FRAME: the rank dies or hangs in the middle of a step, tells of another version, or is given an
    /// object that there is already; KIND is die, hang, version or key
    #[arg(long, hide = true)]
    pub(crate) fault: Option<FaultArg>,
}

/// What goes wrong, where and when.
#[derive(Clone, Debug)]
pub(crate) struct FaultArg {
    pub(crate) kind: String,
    pub(crate) rank: usize,
    pub(crate) frame: u64,
}

impl FromStr for FaultArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('@').and_then(|(kind, rest)| Some((kind, rest.split_once(':')?)));
        let (kind, (rank, frame)) = parts.ok_or("KIND@RANK:FRAME")?;
        let number = |_| "a rank and a frame are numbers".to_owned();
        Ok(Self {
            kind: kind.to_owned(),
            rank: rank.parse().map_err(number)?,
            frame: frame.parse().map_err(number)?,
        })
    }
}
