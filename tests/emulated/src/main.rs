//! Compares the kernels of the core on the emulated machine: operation by operation, and over whole steps and queries, whose
//! results have to be the same bytes. Prints what it compared, and the instructions that the steps took.

#![no_std]
#![no_main]

mod machine;
mod scenes;

use core::fmt::Write;
use core::ops::ControlFlow;
use machine::Console;
use scenes::Random;
use trisap_core::{
    Aabb, Boxes, Capacity, Cast, Config, Error, Index, InlineWorld, Kernels, Margin, Mode, Pair, Region,
    World,
};

/// The most objects of a world.
const OBJECTS: usize = 8000;
/// Steps through a scene that is made.
const STEPS: usize = 7;

struct Memory {
    slab: InlineWorld<{ 32 << 20 }>,
    boxes: [Aabb; OBJECTS],
}

static mut MEMORY: Memory =
    Memory { slab: InlineWorld::EMPTY, boxes: [Aabb::new([0.0; 3], [0.0; 3]); OBJECTS] };

/// 64-bit FNV-1a, a word at a time.
struct Digest(u64);

impl Digest {
    fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0000_01b3);
    }

    /// The length keeps apart what follows one another.
    fn pairs<I: Index>(&mut self, pairs: &[Pair<I>]) {
        self.word(pairs.len() as u64);
        for [a, b] in pairs {
            self.word(u64::from(a.slot()) << 32 | u64::from(b.slot()));
        }
    }
}

/// What a run came to.
#[derive(Clone, Copy)]
struct Outcome {
    hash: u64,
    pairs: u64,
    /// Of all steps but the first one, which builds.
    instructions: u64,
}

/// A run through some frames.
struct Run<'w, 'm, I: Index> {
    world: &'w mut World<'m, I>,
    digest: Digest,
    pairs: u64,
    instructions: u64,
    steps: u32,
}

impl<'w, 'm, I: Index> Run<'w, 'm, I> {
    fn new(world: &'w mut World<'m, I>, kernels: Kernels) -> Self {
        world.set_kernels(kernels);
        Self { world, digest: Digest(0xcbf2_9ce4_8422_2325), pairs: 0, instructions: 0, steps: 0 }
    }

    fn step(&mut self, boxes: Boxes<'_>) -> Result<(), Error> {
        if self.steps == 0 {
            self.world.insert_many(boxes)?;
        }
        let before = machine::instructions();
        let step = self.world.step_over(boxes)?;
        let after = machine::instructions();
        if self.steps > 0 {
            self.instructions += after - before;
        }
        self.steps += 1;
        self.pairs += step.pairs().len() as u64;
        self.digest.pairs(step.pairs());
        self.digest.pairs(step.found());
        self.digest.pairs(step.lost());
        Ok(())
    }

    /// Asks some questions about the last step, and adds the answers.
    fn ask(&mut self, reach: f32) -> Result<(), Error> {
        let mut random = Random(5);
        for _ in 0..20 {
            let (from, to) = (random.point(0.0, reach), random.point(-reach, 2.0 * reach));
            let direction = [0, 1, 2].map(|k| to[k] - from[k]);
            let start = Aabb::new(from, from.map(|x| x + 0.5));
            for cast in [Cast::ray(from, direction, 1.0), Cast::swept(start, direction)] {
                let digest = &mut self.digest;
                self.world.visit_hits(&cast, &mut |hit| {
                    digest.word(hit.id.to_bits());
                    digest.word(hit.distance.to_bits());
                    1.0
                })?;
            }
            let region = Region::Aabb(Aabb::new(from, from.map(|x| x + 2.0)));
            let digest = &mut self.digest;
            self.world.visit_overlaps(&region, &mut |id| {
                digest.word(id.to_bits());
                ControlFlow::Continue(())
            })?;
        }
        Ok(())
    }

    fn outcome(self) -> Outcome {
        Outcome { hash: self.digest.0, pairs: self.pairs, instructions: self.instructions }
    }
}

fn config(objects: usize, pairs: usize) -> Config {
    let objects = objects as u32;
    Config::new(Capacity::for_objects(objects).with_leaf_refs(8 * objects).with_pairs(pairs as u32))
}

/// Steps through a recording.
fn replay<I: Index>(
    memory: &mut Memory,
    kernels: Kernels,
    config: &Config,
    frames: &mut dyn Iterator<Item = Boxes<'_>>,
) -> Result<Outcome, Error> {
    let mut world = memory.slab.init::<I>(config)?;
    let mut run = Run::new(&mut world, kernels);
    for boxes in frames {
        run.step(boxes)?;
    }
    run.ask(30.0)?;
    Ok(run.outcome())
}

