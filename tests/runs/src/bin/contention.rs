//! What a second thread gains when the processors are free, and what it costs when others want them: one thread and two in
//! alternating runs of the same steps, first alone, then beside a process that is always busy.
//! `cargo run --release -p trisap-runs --bin contention [OBJECTS]... [--runs RUNS]`

use std::env::args;
use std::error::Error;
use std::mem;
use std::process::{Child, Command};
use std::time::{Duration, Instant};
use trisap::scene::{Kind, Objects, Setup, Synthetic};
use trisap::{Aabb, Boxes, Capacity, Config, Executor, OwnedWorld, Rayon, Serial};

/// What the process that stays busy is started with.
const BUSY: &str = "--busy";
/// The least time of a run.
const RUN: Duration = Duration::from_millis(300);
/// The sizes of the table in NOTEBOOK.md.
const SIZES: [usize; 4] = [8_000, 32_000, 128_000, 1_024_000];

/// Ends the process with the measurement.
struct Neighbour(Child);

impl Neighbour {
    fn start() -> std::io::Result<Self> {
        Command::new(std::env::current_exe()?).arg(BUSY).spawn().map(Self)
    }
}

impl Drop for Neighbour {
    fn drop(&mut self) {
        // If it has ended already, all is well.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    if args().any(|arg| arg == BUSY) {
        loop {
            std::hint::spin_loop();
        }
    }
    let mut runs = 9;
    let mut sizes = Vec::new();
    let mut words = args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--runs" => runs = words.next().ok_or("how many runs?")?.parse()?,
            size => sizes.push(size.parse()?),
        }
    }
    if sizes.is_empty() {
        sizes = SIZES.to_vec();
    }
    println!(
        "objects  beside   one (ms)  two (ms)   gain  worst  over 3x: one, two   shared  alone  losses  gain of a shared step"
    );
    for size in sizes {
        measure(size, runs, false)?;
        let neighbour = Neighbour::start()?;
        measure(size, runs, true)?;
        drop(neighbour);
    }
    Ok(())
}

/// The frames of a scene, to be played forwards and backwards.
fn frames(size: usize) -> Vec<Vec<Aabb>> {
    let count = if size > 200_000 { 4 } else { 16 };
    let setup = Setup { kind: Kind::Brownian, objects: Objects::Cubes, count: size as u32, seed: 1 };
    let mut scene = Synthetic::new(setup);
    (0..count)
        .map(|_| {
            let frame = scene.boxes().to_vec();
            scene.advance();
            frame
        })
        .collect()
}

/// Prints a line: the medians of all runs' mean times of a step.
fn measure(size: usize, runs: usize, busy: bool) -> Result<(), Box<dyn Error>> {
    let frames = frames(size);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let rayon = Rayon::in_pool(&pool);
    let config = Config::new(Capacity::for_objects(size as u32).with_pairs(8 * size as u32));
    let mut worlds = [OwnedWorld::<u32>::new(&config)?, OwnedWorld::new(&config.with_workers(2))?];
    let executors: [&dyn Executor; 2] = [&Serial, &rayon];
    for owned in &mut worlds {
        owned.world().insert_many(Boxes::new(&frames[0]))?;
    }
    let (mut means, mut steps) = ([const { Vec::new() }; 2], [const { Vec::<f64>::new() }; 2]);
    // The steps that were in fact shared.
    let (mut shared, mut together) = (0, Vec::new());
    // The first run warms up.
    for run in 0..=runs {
        for turn in 0..2 {
            let mut world = worlds[turn].world();
            let (begun, mut count) = (Instant::now(), 0);
            let mut spent = Duration::ZERO;
            while spent < RUN || count < 3 {
                let last = frames.len() - 1;
                let at = count % (2 * last);
                let step = Instant::now();
                world.on(executors[turn]).step_over(Boxes::new(&frames[at.min(2 * last - at)]))?;
                let time = step.elapsed().as_secs_f64() * 1e3;
                if run > 0 {
                    steps[turn].push(time);
                    let now = rayon.sharing().shared;
                    if now > mem::replace(&mut shared, now) {
                        together.push(time);
                    }
                }
                count += 1;
                spent = begun.elapsed();
            }
            if run > 0 {
                means[turn].push(spent.as_secs_f64() * 1e3 / count as f64);
            }
        }
    }
    let gains = means[0].iter().zip(&means[1]).map(|(one, two)| one / two);
    let worst = gains.fold(f64::INFINITY, f64::min);
    let limit = 3.0 * median(&steps[0]);
    // Of a thousand steps.
    let over = |turn: usize| {
        1e3 * steps[turn].iter().filter(|&&time| time > limit).count() as f64 / steps[turn].len() as f64
    };
    let (one, two) = (median(&means[0]), median(&means[1]));
    let sharing = rayon.sharing();
    println!(
        "{size:7}  {}  {one:8.3}  {two:8.3}  {:5.2}  {worst:5.2}  {:7.1}, {:.1} of 1000  {:6}  {:5}  {:6}  {:5.2}",
        if busy { "busy  " } else { "nobody" },
        one / two,
        over(0),
        over(1),
        sharing.shared,
        sharing.alone,
        sharing.losses,
        if together.is_empty() { f64::NAN } else { median(&steps[0]) / median(&together) },
    );
    Ok(())
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
