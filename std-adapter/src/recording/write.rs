//! Writing recordings.

use super::header::pad;
use super::{Error, Header};
use crate::Boxes;
use std::io::Write;

/// Writes a recording frame by frame.
///
/// [`Writer::finish`] checks that all frames are there; a recording that is not finished is cut off.
#[derive(Debug)]
pub struct Writer<W> {
    target: W,
    header: Header,
    written: u32,
}

impl<W: Write> Writer<W> {
    /// Writes the header. A file wants a [`BufWriter`](std::io::BufWriter) around it.
    pub fn new(mut target: W, header: Header) -> Result<Self, Error> {
        target.write_all(&header.encode()?)?;
        Ok(Self { target, header, written: 0 })
    }

    /// Writes the next frame: a box for every object.
    pub fn write_frame(&mut self, boxes: Boxes<'_>) -> Result<(), Error> {
        let needed = self.header.count;
        if boxes.len() != needed as usize {
            return Err(Error::WrongBoxCount { needed, found: boxes.len() });
        }
        if self.written == self.header.frames {
            return Err(Error::WrongFrameCount {
                needed: self.written,
                found: self.written.saturating_add(1),
            });
        }
        for aabb in (0..boxes.len()).filter_map(|index| boxes.get(index)) {
            let words = pad(&aabb).map(f32::to_le_bytes);
            self.target.write_all(words.as_flattened())?;
        }
        self.written += 1;
        Ok(())
    }

    /// Checks that every frame was written, flushes, and gives the target back.
    pub fn finish(mut self) -> Result<W, Error> {
        if self.written != self.header.frames {
            return Err(Error::WrongFrameCount { needed: self.header.frames, found: self.written });
        }
        self.target.flush()?;
        Ok(self.target)
    }
}
