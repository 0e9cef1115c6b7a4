//! Memory for worlds, and the kernels and job systems that each test runs on.

use crate::doing;
use crate::jobs::Jobs;
use bytemuck::{Pod, Zeroable};
use trisap_core::{Capacity, Config, Index, Kernels, World, layout};

/// As aligned as a world asks for.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Block([u8; 64]);

/// The memory of one world.
#[derive(Clone)]
pub struct Slab {
    blocks: Vec<Block>,
    bytes: usize,
}

impl Slab {
    /// Memory for a world of this configuration, exactly as much as it asks for; all of its bits are set, as what was
    /// there before does not matter.
    ///
    /// # Panics
    /// If there is no such world.
    #[must_use]
    pub fn new<I: Index>(config: &Config) -> Self {
        let layout = layout::<I>(config).expect("the capacity of a test fits");
        assert!(layout.align <= align_of::<Block>(), "worlds ask for an alignment of {}", layout.align);
        Self { blocks: vec![Block([0xff; 64]); layout.bytes.div_ceil(64)], bytes: layout.bytes }
    }

    /// The bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.bytes]
    }

    /// The bytes, to lend to a world.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.blocks)[..self.bytes]
    }

    /// A fresh world in this memory.
    pub fn world<I: Index>(&mut self, config: &Config) -> World<'_, I> {
        doing::made::<I>();
        World::new_in(self.bytes_mut(), config).expect("a world in memory that was made for it")
    }
}

/// What steps run on.
#[derive(Clone, Copy)]
pub struct Setup {
    /// The instruction set level.
    pub kernels: Kernels,
    /// The job system.
    pub jobs: Jobs,
}

impl std::fmt::Debug for Setup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} kernels, {:?} jobs", self.kernels.name(), self.jobs)
    }
}

impl Setup {
    /// What all others are compared with.
    pub const REFERENCE: Self = Self { kernels: Kernels::SCALAR, jobs: Jobs::Serial };

    /// Whether it is that one.
    #[must_use]
    pub fn is_reference(&self) -> bool {
        self.kernels.name() == Self::REFERENCE.kernels.name() && self.jobs == Self::REFERENCE.jobs
    }

    /// Every kernel of this machine with each of the job systems.
    pub fn each(jobs: &[Jobs]) -> Vec<Self> {
        Kernels::all().flat_map(|kernels| jobs.iter().map(move |&jobs| Self { kernels, jobs })).collect()
    }

    /// The configuration with as many workers as the job system promises.
    #[must_use]
    pub fn configure(&self, config: Config) -> Config {
        use trisap_core::Executor;
        config.with_workers(self.jobs.workers())
    }
}

/// Room for `objects` in any position, and for `pairs`.
#[must_use]
pub const fn ample(objects: usize, pairs: usize) -> Capacity {
    Capacity::for_objects(objects as u32).with_leaf_refs(8 * objects as u32).with_pairs(pairs as u32)
}
