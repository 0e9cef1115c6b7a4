//! What each rank had to do, at the end.

use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use trisap_mpi::{Stage, Stats};

const STAGES: usize = Stage::ALL.len();
const COLUMNS: [&str; 14] = [
    "objects",
    "ghosts",
    "pairs",
    "found",
    "lost",
    "arrived",
    "told",
    "bytes",
    "needed",
    "messages",
    "far",
    "collective",
    "planes",
    "overlaps",
];
/// The times of the stages, to give boxes and of the frame; first as they pass, then of the processor.
const TIMES: usize = STAGES + 2;
const ALL: usize = COLUMNS.len() + 2 * TIMES;

/// Sums over the frames that count.
#[derive(Default)]
pub(crate) struct Sums {
    frames: u64,
    numbers: [f64; ALL],
}

impl Sums {
    /// Adds a frame: what the step tells, its pairs and events, and the seconds to give the boxes.
    pub(crate) fn add(&mut self, stats: &Stats, [pairs, found, lost]: [u64; 3], boxes: [f64; 2]) {
        self.frames += 1;
        let counts = [
            stats.objects,
            stats.ghosts,
            pairs,
            found,
            lost,
            stats.arrived,
            stats.told,
            stats.bytes,
            stats.bytes_needed,
            stats.messages,
            stats.far,
            stats.collectives,
            u64::from(stats.planes_moved),
            u64::from(stats.overlapped),
        ];
        let counts = counts.map(|count| count as f64);
        let times =
            [(stats.times, boxes[0]), (stats.processor, boxes[1])].into_iter().flat_map(|(times, boxes)| {
                let stages = times.map(|time| time.as_secs_f64());
                let frame = stages.iter().sum::<f64>() + boxes;
                stages.into_iter().chain([boxes, frame]).map(|time| time * 1e3)
            });
        let all = counts.into_iter().chain(times);
        self.numbers.iter_mut().zip(all).for_each(|(sum, number)| *sum += number);
    }

    /// Prints the means of all ranks on the first one. All ranks have to call it.
    pub(crate) fn print(&self, comm: &SimpleCommunicator) {
        let frames = self.frames.max(1) as f64;
        let mine = self.numbers.map(|sum| sum / frames);
        let ranks = comm.size() as usize;
        let mut all = vec![0.0; ALL * ranks];
        comm.all_gather_into(&mine[..], &mut all[..]);
        if comm.rank() != 0 {
            return;
        }
        println!("means of {} frames", self.frames);
        print!("{:>6}", "rank");
        COLUMNS.iter().for_each(|name| print!(" {name:>10}"));
        println!();
        for rank in 0..ranks {
            print!("{rank:>6}");
            all[rank * ALL..][..COLUMNS.len()].iter().for_each(|number| print!(" {number:>10.1}"));
            println!();
        }
        let column = |index: usize| (0..ranks).map(move |rank| rank * ALL + index);
        let total = |index: usize| column(index).map(|at| all[at]).sum::<f64>();
        print!("{:>6}", "all");
        (0..COLUMNS.len()).for_each(|index| print!(" {:>10.1}", total(index)));
        println!();
        for (what, first) in [("passed", COLUMNS.len()), ("of the processor", COLUMNS.len() + TIMES)] {
            println!("milliseconds {what} by stage");
            print!("{:>6}", "rank");
            let names = Stage::ALL.map(Stage::name).into_iter().chain(["boxes", "frame"]);
            names.for_each(|name| print!(" {name:>11}"));
            println!();
            for rank in 0..ranks {
                print!("{rank:>6}");
                all[rank * ALL + first..][..TIMES].iter().for_each(|time| print!(" {time:>11.3}"));
                println!();
            }
        }
        let slowest = |index: usize| column(index).map(|at| all[at]).fold(0.0, f64::max);
        println!(
            "frame {:.3} ms, of the processor {:.3} ms, ghosts {:.2} % of the objects, bytes {:.3} of what is needed, {:.1} for each object told",
            slowest(COLUMNS.len() + TIMES - 1),
            slowest(ALL - 1),
            100.0 * total(1) / total(0).max(1.0),
            total(7) / total(8).max(1.0),
            total(7) / total(6).max(1.0)
        );
    }
}
