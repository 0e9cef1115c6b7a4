//! Prints the instructions that steps take, beside those of brute force.
//!
//! Each step's pairs, and those found and lost, are counted by both ways; exit code 1 if they differ, or if nobody
//! counts instructions. Exit code 3 if the recorded steps take more than they may, 4 if a step takes more than its bound.

#![cfg_attr(target_os = "none", no_std, no_main)]

use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Filter, InlineWorld, Margin, World, layout};
use trisap_firmware::brute::{self, Keys};
use trisap_firmware::scenes::{SCENES, Scene};
use trisap_firmware::{board, entry, print, recording};

const SIZES: [usize; 5] = [16, 32, 64, 128, 256];
const LARGEST: usize = 256;
const FRAMES: usize = recording::FRAMES;

/// The most instructions that a recorded step of 64 objects may take.
const TYPICAL: u32 = 26_500;
/// The same for 256.
const TYPICAL_OF_256: u32 = 153_000;

/// What a world has beside pairs.
#[derive(Clone, Copy, PartialEq)]
struct Capability {
    name: &'static str,
    /// The instructions that it may add for each object, and for each pair.
    costs: [usize; 2],
}

const ALONE: Capability = Capability { name: "", costs: [0, 0] };
const EVENTS: Capability = Capability { name: "events", costs: [20, 40] };
const MARGINS: Capability = Capability { name: "margins", costs: [0, 0] };
const FILTERS: Capability = Capability { name: "filters", costs: [60, 60] };

/// The most instructions that any step may take: a function of the number of objects and of the pairs of this step or the
/// last one, whichever has more. See the README.
fn bound(objects: usize, pairs: usize, capability: Capability) -> u32 {
    let digits = usize::BITS - objects.leading_zeros();
    let per_object = 320 + 50 * digits as usize + capability.costs[0];
    let per_pair = 34 + capability.costs[1];
    (10_000 + per_object * objects + 12 * objects * objects + per_pair * pairs) as u32
}

const fn config(objects: usize, pairs: usize) -> Config {
    Config::new(Capacity::for_objects(objects as u32).with_pairs(pairs as u32)).with_lean()
}

const MARGIN: Margin = Margin::length(0.01);
const MOST: Config =
    config(LARGEST, LARGEST * (LARGEST - 1) / 2).with_events().with_margin(MARGIN).with_filters();
const BYTES: usize = layout::<u16>(&MOST).unwrap().bytes;

/// All pairs that there can be.
type Pairs = [[u16; 2]; LARGEST * (LARGEST - 1) / 2];

/// The memory of all measurements, one after another.
struct Memory {
    world: InlineWorld<BYTES>,
    boxes: [Aabb; LARGEST],
    keys: [Keys; LARGEST],
    /// Of this step, and of the last one.
    pairs: [Pairs; 2],
    found: Pairs,
    lost: Pairs,
}

static mut MEMORY: Memory = Memory {
    world: InlineWorld::EMPTY,
    boxes: [Aabb::new([0.0; 3], [0.0; 3]); LARGEST],
    keys: [Keys::NONE; LARGEST],
    pairs: [[[0; 2]; LARGEST * (LARGEST - 1) / 2]; 2],
    found: [[0; 2]; LARGEST * (LARGEST - 1) / 2],
    lost: [[0; 2]; LARGEST * (LARGEST - 1) / 2],
};

/// Instructions of all frames, and of the frame that had the most.
#[derive(Default)]
struct Instructions {
    sum: u32,
    most: u32,
    last: u32,
}

impl Instructions {
    fn add(&mut self, count: Option<u32>) {
        let count = count.unwrap_or_default();
        self.sum += count;
        self.most = self.most.max(count);
        self.last = count;
    }

    fn mean(&self) -> u32 {
        self.sum / FRAMES as u32
    }

    fn print(&self) {
        cell(self.mean(), 11);
        cell(self.most, 11);
    }
}

/// What steps come to: how many pairs, whether they fit or not, and how many are found and lost if they do; or why not.
fn step(world: &mut World<'_, u16>, boxes: Boxes<'_>) -> Result<(usize, Option<[usize; 2]>), Error> {
    match world.step_over(boxes) {
        Ok(step) => Ok((step.pairs().len(), Some([step.found().len(), step.lost().len()]))),
        Err(Error::PairsFull { needed, .. }) => Ok((needed as usize, None)),
        Err(error) => Err(error),
    }
}

/// What a row came to.
#[derive(Default)]
struct Row {
    /// Whether the world and brute force have found as many pairs in each step.
    agree: bool,
    /// Whether no step has taken more than the bound.
    bounded: bool,
    /// Instructions a step.
    ours: u32,
}

