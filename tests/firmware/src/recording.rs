//! The recorded frames, in flash: the file as it is, in Broadmark's format.
//!
//! The objects are ordered by their distance from the middle of the floor in the first frame, so that the first few
//! are as dense a pile as all of them.

use trisap_core::Boxes;

/// Recorded objects.
pub const OBJECTS: usize = 256;
/// Recorded frames.
pub const FRAMES: usize = 16;

const HEADER: usize = 304;
/// A box has two corners of four floats.
const BOX: usize = 32;
const FRAME: usize = OBJECTS * BOX;

#[cfg_attr(target_os = "none", unsafe(link_section = ".recording"))]
static BYTES: [u8; HEADER + FRAMES * FRAME] = *include_bytes!("../freefall_cubes_256.aabbs");

/// The first `objects` boxes of a frame, read where they lie.
#[must_use]
pub fn frame(index: usize, objects: usize) -> Option<Boxes<'static>> {
    let start = HEADER + index * FRAME;
    Boxes::strided(BYTES.get(start..start + objects.min(OBJECTS) * BOX)?, BOX, BOX / 2)
}