/// Steps through a scene that is made.
fn play<I: Index>(
    memory: &mut Memory,
    kernels: Kernels,
    config: &Config,
    (_, objects, aabb): scenes::Scene,
) -> Result<Outcome, Error> {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let boxes = &mut memory.boxes[..objects];
    boxes.iter_mut().enumerate().for_each(|(index, place)| *place = aabb(&mut random, index));
    let mut world = memory.slab.init::<I>(config)?;
    let mut run = Run::new(&mut world, kernels);
    for step in 0..STEPS {
        run.step(Boxes::new(boxes))?;
        scenes::advance(boxes, step, &mut random);
    }
    run.ask(30.0)?;
    Ok(run.outcome())
}

/// Compares one run on all levels, and prints a row: the instructions an object and step.
fn compare(
    name: &str,
    mode: &str,
    objects_steps: u64,
    mut run: impl FnMut(Kernels) -> Result<Outcome, Error>,
) -> Result<bool, Error> {
    let mut scalar = None;
    let mut same = true;
    for kernels in Kernels::all() {
        let outcome = run(kernels)?;
        if scalar.is_none() {
            let _ = write!(Console, "| {name} | {mode} | {} |", outcome.pairs);
        }
        let expected = *scalar.get_or_insert(outcome);
        if (outcome.hash, outcome.pairs) == (expected.hash, expected.pairs) {
            let _ = write!(Console, " {} |", outcome.instructions / objects_steps);
        } else {
            let _ = write!(Console, " DIFFERS |");
            same = false;
        }
    }
    let _ = writeln!(Console);
    Ok(same)
}

/// Compares the operations of all levels with the scalar ones.
fn operations() -> bool {
    let mut same = true;
    for level in Kernels::all() {
        let mut differing = [""; 32];
        level.disagreements(2, 1_000, &mut |name| {
            if let Some(place) = differing.iter_mut().find(|place| place.is_empty() || **place == name) {
                *place = name;
            }
        });
        let _ = write!(Console, "operations of {} that differ from scalar ones:", level.name());
        for name in differing.into_iter().filter(|name| !name.is_empty()) {
            let _ = write!(Console, " {name}");
            same = false;
        }
        let _ = writeln!(Console, ".");
    }
    same
}

fn recordings(memory: &mut Memory) -> Result<bool, Error> {
    let mut same = true;
    for (name, objects, bytes) in scenes::RECORDINGS {
        let plain = config(objects, 20 * objects);
        let events = plain.with_events();
        let fat = events.with_margin(Margin::share(0.1)).with_mode(Mode::Fat);
        let steps = objects as u64 * (scenes::frames(objects, bytes).count() as u64 - 1);
        for (mode, config) in [("events", events), ("no events", plain), ("fat, events", fat)] {
            same &= compare(name, mode, steps, |kernels| {
                replay::<u32>(memory, kernels, &config, &mut scenes::frames(objects, bytes))
            })?;
        }
    }
    Ok(same)
}

fn made(memory: &mut Memory) -> Result<bool, Error> {
    let mut same = true;
    for (index, scene) in scenes::SCENES.into_iter().enumerate() {
        let (name, objects, _) = scene;
        let plain = config(objects, 250 * objects);
        let steps = (STEPS as u64 - 1) * objects as u64;
        same &= if index % 2 == 0 {
            compare(name, "events", steps, |kernels| {
                play::<u32>(memory, kernels, &plain.with_events(), scene)
            })?
        } else {
            compare(name, "no events, u16", steps, |kernels| play::<u16>(memory, kernels, &plain, scene))?
        };
    }
    Ok(same)
}

fn run(memory: &mut Memory) -> Result<bool, Error> {
    let _ = write!(Console, "levels:");
    for level in Kernels::all() {
        let _ = write!(Console, " {}", level.name());
    }
    let _ = writeln!(Console, "; detected: {}", Kernels::detect().name());
    if machine::levels_only() {
        machine::end();
    }
    if !operations() {
        return Ok(false);
    }
    let _ = write!(Console, "| scene | mode | pairs |");
    for level in Kernels::all() {
        let _ = write!(Console, " {} |", level.name());
    }
    let _ = writeln!(Console, "\n|---|---|--:|--:|--:|--:|");
    Ok(recordings(memory)? & made(memory)?)
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    let memory = &raw mut MEMORY;
    // SAFETY: `main` is called once, and nothing else names the static.
    let result = run(unsafe { &mut *memory });
    let _ = match result {
        Ok(true) => writeln!(Console, "all levels give the same bytes"),
        Ok(false) => writeln!(Console, "the levels differ"),
        Err(error) => writeln!(Console, "a world refused to work: {error}"),
    };
    machine::end()
}