/// Steps through a scene and prints its row.
fn row(memory: &mut Memory, scene: &Scene, capability: Capability, objects: usize) -> Result<Row, Error> {
    let Memory { world, boxes, keys, pairs: [pairs, last], found, lost } = memory;
    let (mut pairs, mut last) = (pairs, last);
    let all = objects * (objects - 1) / 2;
    let mut config = config(objects, scene.pairs_per_object.map_or(all, |count| count * objects));
    config.events = capability == EVENTS;
    config.margin = (capability == MARGINS).then_some(MARGIN);
    config.filters = capability == FILTERS;
    let mut world = world.init::<u16>(&config)?;
    let (Some(boxes), Some(keys)) = (boxes.get_mut(..objects), keys.get_mut(..objects)) else {
        return Ok(Row::default());
    };
    (scene.frame)(0, boxes);
    world.insert_many(Boxes::new(boxes))?;
    // The first two objects do not meet, so that a filter is asked of each overlap.
    for slot in 0..if config.filters { 2 } else { 0 } {
        let id = world.id_at(slot).ok_or(Error::NotAWorld)?;
        world.set_filter(id, Filter::groups(1 << slot, !(2 >> slot)))?;
    }

    let (mut ours, mut theirs) = (Instructions::default(), Instructions::default());
    let (mut agree, mut bounded) = (true, true);
    let (mut most_pairs, mut last_pairs) = (0, 0);
    for index in 0..FRAMES {
        (scene.frame)(index, boxes);
        let (mut told, mut expected, mut events) = (Ok((0, None)), 0, [0; 2]);
        ours.add(board::instructions(|| told = step(&mut world, Boxes::new(boxes))));
        theirs.add(board::instructions(|| {
            expected = brute::force(Boxes::new(boxes), keys, pairs);
            if config.events {
                events = brute::compare(&last[..last_pairs], &pairs[..expected], found, lost);
                core::mem::swap(&mut pairs, &mut last);
            }
        }));
        let apart = config.filters && boxes[0].overlaps(&boxes[1]);
        let (count, told) = told?;
        agree &= count == expected - usize::from(apart) && told.is_none_or(|told| told == events);
        bounded &= ours.last <= bound(objects, expected.max(last_pairs), capability);
        last_pairs = expected;
        most_pairs = most_pairs.max(expected);
    }

    board::print("| ");
    print::text(scene.name, 22);
    board::print("| ");
    print::text(capability.name, 7);
    board::print(" |");
    cell(objects as u32, 8);
    cell(most_pairs as u32, 8);
    ours.print();
    cell(bound(objects, most_pairs, capability), 11);
    theirs.print();
    board::print("\n");
    Ok(Row { agree, bounded, ours: ours.mean() })
}

fn cell(value: u32, width: usize) {
    print::number(value, width);
    board::print(" |");
}

/// Whether instructions are counted: a loop of known length takes what it should.
fn counted() -> bool {
    const ROUNDS: u32 = 100_000;
    let count = board::instructions(|| board::spin(ROUNDS)).unwrap_or_default();
    count.abs_diff(2 * ROUNDS) < ROUNDS / 500
}

/// Prints the table and returns the exit code.
fn measure(memory: &mut Memory) -> Result<u8, Error> {
    let (mut agree, mut bounded, mut fast) = (true, true, true);
    board::print(
        "| scene                 | with    | objects |   pairs |       step |    at most |      bound |",
    );
    board::print(" brute force |    at most |\n");
    board::print(
        "|-----------------------|---------|--------:|--------:|-----------:|-----------:|-----------:|",
    );
    board::print("------------:|-----------:|\n");
    for (index, scene) in SCENES.iter().enumerate() {
        for objects in SIZES {
            for capability in [ALONE, EVENTS, MARGINS, FILTERS] {
                let row = row(memory, scene, capability, objects)?;
                agree &= row.agree;
                bounded &= row.bounded;
                // The first scene is the recording.
                fast &= match (index, capability.name, objects) {
                    (0, "", 64) => row.ours <= TYPICAL,
                    (0, "", 256) => row.ours <= TYPICAL_OF_256,
                    _ => true,
                };
            }
        }
    }
    if !agree {
        board::print("the world and brute force disagree\n");
        return Ok(1);
    }
    if !bounded {
        board::print("a step takes more than its bound\n");
        return Ok(4);
    }
    if !fast {
        board::print("recorded steps take more than they may\n");
        return Ok(3);
    }
    Ok(0)
}

fn run() -> u8 {
    let memory = &raw mut MEMORY;
    // SAFETY: `run` is called once, and nothing else names the static.
    let memory = unsafe { &mut *memory };
    if !counted() {
        board::print("nobody counts instructions: QEMU needs -icount shift=0\n");
        return 1;
    }
    measure(memory).unwrap_or_else(|_| {
        board::print("the world refused to work\n");
        2
    })
}

entry!(run);
