//! A reader of `.aabbs` recordings that shares nothing with the one that trisap ships.

use std::path::{Path, PathBuf};
use trisap_core::Aabb;

/// Names of the scene and of the objects, 128 bytes each, four integers, the bounds of the world.
const HEADER: usize = 2 * 128 + 4 * 4 + 2 * 16;
const BOX: usize = 32;

/// A recording as it is in the file: every box is `[min x, y, z, 0, max x, y, z, 0]`.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The file's name.
    pub name: String,
    /// The boxes of each frame.
    pub frames: Vec<Vec<[f32; 8]>>,
}

impl Recording {
    /// The boxes of a frame without the padding.
    #[must_use]
    pub fn boxes(&self, frame: usize) -> Vec<Aabb> {
        self.frames[frame].iter().map(|b| Aabb::new([b[0], b[1], b[2]], [b[4], b[5], b[6]])).collect()
    }

    /// How many objects there are.
    #[must_use]
    pub fn objects(&self) -> usize {
        self.frames[0].len()
    }
}

/// Every recording of the repository, and of the folder that `TRISAP_RECORDINGS` names, if any.
#[must_use]
pub fn all() -> Vec<Recording> {
    let more = std::env::var_os("TRISAP_RECORDINGS").map(PathBuf::from);
    let mut all = own();
    all.extend(more.into_iter().flat_map(folder));
    all
}

/// Every recording of the repository, by name.
#[must_use]
pub fn own() -> Vec<Recording> {
    let own = folder(Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings"));
    assert!(!own.is_empty(), "no recording found");
    own
}

fn folder(folder: PathBuf) -> Vec<Recording> {
    let mut paths = files(folder);
    paths.sort();
    paths.iter().map(|path| read(path)).collect()
}

fn files(folder: PathBuf) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries.map(|entry| entry.expect("a folder's entry").path());
    paths.filter(|path| path.extension().is_some_and(|extension| extension == "aabbs")).collect()
}

/// Reads one recording.
///
/// # Panics
/// If the file cannot be read or is not a recording of exactly the length that its header says.
#[must_use]
pub fn read(path: &Path) -> Recording {
    let name = path.file_name().expect("a file name").to_string_lossy().into_owned();
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{name}: {e}"));
    parse(name, &bytes)
}

fn parse(name: String, bytes: &[u8]) -> Recording {
    assert!(bytes.len() >= HEADER, "{name}: cut off in the header");
    let integer = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let objects = usize::try_from(integer(256)).expect("a count of objects");
    // The header counts the steps: the frame before the first step comes on top.
    let frames = usize::try_from(integer(260)).expect("a count of frames") + 1;
    assert_eq!(
        bytes.len(),
        HEADER + frames * objects * BOX,
        "{name}: the length is not what the header says"
    );
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
    let aabb = |b: &[u8]| std::array::from_fn(|k| float(&b[4 * k..4 * k + 4]));
    let frame = |b: &[u8]| b.chunks_exact(BOX).map(aabb).collect();
    Recording { name, frames: bytes[HEADER..].chunks_exact(objects * BOX).map(frame).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recordings_of_the_repository_are_complete() {
        for recording in all() {
            assert!(recording.frames.len() >= 5, "{}", recording.name);
            for frame in 0..recording.frames.len() {
                let boxes = recording.boxes(frame);
                assert_eq!(boxes.len(), recording.objects(), "{}", recording.name);
                assert!(boxes.iter().all(Aabb::is_valid), "{}", recording.name);
            }
        }
    }
}
