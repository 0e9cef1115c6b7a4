//! Reading of `.aabbs` recordings (little endian): a header of 304 bytes, then one block of boxes a frame.
//! Written apart from trisap's own reader, so that a fault there cannot hide here.

use crate::scenes;
use std::{fs, io, path::Path};

/// A box as recordings have it: minimum x, y, z, 0, maximum x, y, z, 0.
pub(crate) type Padded = [f32; 8];

const NAMES: usize = 128;
const HEADER: usize = 2 * NAMES + 16 + 32;

pub(crate) struct Recording {
    /// Scene and objects, as the header names them.
    pub(crate) name: String,
    pub(crate) objects: usize,
    frames: Vec<Vec<Padded>>,
}

impl Recording {
    /// A synthetic scene by name, or else a file.
    pub(crate) fn open(scene: &str) -> io::Result<Self> {
        match scenes::frames(scene) {
            Some(frames) => Ok(Self { name: scenes::name(scene), objects: frames[0].len(), frames }),
            None => Self::read(Path::new(scene)),
        }
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

fn padded(bytes: &[u8]) -> Padded {
    std::array::from_fn(|i| {
        let at = 4 * i;
        f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    })
}
