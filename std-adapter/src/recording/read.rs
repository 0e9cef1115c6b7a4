//! Reading recordings, at once or frame by frame.

use super::header::BYTES;
use super::{Error, Header, PaddedBox};
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

/// Goes through a recording frame by frame with the memory of one frame.
#[derive(Debug)]
pub struct Reader<R> {
    source: R,
    /// Where in the source the recording starts.
    start: u64,
    header: Header,
    next: u32,
    frame: Vec<PaddedBox>,
}

impl Reader<BufReader<File>> {
    /// Opens a file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::new(BufReader::new(File::open(path)?))
    }
}

impl<R: Read + Seek> Reader<R> {
    /// Reads the header, from where `source` stands, and compares it with the length of the rest.
    pub fn new(mut source: R) -> Result<Self, Error> {
        let start = source.stream_position()?;
        let found = source.seek(SeekFrom::End(0))?.saturating_sub(start);
        source.seek(SeekFrom::Start(start))?;
        if found < BYTES as u64 {
            return Err(Error::NoHeader { found });
        }
        let mut bytes = [0; BYTES];
        source.read_exact(&mut bytes)?;
        let header = Header::decode(&bytes)?;
        let needed = header.file_bytes();
        if found < needed {
            return Err(Error::Truncated { needed, found });
        }
        if found > needed {
            return Err(Error::TrailingBytes { needed, found });
        }
        let frame = zeroed(u64::from(header.count))?;
        Ok(Self { source, start, header, next: 0, frame })
    }

    /// What the recording says of itself.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The boxes of the next frame, or `None` after the last one.
    pub fn next_frame(&mut self) -> Result<Option<&[PaddedBox]>, Error> {
        if self.next == self.header.frames {
            return Ok(None);
        }
        read_boxes(&mut self.source, &mut self.frame)?;
        self.next += 1;
        Ok(Some(&self.frame))
    }

    /// Goes back to before the first frame.
    pub fn rewind(&mut self) -> Result<(), Error> {
        self.source.seek(SeekFrom::Start(self.start + BYTES as u64))?;
        self.next = 0;
        Ok(())
    }
}

/// A whole recording in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    header: Header,
    boxes: Vec<PaddedBox>,
}

impl Recording {
    /// Reads a file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::read(Reader::open(path)?)
    }

    /// Reads a file that is in memory already.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        Self::read(Reader::new(Cursor::new(bytes))?)
    }

    fn read<R: Read + Seek>(mut reader: Reader<R>) -> Result<Self, Error> {
        let mut boxes = zeroed(u64::from(reader.header.count) * u64::from(reader.header.frames))?;
        reader.rewind()?;
        read_boxes(&mut reader.source, &mut boxes)?;
        Ok(Self { header: reader.header, boxes })
    }

    /// What the recording says of itself.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The boxes of a frame.
    #[must_use]
    pub fn frame(&self, index: usize) -> Option<&[PaddedBox]> {
        self.frames().nth(index)
    }

    /// The boxes of one frame after another.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &[PaddedBox]> + Clone {
        self.boxes.chunks_exact(self.header.count as usize)
    }
}

/// Asked for only after the file turned out to be as long.
fn zeroed(count: u64) -> Result<Vec<PaddedBox>, Error> {
    let out_of_memory = || Error::OutOfMemory { needed: count * size_of::<PaddedBox>() as u64 };
    let count = usize::try_from(count).map_err(|_| out_of_memory())?;
    let mut boxes = Vec::new();
    boxes.try_reserve_exact(count).map_err(|_| out_of_memory())?;
    boxes.resize(count, PaddedBox::default());
    Ok(boxes)
}

fn read_boxes(source: &mut impl Read, boxes: &mut [PaddedBox]) -> Result<(), io::Error> {
    source.read_exact(bytemuck::cast_slice_mut(boxes))?;
    if cfg!(target_endian = "big") {
        for value in boxes.as_flattened_mut() {
            *value = f32::from_bits(value.to_bits().swap_bytes());
        }
    }
    Ok(())
}
