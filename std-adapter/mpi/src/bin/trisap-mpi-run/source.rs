//! The boxes of one frame after another, by key. All ranks have the same ones.

use crate::args::Args;
use std::error::Error;
use std::fs::File;
use std::io::BufReader;
use trisap::recording::Reader;
use trisap::scene::{Kind, Objects, Random, Setup, Synthetic, real};
use trisap::{Aabb, Boxes};

/// What stands at the key of no object.
const NOBODY: Aabb = Aabb::new([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
/// The frames of a scene, and those of a test scene until all boxes are in the corner.
const FRAMES: u64 = 100;
const FRAMES_TO_CORNER: f32 = 10.0;

/// The boxes of a frame, and who comes and goes.
#[derive(Default)]
pub(crate) struct Frame {
    /// By key; not valid where there is no object.
    pub(crate) boxes: Vec<Aabb>,
    /// Objects that go before the frame, and those that come. Who does both becomes another object.
    pub(crate) gone: Vec<u64>,
    pub(crate) come: Vec<u64>,
}

enum Content {
    Recording(Box<Reader<BufReader<File>>>),
    Synthetic(Box<Synthetic>),
    Real(Box<real::Scene>),
    Test(Test, Vec<Aabb>),
}

#[derive(Clone, Copy, PartialEq)]
enum Test {
    /// One box in five goes anywhere in each frame, so that one in ten changes its rank on two ranks, and more on more.
    Scatter,
    /// So too, and one box in twenty has no end on some sides.
    Unbounded,
    /// All boxes go to one corner, and one in fifty out of it at random.
    Corner,
    /// So as in scatter, and one box in ten goes or comes, or becomes another.
    Lives,
}

pub(crate) struct Source {
    content: Content,
    random: Random,
    side: f32,
    next: u64,
    pub(crate) frames: u64,
    pub(crate) name: String,
    frame: Frame,
}

impl Source {
    pub(crate) fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let (mut frames, mut name) = (args.frames.unwrap_or(FRAMES), args.scene.clone());
        let objects = if args.assorted { Objects::Assorted } else { Objects::Cubes };
        let setup = |kind| Setup { kind, objects, count: args.n, seed: args.seed };
        let broadmark = Kind::ALL.into_iter().find(|kind| kind.name().eq_ignore_ascii_case(&args.scene));
        let tests = [
            ("scatter", Test::Scatter),
            ("unbounded", Test::Unbounded),
            ("corner", Test::Corner),
            ("lives", Test::Lives),
        ];
        let test = tests.into_iter().find(|(name, _)| *name == args.scene);
        let start = setup(Kind::Brownian);
        let content = if let Some(file) = &args.file {
            let reader = Reader::open(file)?;
            frames = u64::from(reader.header().frames).min(args.frames.unwrap_or(u64::MAX));
            name = format!("{} of {}", reader.header().scene, file.display());
            Content::Recording(Box::new(reader))
        } else if let Some((_, test)) = test {
            Content::Test(test, Synthetic::new(start).boxes().to_vec())
        } else if let Some(kind) = broadmark {
            Content::Synthetic(Box::new(Synthetic::new(setup(kind))))
        } else {
            let kind = real::Kind::by_name(&args.scene).ok_or("there is no such scene")?;
            let setup = real::Setup { kind, count: args.n, seed: args.seed };
            Content::Real(Box::new(real::Scene::new(setup)?))
        };
        let random = Random::new(args.seed, 9);
        Ok(Self { content, random, side: start.side(), next: 0, frames, name, frame: Frame::default() })
    }

    /// The next frame, or none after the last one.
    pub(crate) fn next(&mut self) -> Result<Option<&Frame>, Box<dyn Error>> {
        if self.next == self.frames {
            return Ok(None);
        }
        let frame = &mut self.frame;
        let first = self.next == 0;
        self.next += 1;
        (frame.gone, frame.come) = Default::default();
        match &mut self.content {
            Content::Recording(reader) => {
                let boxes = Boxes::padded(reader.next_frame()?.ok_or("the recording is too short")?);
                frame.boxes = (0..boxes.len()).filter_map(|index| boxes.get(index)).collect();
            }
            Content::Synthetic(scene) => {
                if !first {
                    scene.advance();
                }
                refill(&mut frame.boxes, scene.boxes());
            }
            Content::Real(scene) => {
                if !first {
                    scene.advance();
                }
                refill(&mut frame.boxes, scene.boxes());
            }
            Content::Test(test, start) => {
                if first {
                    frame.boxes = start.clone();
                }
                test.advance(self.next, self.side, &mut self.random, frame);
            }
        }
        if first {
            let valid = |key: &u64| self.frame.boxes[*key as usize].is_valid();
            self.frame.come = (0..self.frame.boxes.len() as u64).filter(valid).collect();
            self.frame.gone.clear();
        }
        Ok(Some(&self.frame))
    }
}

/// Copies without a new allocation in each frame.
fn refill(boxes: &mut Vec<Aabb>, from: &[Aabb]) {
    boxes.clear();
    boxes.extend_from_slice(from);
}

impl Test {
    fn advance(self, time: u64, side: f32, random: &mut Random, frame: &mut Frame) {
        let half = side / 2.0;
        for key in 0..frame.boxes.len() as u64 {
            let aabb = &mut frame.boxes[key as usize];
            let chance = random.below(100);
            let place = [0; 3].map(|_| random.between(-half, half));
            let edge = random.between(0.5, 2.0);
            let anywhere = Aabb::new(place, place.map(|x| x + edge));
            match self {
                Self::Corner => {
                    let share = (time as f32 / FRAMES_TO_CORNER).min(1.0);
                    let near = place.map(|x| (x + half) * (1.0 - 0.9 * share) - half);
                    if chance < 30 {
                        *aabb = Aabb::new(near, near.map(|x| x + edge));
                    }
                    if chance < 2 {
                        *aabb = anywhere;
                    }
                }
                Self::Lives if chance >= 90 => {
                    if aabb.is_valid() {
                        frame.gone.push(key);
                    }
                    if chance >= 95 {
                        *aabb = anywhere;
                        frame.come.push(key);
                    } else {
                        *aabb = NOBODY;
                    }
                }
                _ => {
                    if chance < 20 && aabb.is_valid() {
                        *aabb = anywhere;
                    }
                }
            }
            if self == Self::Unbounded && chance < 20 && random.below(20) == 0 {
                for k in 0..3 {
                    match random.below(4) {
                        0 => aabb.min[k] = f32::NEG_INFINITY,
                        1 => aabb.max[k] = f32::INFINITY,
                        2 => (aabb.min[k], aabb.max[k]) = (f32::NEG_INFINITY, f32::INFINITY),
                        _ => {}
                    }
                }
            }
        }
    }
}
