//! What predicted boxes gain or cost: `cargo run --release -p trisap-runs --bin still -- [NAME [ROUNDS [FIRST LAST]]]`.
//!
//! Each frame of each scene whose name has `NAME` in it is stepped by a world with predicted boxes and by one without, in turn, in
//! so many rounds. A line has the least times of each step of all rounds, with over without: the median, the mean, and the slowest
//! step over the median without. The first steps make the tree and are not counted. With `FIRST` and `LAST`, what these steps did.

use std::cell::Cell;
use std::time::Instant;
use trisap::scene::real::{Ground, Kind as Real, Scene, Setup as RealSetup};
use trisap::scene::{Kind, Objects, Setup, Synthetic};
use trisap_core::{Aabb, Boxes, Config, Executor, Id, Serial, Stage, World};
use trisap_tests::recordings;
use trisap_tests::scenes::{self, Rng, at, shifted, uniform};
use trisap_tests::worlds::{Slab, ample};

/// Steps that are not counted.
const WARM: usize = 4;
/// Counted frames of a scene that has no end.
const FRAMES: usize = 60;

/// What happens before a step. Objects are numbered as they came.
#[derive(Default)]
struct Frame {
    shift: f32,
    removed: Vec<usize>,
    inserted: Vec<Aabb>,
    changed: Vec<(usize, Aabb)>,
    /// Whether changed boxes are given one by one.
    one_by_one: bool,
    /// All boxes, in worlds in which none comes or goes.
    over: Vec<Aabb>,
}

struct Case {
    name: String,
    frames: Vec<Frame>,
}

fn case(name: impl Into<String>, frames: impl IntoIterator<Item = Frame>) -> Case {
    Case { name: name.into(), frames: frames.into_iter().collect() }
}

/// All boxes are handed over in each step.
fn over(name: impl Into<String>, frames: Vec<Vec<Aabb>>) -> Case {
    let first = Frame { inserted: frames[0].clone(), ..Frame::default() };
    let frames = frames.into_iter().map(|over| Frame { over, ..Frame::default() });
    case(name, [first].into_iter().chain(frames))
}

fn recorded() -> Vec<Case> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers/recordings");
    let engine = ["joint_grid", "large_pyramid", "washer"];
    let engine = engine.map(|name| recordings::read(&folder.join(format!("engine_{name}.aabbs"))));
    let all = engine.into_iter().chain(recordings::all()).map(|recording| {
        let count = recording.frames.len();
        // Where there are few, there and back: there all turn at once.
        let take = if count < 30 + WARM { FRAMES + WARM } else { count };
        let frames = (0..count).chain((0..count).rev()).cycle().take(take);
        over(recording.name.clone(), frames.map(|frame| recording.boxes(frame)).collect())
    });
    all.collect()
}

fn real(kind: Real, count: u32) -> Case {
    let mut scene = Scene::new(RealSetup { kind, count, seed: 1 }).expect("there is such a scene");
    let frames = (0..FRAMES + WARM).map(|_| {
        scene.advance();
        scene.boxes().to_vec()
    });
    over(format!("{kind} {count}"), frames.collect())
}

fn synthetic(kind: Kind, objects: Objects, count: u32) -> Case {
    let mut scene = Synthetic::new(Setup { kind, objects, count, seed: 1 });
    let frames = (0..FRAMES + WARM).map(|_| {
        scene.advance();
        scene.boxes().to_vec()
    });
    over(format!("{} {} {count}", kind.name(), objects.name()), frames.collect())
}

/// Cubes that go on, each by so many edges a step.
fn speed(speed: f32) -> Case {
    let (mut boxes, mut rng) = (uniform(8000, 5), Rng::new(6));
    let ways: Vec<[f32; 3]> = boxes.iter().map(|_| rng.in_ball().map(|x| x * speed)).collect();
    let frames = (0..FRAMES + WARM).map(|_| {
        boxes.iter_mut().zip(&ways).for_each(|(aabb, way)| *aabb = shifted(aabb, *way));
        boxes.clone()
    });
    over(format!("speed {speed}"), frames.collect())
}

/// Cubes that go on, of which a tenth leaps once in 16 steps: ones that no sample of the step sees.
fn leaps(count: usize) -> Case {
    let (mut boxes, mut rng) = (uniform(count, 5), Rng::new(6));
    boxes.iter_mut().for_each(|aabb| *aabb = at(aabb.min.map(|x| 0.5 * x), [1.0; 3]));
    let ways: Vec<[f32; 3]> = boxes.iter().map(|_| rng.in_ball().map(|x| x * 0.001)).collect();
    let frames = (0..FRAMES + WARM).map(|frame| {
        boxes.iter_mut().zip(&ways).for_each(|(aabb, way)| *aabb = shifted(aabb, *way));
        if frame % 16 == 15 {
            let leapers = boxes
                .iter_mut()
                .enumerate()
                .filter(|(at, _)| (20..30).contains(&(64 * at % count * 100 / count)));
            leapers.for_each(|(_, aabb)| *aabb = shifted(aabb, rng.point(-1.0, 1.0)));
        }
        boxes.clone()
    });
    over(format!("leaps {count}"), frames.collect())
}

