//! Errors that name a key.

use core::fmt;
use trisap_core::Error;

/// Why a call about a key was refused: the error of the world, and whose it is. `?` turns it into an [`Error`], too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyedError<K> {
    /// Whose box, filter or margin it is; in a batch, the first one that was refused.
    pub key: K,
    /// What is wrong.
    pub error: Error,
}

impl<K: fmt::Debug> fmt::Display for KeyedError<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, error } = self;
        match error {
            Error::BadBox { .. } => {
                write!(f, "the box of {key:?} has NaN in it or a minimum above its maximum")
            }
            _ => write!(f, "{key:?}: {error}"),
        }
    }
}

impl<K: fmt::Debug> std::error::Error for KeyedError<K> {}

impl<K> From<KeyedError<K>> for Error {
    fn from(refused: KeyedError<K>) -> Self {
        refused.error
    }
}
