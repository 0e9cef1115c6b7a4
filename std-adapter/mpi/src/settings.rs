//! How ranks work together.

use crate::message::VERSION;
use std::time::Duration;
use trisap::{Capacity, Config};

/// How ranks work together. All ranks should have the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What the world of a rank is made for at first; it grows by itself. Events are always on. No filters and no margin, since
    /// neither travels with an object.
    pub config: Config,
    /// Whether planes move when the rank with most objects has more than 1.2 times the mean. They are placed in the first step
    /// with objects in any case.
    pub balance: bool,
    /// Whether a rank sweeps its own boxes while those of ghosts travel, and then once more for the ghosts. `None`: where
    /// there are at least 4,096 objects and the last step with one sweep waited for messages longer than a second sweep takes.
    pub overlap: Option<bool>,
    /// After so long without an answer from another rank, all ranks end with a message. Has to be longer than the ranks' times
    /// between two steps may differ.
    pub timeout: Duration,
    /// The version of messages. Another one than [`VERSION`] is for tests.
    pub version: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            config: Config::new(Capacity::for_objects(1024)),
            balance: true,
            overlap: None,
            timeout: Duration::from_secs(60),
            version: VERSION,
        }
    }
}