/// Of 32,000 cubes, other ones move in each step.
fn others(thousandths: usize) -> Case {
    let (mut boxes, mut rng) = (uniform(32_000, 7), Rng::new(8));
    let first = Frame { inserted: boxes.clone(), ..Frame::default() };
    let frames = (0..FRAMES + WARM).map(|_| {
        let movers = (0..32 * thousandths).map(|_| {
            let at = rng.below(boxes.len());
            boxes[at] = shifted(&boxes[at], rng.point(-0.2, 0.2));
            (at, boxes[at])
        });
        Frame { changed: movers.collect(), ..Frame::default() }
    });
    case(format!("ids, {thousandths} in 1,000 others"), [first].into_iter().chain(frames))
}

/// All boxes of a scene one by one.
fn one_by_one(name: &str, of: &Case) -> Case {
    let frames = of.frames.iter().map(|frame| Frame {
        inserted: frame.inserted.clone(),
        changed: frame.over.iter().copied().enumerate().collect(),
        one_by_one: true,
        ..Frame::default()
    });
    case(name, frames)
}

/// Objects come at one end and go at the other, by columns; those between lie still.
fn window(shifts: bool) -> Case {
    const COLUMN: usize = 1024;
    let mut rng = Rng::new(9);
    let mut ahead = 0.0;
    let mut column = |ahead: f32| -> Vec<Aabb> {
        (0..COLUMN)
            .map(|_| {
                at([ahead + rng.between(0.0, 16.0), rng.between(0.0, 32.0), rng.between(0.0, 32.0)], [1.0; 3])
            })
            .collect()
    };
    let frames = (0..FRAMES + WARM).map(|frame| {
        let columns = if frame == 0 { 32 } else { 1 };
        let mut next = Frame { inserted: Vec::new(), ..Frame::default() };
        for _ in 0..columns {
            next.inserted.extend(column(ahead));
            ahead += 16.0;
        }
        if frame > 0 {
            next.removed = ((frame - 1) * COLUMN..frame * COLUMN).collect();
        }
        if shifts && frame % 16 == 15 {
            next.shift = 256.0;
            ahead -= 256.0;
        }
        next
    });
    let frames = frames.collect::<Vec<_>>();
    case(if shifts { "ids, window with shifts" } else { "ids, window" }, frames)
}

/// One in twenty goes and another one comes elsewhere, while the others move or not.
fn spawn(moves: bool) -> Case {
    let (mut rng, count) = (Rng::new(10), 16_000);
    let side = scenes::side(count);
    let mut live: Vec<(usize, Aabb)> = uniform(count, 11).into_iter().enumerate().collect();
    let first = Frame { inserted: live.iter().map(|(_, aabb)| *aabb).collect(), ..Frame::default() };
    let mut number = count;
    let frames = (0..FRAMES + WARM).map(|_| {
        let mut next = Frame::default();
        for going in 0..count / 20 {
            // Another one in each twentieth of them, so that none goes before it has come.
            let at_live = 20 * going + rng.below(20);
            let aabb = at(rng.point(0.0, side), [1.0; 3]);
            next.removed.push(live[at_live].0);
            next.inserted.push(aabb);
            live[at_live] = (number, aabb);
            number += 1;
        }
        if moves {
            live.iter_mut().for_each(|(_, aabb)| *aabb = shifted(aabb, rng.point(-0.01, 0.01)));
            next.changed = live.clone();
        }
        next
    });
    case(if moves { "ids, spawn among moving" } else { "ids, spawn" }, [first].into_iter().chain(frames))
}

/// How long a step was in each stage, in µs.
struct Stages {
    entered: Cell<Option<(Stage, Instant)>>,
    spent: [Cell<f64>; Stage::ALL.len()],
}

impl Executor for Stages {
    fn workers(&self) -> u32 {
        1
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        Serial.fork_join(width, job);
    }

