//! What a step would take with many workers: a model, see `trisap_tests::workers`. The times are those of threads that run one at a
//! time, so caches are those of one processor, and memory is not shared. Brownian cubes, all moving, with events.
//! `cargo run --release -p trisap-runs --bin workers [OBJECTS]... [--wake MICROSECONDS] [--jobs]`

use std::error::Error;
use trisap::model::{Course, Job, Workers, nanoseconds};
use trisap_core::{Boxes, Capacity, Config, Kernels, Stage};
use trisap_tests::scenes::Brownian;
use trisap_tests::worlds::Slab;

/// Steps that are measured; the first ones make planes and lists.
const STEPS: usize = 24;
const FIRST: usize = 6;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut sizes, mut wake, mut jobs, mut only) = (Vec::new(), 2, false, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--wake" => wake = words.next().ok_or("how many microseconds?")?.parse()?,
            "--jobs" => jobs = true,
            "--only" => only = Some(words.next().ok_or("how many workers?")?.parse()?),
            size => sizes.push(size.parse()?),
        }
    }
    if sizes.is_empty() {
        sizes = vec![8_000, 32_000, 128_000];
    }
    println!("A model. Workers begin {wake} us after the caller. Milliseconds, medians of {STEPS} steps.");
    for size in sizes {
        println!("{size} objects\nworkers  intake   build    fill   sweep results    step  serial  speed-up");
        let mut alone = 0.0;
        for workers in if let Some(only) = only { vec![only] } else { vec![1, 2, 4, 8, 12, 16, 32] } {
            let courses = measure(size, workers, wake * 1000)?;
            let stages = [Stage::Intake, Stage::Build, Stage::Fill, Stage::Sweep, Stage::Results]
                .map(|stage| median(courses.iter().map(|course| course.of(stage) as f64 / 1e6)));
            let step = median(courses.iter().map(|course| course.length() as f64 / 1e6));
            let serial = median(courses.iter().map(|course| course.serial.iter().sum::<u64>() as f64 / 1e6));
            if workers == 1 {
                alone = step;
            }
            print!("{workers:7}");
            stages.iter().for_each(|stage| print!(" {stage:7.3}"));
            // What no worker can take over, of the step of one.
            let share = if workers == 1 { 100.0 } else { 100.0 * serial / alone };
            println!(" {step:7.3} {share:6.1}%  {:8.2}", alone / step);
            if jobs && workers > 1 {
                print_jobs(&courses);
            }
        }
    }
    Ok(())
}

/// The jobs of the last step and the serial parts, in microseconds.
fn print_jobs(courses: &[Course]) {
    let Some(course) = courses.last() else { return };
    for stage in Stage::ALL.into_iter().filter(|&stage| stage != Stage::Done) {
        let serial = median(courses.iter().map(|course| course.serial[stage as usize] as f64 / 1e3));
        println!("        {stage:?}: serial {serial:.1}");
        for (at, Job { width, claims, .. }) in course.jobs_of(stage).enumerate() {
            let of = |read: fn(&Job) -> u64| {
                median(
                    courses
                        .iter()
                        .filter_map(|course| course.jobs_of(stage).nth(at))
                        .map(|job| read(job) as f64 / 1e3),
                )
            };
            let (work, span) = (of(|job| job.work), of(|job| job.span));
            println!(
                "            {width} workers, {claims} claims, work {work:.1}, span {span:.1}, {:.2} times",
                work / span
            );
        }
    }
}

fn measure(size: usize, workers: u32, wake: u64) -> Result<Vec<Course>, Box<dyn Error>> {
    let capacity = Capacity::for_objects(size as u32).with_pairs(8 * size as u32);
    let config = Config::new(capacity).with_events().with_workers(workers);
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    world.set_kernels(Kernels::detect());
    let mut scene = Brownian::new(size, 1);
    world.insert_many(Boxes::new(scene.boxes()))?;
    let executor = Workers::new(workers, wake, nanoseconds);
    let mut courses = Vec::new();
    for step in 0..FIRST + STEPS {
        let boxes = Boxes::new(scene.advance());
        executor.begin();
        world.on(&executor).step_over(boxes)?;
        if step >= FIRST {
            courses.push(executor.course());
        }
    }
    Ok(courses)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
