//! What can go wrong. What one rank alone finds to be wrong in the middle of a step ends all ranks with a message instead.

use std::fmt;
use std::io;

/// Why a call was refused.
#[derive(Debug)]
#[non_exhaustive]
pub enum Fault {
    /// Not all ranks have this version of messages. All ranks get this error.
    Version {
        /// The lowest version among them.
        lowest: u32,
        /// The highest version among them.
        highest: u32,
    },
    /// The box has NaN in it or a minimum above its maximum.
    BadBox {
        /// The object.
        key: u64,
    },
    /// The rank does not own an object of this key.
    NotOwned {
        /// The key.
        key: u64,
    },
    /// The rank has been given an object of this key already.
    KeyTaken {
        /// The key.
        key: u64,
    },
    /// A world cannot be made for this configuration, or there is no memory for it.
    World(trisap::Error),
    /// A file cannot be read or written.
    Io(io::Error),
    /// A file is none of this program, or has changed since it was saved.
    BadFile(&'static str),
    /// The files of all ranks do not make one saved scene: one is missing, there twice, or of another step. All ranks get this
    /// error.
    FilesDiffer,
    /// Another rank could not read its files. All ranks get an error.
    OtherRank,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version { lowest, highest } => {
                write!(f, "the ranks have different versions of messages, from {lowest} to {highest}")
            }
            Self::BadBox { key } => {
                write!(f, "the box of {key} has NaN in it or a minimum above its maximum")
            }
            Self::NotOwned { key } => write!(f, "this rank does not own an object with the key {key}"),
            Self::KeyTaken { key } => write!(f, "this rank has an object with the key {key} already"),
            Self::World(error) => error.fmt(f),
            Self::Io(error) => error.fmt(f),
            Self::BadFile(what) => f.write_str(what),
            Self::FilesDiffer => f.write_str("the files of all ranks do not make one saved scene"),
            Self::OtherRank => f.write_str("another rank could not read its files"),
        }
    }
}

impl std::error::Error for Fault {}

impl From<trisap::Error> for Fault {
    fn from(error: trisap::Error) -> Self {
        Self::World(error)
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