    fn enter(&self, stage: Stage) {
        if let Some((former, since)) = self.entered.replace(Some((stage, Instant::now()))) {
            let spent = &self.spent[former as usize];
            spent.set(spent.get() + 1e6 * since.elapsed().as_secs_f64());
        }
    }
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// One round: the time of each step, in µs, and what it did.
fn round(case: &Case, worlds: &mut [World<'_>], least: &mut [Vec<f64>], shown: Option<(usize, usize)>) {
    let mut ids: Vec<Vec<Id>> = vec![Vec::new(); worlds.len()];
    let mut given = Vec::new();
    for (at, frame) in case.frames.iter().enumerate() {
        let mut pairs = None;
        for which in 0..worlds.len() {
            // Who was first has warmed the boxes.
            let which = (which + at) % worlds.len();
            let (world, ids) = (&mut worlds[which], &mut ids[which]);
            // The caller has just written them.
            given.clone_from(&frame.over);
            let start = Instant::now();
            if frame.shift != 0.0 {
                world.shift_origin([frame.shift.into(), 0.0, 0.0]).expect("finite");
            }
            for &number in &frame.removed {
                world.remove(ids[number]).expect("alive");
            }
            ids.extend(world.insert_many(Boxes::new(&frame.inserted)).expect("room"));
            if frame.one_by_one {
                for &(number, aabb) in &frame.changed {
                    world.set_aabb(ids[number], aabb).expect("alive");
                }
            } else if !frame.changed.is_empty() {
                let (those, boxes): (Vec<Id>, Vec<Aabb>) =
                    frame.changed.iter().map(|&(number, aabb)| (ids[number], aabb)).unzip();
                world.update_many(&those, Boxes::new(&boxes)).expect("alive");
            }
            let stages = Stages { entered: Cell::new(None), spent: Default::default() };
            let shows = shown.is_some_and(|(first, last)| (first..last).contains(&at));
            let stepper = world.on(if shows { &stages } else { &Serial });
            let step =
                if frame.over.is_empty() { stepper.step() } else { stepper.step_over(Boxes::new(&given)) };
            let step = step.expect("room for the pairs");
            let time = 1e6 * start.elapsed().as_secs_f64();
            let stats = step.stats();
            assert_eq!(*pairs.get_or_insert(stats.pairs), stats.pairs, "{}", case.name);
            least[which][at] = least[which][at].min(time);
            if shows {
                let spent = stages.spent.each_ref().map(|spent| spent.get() as u32);
                println!(
                    "{at} {which}: {:.0} µs {spent:?} {:?} {:?}, {} moved, {} left, {} pairs and {}, {} candidates, {} copies",
                    least[which][at],
                    stats.path,
                    stats.reason,
                    stats.moved,
                    stats.outran,
                    stats.pairs,
                    stats.surplus,
                    stats.candidates,
                    stats.copies
                );
            }
        }
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize| arguments.get(at).map(|text| text.parse::<usize>().expect("a number"));
    let (name, rounds) = (arguments.first().cloned().unwrap_or_default(), number(1).unwrap_or(5));
    let shown = number(2).zip(number(3));
    let mut cases = recorded();
    let [washer, grid] = [2, 0].map(|at| &cases[at]);
    let by_id = [one_by_one("ids, washer one by one", washer), one_by_one("ids, grid one by one", grid)];
    cases.extend([Ground::None, Ground::Infinite].map(|ground| real(Real::Ground(ground), 8000)));
    let kinds = [
        (Real::Town, 28_000),
        (Real::Flat, 16_000),
        (Real::Level, 8000),
        (Real::Pile, 8000),
        (Real::Grains, 30_000),
    ];
    cases.extend(kinds.map(|(kind, count)| real(kind, count)));
    cases.extend([(Real::Bullets, 8000), (Real::LogNormal, 8000)].map(|(kind, count)| real(kind, count)));
    cases.extend([8000, 128_000].map(|count| synthetic(Kind::Brownian, Objects::Cubes, count)));
    cases.extend([1000, 8000].map(|count| synthetic(Kind::FreeFall, Objects::Cubes, count)));
    cases.push(synthetic(Kind::Gravity, Objects::Assorted, 8000));
    cases.extend([0.0, 0.001, 0.01, 0.03, 0.1, 0.3, 0.9].map(speed));
    cases.extend([8000, 32_000].map(leaps));
    cases.extend(by_id);
    cases.extend([others(10), others(60), window(false), window(true), spawn(false), spawn(true)]);
    println!(
        "{:<28} {:<6} {:>9} {:>9} {:>7} {:>7} {:>7}",
        "", "", "with, µs", "without", "median", "mean", "slowest"
    );
    for case in cases.iter().filter(|case| case.name.contains(&name)) {
        let objects = case.frames[0].inserted.len() + case.frames[1].inserted.len();
        for events in [false, true] {
            let mut config = Config::new(ample(objects, 40 * objects));
            config.events = events;
            let configs = [config, config.without_predicted_boxes()];
            let mut least = vec![vec![f64::MAX; case.frames.len()]; configs.len()];
            for turn in 1..=rounds {
                let mut slabs = configs.map(|config| Slab::new::<u32>(&config));
                let mut worlds = slabs
                    .iter_mut()
                    .zip(&configs)
                    .map(|(slab, config)| slab.world(config))
                    .collect::<Vec<_>>();
                round(case, &mut worlds, &mut least, shown.filter(|_| turn == rounds));
            }
            let [with, without] = [&least[0][WARM..], &least[1][WARM..]];
            let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
            let slowest = with.iter().copied().fold(0.0, f64::max);
            println!(
                "{:<28} {:<6} {:>9.1} {:>9.1} {:>7.3} {:>7.3} {:>7.2}",
                case.name,
                if events { "events" } else { "" },
                median(with),
                median(without),
                median(with) / median(without),
                mean(with) / mean(without),
                slowest / median(without)
            );
        }
    }
}
