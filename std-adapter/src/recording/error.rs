//! What can be wrong with a recording.

use core::fmt;
use std::io;

/// Why a recording could not be read or written.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// The file could not be read or written.
    Io(io::Error),
    /// The file is shorter than a header.
    NoHeader {
        /// The length of the file.
        found: u64,
    },
    /// The header's counts make no sense.
    BadCounts {
        /// The number of objects; at least 1 in a recording.
        objects: i32,
        /// The number of frames after the first; at least 0 in a recording.
        frames: i32,
    },
    /// The file ends before its last frame does.
    Truncated {
        /// The length that the header promises.
        needed: u64,
        /// The length of the file.
        found: u64,
    },
    /// The file goes on after its last frame.
    TrailingBytes {
        /// The length that the header promises.
        needed: u64,
        /// The length of the file.
        found: u64,
    },
    /// There is not enough memory.
    OutOfMemory {
        /// Bytes that are needed.
        needed: u64,
    },
    /// A header to be written does not fit the format: a name of more than 127 bytes or with a zero byte in it, no
    /// object, no frame, or counts above 2,147,483,647.
    BadHeader,
    /// A frame to be written has another number of boxes than the header.
    WrongBoxCount {
        /// Boxes that are needed.
        needed: u32,
        /// Boxes that were given.
        found: usize,
    },
    /// More or fewer frames were written than the header says.
    WrongFrameCount {
        /// Frames that are needed.
        needed: u32,
        /// Frames that were given.
        found: u32,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => error.fmt(f),
            Self::NoHeader { found } => {
                write!(f, "not a recording: a header takes 304 bytes, the file has {found}")
            }
            Self::BadCounts { objects, frames } => {
                write!(f, "not a recording: its header speaks of {objects} objects and {frames} frames")
            }
            Self::Truncated { needed, found } => {
                write!(
                    f,
                    "cut off, or not a recording: its header asks for {needed} bytes, the file has {found}"
                )
            }
            Self::TrailingBytes { needed, found } => {
                write!(
                    f,
                    "too long, or not a recording: its header asks for {needed} bytes, the file has {found}"
                )
            }
            Self::OutOfMemory { needed } => write!(f, "not enough memory: {needed} bytes are needed"),
            Self::BadHeader => f.write_str(
                "the header does not fit the format: names of up to 127 bytes, at least one object and frame",
            ),
            Self::WrongBoxCount { needed, found } => {
                write!(f, "a frame of this recording has {needed} boxes, {found} were given")
            }
            Self::WrongFrameCount { needed, found } => {
                write!(f, "this recording has {needed} frames, {found} were given")
            }
        }
    }
}

impl core::error::Error for Error {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Io(error) => error.source(),
            _ => None,
        }
    }
}

impl From<io::Error> for Error {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
