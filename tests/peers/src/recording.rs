//! Reading of `.aabbs` recordings (little endian): a header of 304 bytes, then one block of boxes a frame.
//! Written apart from trisap's own reader, so that a fault there cannot hide here.

use std::{fs, io, path::Path};
use trisap::Aabb;
use trisap::scene::{Kind, Objects, Setup, Synthetic, real};

/// A box as recordings have it: minimum x, y, z, 0, maximum x, y, z, 0.
pub(crate) type Padded = [f32; 8];

const NAMES: usize = 128;
const HEADER: usize = 2 * NAMES + 16 + 32;

/// Frames of a synthetic scene before the first one used, and frames used.
const SETTLE: usize = 40;
const SYNTHETIC_FRAMES: usize = 12;

pub(crate) struct Recording {
    /// Scene and objects, as the header names them.
    pub(crate) name: String,
    pub(crate) objects: usize,
    frames: Vec<Vec<Padded>>,
}

impl Recording {
    /// A synthetic scene by name, or else a file.
    pub(crate) fn open(scene: &str) -> io::Result<Self> {
        Self::synthetic(scene).map_or_else(|| Self::read(Path::new(scene)), Ok)
    }

    fn read(path: &Path) -> io::Result<Self> {
        let bytes = fs::read(path)?;
        let bad =
            |what: &str| io::Error::new(io::ErrorKind::InvalidData, format!("{}: {what}", path.display()));
        if bytes.len() < HEADER {
            return Err(bad("shorter than its header"));
        }
        let text = |at: usize| {
            let field = &bytes[at..at + NAMES];
            let end = field.iter().position(|&b| b == 0).unwrap_or(NAMES);
            String::from_utf8_lossy(&field[..end]).trim().to_lowercase()
        };
        let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let objects = word(2 * NAMES) as usize;
        let blocks = word(2 * NAMES + 4) as usize + 1;
        let block = objects * size_of::<Padded>();
        if objects == 0 || bytes.len() < HEADER + blocks * block {
            return Err(bad("shorter than its frames"));
        }
        let frames = bytes[HEADER..HEADER + blocks * block]
            .chunks_exact(block)
            .map(|frame| frame.chunks_exact(size_of::<Padded>()).map(padded).collect())
            .collect();
        Ok(Self { name: format!("{} {}", text(0), text(NAMES)), objects, frames })
    }

    /// A scene of trisap's generator, named `kind:objects:count`, as in `brownian:cubes:32000`, or `kind:count` where it is one
    /// of those of games, as in `ground:1e4:8000`.
    fn synthetic(name: &str) -> Option<Self> {
        let (scene, count) = name.rsplit_once(':')?;
        let count = count.parse().ok().filter(|&count| count > 0)?;
        let (name, frames) = match real::Kind::by_name(scene) {
            Some(kind) => {
                let mut scene = real::Scene::new(real::Setup { kind, count, seed: 1 }).ok()?;
                let next = || {
                    scene.advance();
                    scene.boxes().iter().map(from_aabb).collect()
                };
                (format!("synthetic {kind}"), settled(next))
            }
            None => {
                let (kind, mix) = scene.split_once(':')?;
                let kind = Kind::ALL.into_iter().find(|k| k.name().eq_ignore_ascii_case(kind))?;
                let mix = Objects::ALL.into_iter().find(|o| o.name().eq_ignore_ascii_case(mix))?;
                let mut scene = Synthetic::new(Setup { kind, objects: mix, count, seed: 1 });
                let next = || {
                    scene.advance();
                    scene.boxes().iter().map(from_aabb).collect()
                };
                (format!("synthetic {} {}", kind.name(), mix.name()).to_lowercase(), settled(next))
            }
        };
        Some(Self { name, objects: count as usize, frames })
    }

    /// The boxes of `step`, for any step: the recording runs forwards and backwards in turn, so that a short one
    /// gives as many frames of continuous motion as wanted.
    pub(crate) fn frame(&self, step: usize) -> &[Padded] {
        &self.frames[self.index(step)]
    }

    /// Which of the recorded frames [`Self::frame`] gives.
    pub(crate) fn index(&self, step: usize) -> usize {
        let last = self.frames.len() - 1;
        if last == 0 {
            return 0;
        }
        let at = step % (2 * last);
        at.min(2 * last - at)
    }

    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }
}

/// The frames that are used of a synthetic scene: falling boxes need some time to meet, and what is sudden in a scene of
/// games is over.
fn settled(mut next: impl FnMut() -> Vec<Padded>) -> Vec<Vec<Padded>> {
    (0..SETTLE).for_each(|_| drop(next()));
    (0..SYNTHETIC_FRAMES).map(|_| next()).collect()
}

fn from_aabb(aabb: &Aabb) -> Padded {
    let ([a, b, c], [d, e, f]) = (aabb.min, aabb.max);
    [a, b, c, 0.0, d, e, f, 0.0]
}

fn padded(bytes: &[u8]) -> Padded {
    std::array::from_fn(|i| {
        let at = 4 * i;
        f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    })
}
