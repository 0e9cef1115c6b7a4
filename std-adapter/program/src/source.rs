//! Where boxes come from: a recording or a synthetic scene.

use crate::args::{SceneArgs, SceneName};
use anyhow::{Context, Result, ensure};
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek};
use std::path::Path;
use trisap::recording::Reader;
use trisap::scene::{Objects, Setup, Synthetic, real};
use trisap::{Aabb, Boxes};

/// The recording that is built in, so that the program shows something wherever it is started.
const SHIPPED_NAME: &str = "freefall_cubes_1000.aabbs";
pub(crate) static SHIPPED: &[u8] = include_bytes!("../recordings/freefall_cubes_1000.aabbs");

/// The frames of a synthetic scene where no other number is given.
const SYNTHETIC_FRAMES: u32 = 100;

/// The boxes of one frame after another.
pub(crate) struct Source {
    name: String,
    objects: u32,
    frames: u32,
    next: u32,
    content: Content,
}

enum Content {
    Recording(Reader<Box<dyn ReadSeek>>),
    Synthetic(Box<Synthetic>),
    Real(Box<real::Scene>),
    Frames(Vec<Vec<Aabb>>),
}

trait ReadSeek: Read + Seek {}
impl<T: Read + Seek> ReadSeek for T {}

impl Source {
    /// What the command line says, with so many frames at most; without a number, all of a recording and 100 of a synthetic
    /// scene.
    pub(crate) fn of(args: &SceneArgs, frames: Option<u32>) -> Result<Self> {
        let (count, seed) = (args.n.unwrap_or(1000), args.seed.unwrap_or(1));
        let mut source = match (&args.file, args.scene) {
            (Some(file), _) => Self::open(file)?,
            (None, Some(SceneName::Broadmark(name))) => {
                let objects = args.objects.map_or(Objects::Cubes, Into::into);
                Self::synthetic(Setup { kind: name.into(), objects, count, seed })
            }
            (None, Some(SceneName::Real(kind))) => {
                ensure!(
                    args.objects.is_none(),
                    "the scene '{kind}' has boxes of its own; leave out --objects"
                );
                Self::real(real::Setup { kind, count, seed })?
            }
            (None, None) => {
                Self::recording(SHIPPED_NAME, "the built-in recording", Box::new(Cursor::new(SHIPPED)))?
            }
        };
        match (frames, &source.content) {
            (Some(frames), Content::Synthetic(_) | Content::Real(_)) => source.frames = frames,
            (Some(frames), _) => source.frames = source.frames.min(frames),
            (None, _) => {}
        }
        Ok(source)
    }

    /// A recording in a file.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let file = File::open(path).with_context(|| name.clone())?;
        Self::recording(&name, "recording", Box::new(BufReader::new(file)))
    }

    fn recording(name: &str, kind: &str, bytes: Box<dyn ReadSeek>) -> Result<Self> {
        let reader = Reader::new(bytes).with_context(|| name.to_owned())?;
        let header = reader.header();
        Ok(Self {
            name: format!("{kind} {name} ({}, {})", header.scene, header.objects),
            objects: header.count,
            frames: header.frames,
            next: 0,
            content: Content::Recording(reader),
        })
    }

    fn synthetic(setup: Setup) -> Self {
        Self {
            name: format!(
                "synthetic scene {}, {}, seed {}",
                setup.kind.name(),
                setup.objects.name(),
                setup.seed
            ),
            objects: setup.count,
            frames: SYNTHETIC_FRAMES,
            next: 0,
            content: Content::Synthetic(Box::new(Synthetic::new(setup))),
        }
    }

    fn real(setup: real::Setup) -> Result<Self> {
        let scene = real::Scene::new(setup)?;
        Ok(Self {
            name: format!("synthetic scene {}, seed {}", setup.kind, setup.seed),
            objects: setup.count,
            frames: SYNTHETIC_FRAMES,
            next: 0,
            content: Content::Real(Box::new(scene)),
        })
    }

    /// Boxes in memory: of at least one frame, and of the same number in each.
    pub(crate) fn of_frames(name: &str, frames: Vec<Vec<Aabb>>) -> Self {
        Self {
            name: name.to_owned(),
            objects: frames.first().map_or(0, Vec::len) as u32,
            frames: frames.len() as u32,
            next: 0,
            content: Content::Frames(frames),
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn objects(&self) -> u32 {
        self.objects
    }

    pub(crate) fn frames(&self) -> u32 {
        self.frames
    }

    /// The boxes of the next frame, or `None` after the last one.
    pub(crate) fn next_frame(&mut self) -> Result<Option<Boxes<'_>>> {
        if self.next == self.frames {
            return Ok(None);
        }
        self.next += 1;
        match &mut self.content {
            Content::Recording(reader) => {
                Ok(reader.next_frame().context("cannot read on")?.map(Boxes::padded))
            }
            Content::Synthetic(scene) => {
                if self.next > 1 {
                    scene.advance();
                }
                Ok(Some(Boxes::new(scene.boxes())))
            }
            Content::Real(scene) => {
                if self.next > 1 {
                    scene.advance();
                }
                Ok(Some(Boxes::new(scene.boxes())))
            }
            Content::Frames(frames) => Ok(frames.get(self.next as usize - 1).map(|boxes| Boxes::new(boxes))),
        }
    }

    /// Goes back to before the first frame.
    pub(crate) fn rewind(&mut self) -> Result<()> {
        self.next = 0;
        match &mut self.content {
            Content::Recording(reader) => reader.rewind().context("cannot read again"),
            Content::Synthetic(scene) => {
                **scene = Synthetic::new(*scene.setup());
                Ok(())
            }
            Content::Real(scene) => {
                **scene = real::Scene::new(*scene.setup())?;
                Ok(())
            }
            Content::Frames(_) => Ok(()),
        }
    }
}
