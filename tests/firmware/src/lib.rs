//! What the firmware's programs share. They run on boards without an operating system and, from the same source, on
//! the host, which computes what the boards must come to.

#![cfg_attr(target_os = "none", no_std)]

pub mod board;
pub mod brute;
pub mod digest;
pub mod print;
pub mod recording;
pub mod scenes;
