//! Runs a scene on many ranks: `mpirun -n 4 trisap-mpi-run --scene gravity -n 100000 --check`.

mod args;
mod check;
mod network;
mod source;
mod table;

use args::{Args, FaultArg};
use check::Reference;
use clap::Parser;
use mpi::Threading;
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use rayon::ThreadPoolBuilder;
use rustix::time::{ClockId, clock_gettime};
use source::{Frame, Source};
use std::error::Error;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use table::Sums;
use trisap::{Capacity, Config, Executor, Rayon, Serial, Stage};
use trisap_mpi::{Settings, SplitWorld};

/// How often the first rank tells how far it is.
const TELL: Duration = Duration::from_secs(2);

fn main() -> ExitCode {
    let args = Args::parse();
    // Threads of a rank never call MPI, but for the first one.
    let Some((universe, _)) = mpi::initialize_with_threading(Threading::Funneled) else {
        eprintln!("MPI cannot be started");
        return ExitCode::FAILURE;
    };
    let comm = universe.world();
    match run(&args, &comm) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // In one piece, as others write, too.
            let line = format!("trisap-mpi-run: rank {}: {error}\n", comm.rank());
            eprint!("{line}");
            // What all ranks know they have printed; whoever does not know must not wait.
            std::thread::sleep(Duration::from_millis(200));
            comm.abort(1)
        }
    }
}

fn settings(args: &Args, rank: usize, objects: u32) -> Settings {
    let capacity = args.room.map_or_else(
        || Capacity::for_objects(objects),
        |room| Capacity::for_objects(room).with_leaf_refs(room).with_pairs(room),
    );
    let usual = Settings::default();
    let other = args.fault.as_ref().is_some_and(|fault| fault.kind == "version" && fault.rank == rank);
    Settings {
        config: Config::new(capacity).with_workers(args.threads),
        balance: !args.fixed_planes,
        overlap: match args.overlap.as_str() {
            "never" => Some(false),
            "always" => Some(true),
            _ => None,
        },
        timeout: Duration::from_secs_f32(args.timeout),
        version: usual.version + u32::from(other),
    }
}

fn run(args: &Args, comm: &SimpleCommunicator) -> Result<(), Box<dyn Error>> {
    let (rank, ranks) = (comm.rank() as usize, comm.size() as usize);
    if args.processes {
        println!("rank {rank} is process {}", std::process::id());
    }
    if args.network {
        network::print(comm);
        return Ok(());
    }
    let mut source = Source::new(args)?;
    let more = args.threads as usize - 1;
    let pool = (more > 0).then(|| ThreadPoolBuilder::new().num_threads(more).build()).transpose()?;
    let pool = pool.as_ref().map(Rayon::in_pool);
    let executor: &dyn Executor = pool.as_ref().map_or(&Serial, |pool| pool);
    let settings = settings(args, rank, args.n / ranks as u32 + 1024);
    let mut world = match &args.load {
        Some(folder) => load(folder, comm, &settings, executor)?,
        None => SplitWorld::new(comm, &settings)?,
    };
    if rank == 0 {
        println!("{}, {} frames, {ranks} ranks", source.name, source.frames);
    }
    let mut reference = None;
    let mut sums = Sums::default();
    let mut totals = [0_u64; 4];
    let (mut told, mut at, frames) = (Instant::now(), 0, source.frames);
    while let Some(frame) = source.next()? {
        at += 1;
        if args.check && rank == 0 && reference.is_none() {
            reference = Some(Reference::new(frame.boxes.len() as u32)?);
        }
        let expected = reference.as_mut().map(|reference| reference.step(frame)).transpose()?;
        if args.load.is_some() && at <= args.from {
            continue;
        }
        let fault = args.fault.as_ref().filter(|fault| fault.rank == rank && fault.frame == at);
        world.meet();
        let (begun, processor) = (Instant::now(), processor_time());
        give(&mut world, frame, at)?;
        if fault.is_some_and(|fault| fault.kind == "key") {
            let taken = (0..frame.boxes.len() as u64).find(|key| !world.owns(*key)).ok_or("all are here")?;
            world.insert(taken, frame.boxes[taken as usize])?;
        }
        let given = [begun.elapsed().as_secs_f64(), processor_time() - processor];
        world.step(trisap::Kernels::detect(), &Faulty { fault, executor })?;
        let mut pairs = 0;
        world.visit_pairs(|_| pairs += 1);
        let counts = [pairs, world.found().len() as u64, world.lost().len() as u64];
        if at > args.warm_up {
            sums.add(world.stats(), counts, given);
        }
        if args.check {
            let answer = check::answer(&mut world)?;
            if let Some(difference) = expected.and_then(|expected| answer.difference(&expected)) {
                return Err(format!("frame {at}: {difference}").into());
            }
            let counts = answer.counts();
            (0..3).for_each(|index| totals[index] += counts[index]);
            totals[3] += 1;
        }
        if rank == 0 && told.elapsed() > TELL {
            told = Instant::now();
            eprintln!("frame {at} of {frames}");
        }
    }
    if let Some(folder) = &args.save {
        fs::create_dir_all(folder)?;
        world.save(BufWriter::new(File::create(folder.join(format!("rank{rank}.trisap")))?))?;
    }
    world.meet();
    sums.print(comm);
    if args.check && rank == 0 {
        let [pairs, found, lost, frames] = totals;
        println!("checked: {frames} frames, {pairs} pairs, {found} found, {lost} lost, all as in one world");
    }
    Ok(())
}

/// The seconds that this thread has had a processor.
fn processor_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Gives a frame's boxes: new ones to any rank, the others to their owners.
fn give(world: &mut SplitWorld, frame: &Frame, time: u64) -> Result<(), Box<dyn Error>> {
    for key in &frame.gone {
        if world.owns(*key) {
            world.remove(*key)?;
        }
    }
    world.update(|key, _| frame.boxes[key as usize])?;
    for key in &frame.come {
        if (key * 7 + time) % world.ranks() as u64 == world.rank() as u64 {
            world.insert(*key, frame.boxes[*key as usize])?;
        }
    }
    Ok(())
}

/// The saved objects. Each rank takes every so many of the files.
fn load(
    folder: &Path,
    comm: &SimpleCommunicator,
    settings: &Settings,
    executor: &dyn Executor,
) -> Result<SplitWorld, Box<dyn Error>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)? {
        paths.push(entry?.path());
    }
    paths.sort();
    let mine = paths.iter().skip(comm.rank() as usize).step_by(comm.size() as usize);
    let files = mine.map(|path| File::open(path).map(BufReader::new)).collect::<Result<Vec<_>, _>>()?;
    Ok(SplitWorld::load(comm, settings, files, trisap::Kernels::detect(), executor)?)
}

/// The threads of a rank, and where a test asks for it, a fault in the middle of a sweep.
struct Faulty<'f> {
    executor: &'f dyn Executor,
    fault: Option<&'f FaultArg>,
}

impl Executor for Faulty<'_> {
    fn workers(&self) -> u32 {
        self.executor.workers()
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.executor.fork_join(width, job);
    }

    fn enter(&self, stage: Stage) {
        let kind = self.fault.filter(|_| stage == Stage::Results).map(|fault| fault.kind.as_str());
        match kind {
            Some("die") => std::process::abort(),
            Some("hang") => std::thread::sleep(Duration::from_secs(3600)),
            _ => {}
        }
        self.executor.enter(stage);
    }
}
