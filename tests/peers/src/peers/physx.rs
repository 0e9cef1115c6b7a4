//! PhysX 5: automatic box pruning (eABP; with more threads its parallel sibling, ePABP) through PhysX's own
//! stand-alone broad phase. It tells found and lost pairs.

use super::{Crowd, Entry, Start};

#[cfg(feature = "physx")]
mod broad_phase;

pub(crate) fn entry() -> Entry {
    #[cfg(feature = "physx")]
    let start: Result<Start, &'static str> = Ok(|setting| Box::new(broad_phase::Physx::new(setting)));
    #[cfg(not(feature = "physx"))]
    let start: Result<Start, &'static str> = Err("needs clang and --features physx");
    Entry {
        name: "PhysX ABP",
        setup: "PxCreateBroadPhase(eABP), all boxes dynamic, those handed over updated, scratch block; ePABP on 2 threads",
        events: true,
        fat: false,
        parallel: true,
        crowd: Crowd::All,
        start,
    }
}
