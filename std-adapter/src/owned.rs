//! A world that brings its own memory.

use crate::memory::Memory;
use core::fmt;
use core::marker::PhantomData;
use trisap_core::{Config, Error, Index, World, layout};

/// A world in memory of its own, allocated once: on Linux in huge pages if it has two MiB or more, else on the heap.
///
/// It owns the slab and nothing else: [`OwnedWorld::world`] opens the [`World`] in it, as often as wanted. All
/// state is in the slab, so that a world opened again goes on where the last one stopped.
pub struct OwnedWorld<I: Index = u32> {
    slab: Memory,
    bytes: usize,
    index: PhantomData<I>,
}

impl OwnedWorld<u32> {
    /// An empty world for `config`, with slots of 32 bits. Memory that cannot be had is [`Error::CapacityTooLarge`].
    pub fn new(config: &Config) -> Result<Self, Error> {
        Self::with_index(config)
    }
}

impl<I: Index> OwnedWorld<I> {
    /// An empty world with slots of any width. Memory that cannot be had is [`Error::CapacityTooLarge`].
    pub fn with_index(config: &Config) -> Result<Self, Error> {
        let bytes = layout::<I>(config).ok_or(Error::CapacityTooLarge)?.bytes;
        let mut slab = Memory::zeroed(bytes).ok_or(Error::CapacityTooLarge)?;
        World::<I>::new_in(&mut slab, config)?;
        Ok(Self { slab, bytes, index: PhantomData })
    }

    /// The world in the slab.
    #[must_use]
    pub fn world(&mut self) -> World<'_, I> {
        World::open(&mut self.slab)
            .expect("`new` made a world of this width, and nobody else can write to the slab")
    }

    /// Moves the world to memory for another configuration, with everything that it holds: see [`World::move_into`].
    ///
    /// # Errors
    /// Those of [`World::move_into`]; memory that cannot be had is [`Error::CapacityTooLarge`]. The world stays as it is then.
    pub fn move_to(&mut self, config: &Config) -> Result<(), Error> {
        let bytes = layout::<I>(config).ok_or(Error::CapacityTooLarge)?.bytes;
        let mut slab = Memory::zeroed(bytes).ok_or(Error::CapacityTooLarge)?;
        let _ = self.world().move_into(&mut slab, config)?;
        (self.slab, self.bytes) = (slab, bytes);
        Ok(())
    }

    /// The bytes of the slab. Huge pages take up to two MiB more.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

impl<I: Index> fmt::Debug for OwnedWorld<I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnedWorld").field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap_core::{Aabb, Capacity, Kernels};

    const CUBE: Aabb = Aabb::new([0.0; 3], [1.0; 3]);

    #[test]
    fn state_outlives_the_view() -> Result<(), Error> {
        let mut owned = OwnedWorld::<u16>::with_index(&Config::new(Capacity::for_objects(4)))?;
        let first = owned.world().insert(CUBE)?;
        let second = owned.world().insert(CUBE)?;
        assert_eq!(owned.world().len(), 2);
        owned.world().set_kernels(Kernels::SCALAR).step()?;
        assert_eq!(owned.world().pairs(), [[0, 1]]);
        owned.world().remove(first)?;
        assert!(owned.world().contains(second));
        assert!(owned.world().set_kernels(Kernels::SCALAR).step()?.pairs().is_empty());
        Ok(())
    }

    #[test]
    fn too_large_is_an_error() {
        let more_than_u16 = Config::new(Capacity::for_objects(70_000));
        assert_eq!(OwnedWorld::<u16>::with_index(&more_than_u16).unwrap_err(), Error::CapacityTooLarge);
        let no_worker = Config::new(Capacity::for_objects(8)).with_workers(0);
        assert!(OwnedWorld::<u32>::new(&no_worker).is_err());
    }

    #[test]
    fn moves_between_threads() {
        let mut owned = OwnedWorld::<u32>::new(&Config::new(Capacity::for_objects(1))).expect("small");
        let len = std::thread::spawn(move || {
            owned.world().insert(CUBE).expect("one fits");
            owned.world().len()
        });
        assert_eq!(len.join().expect("no panic"), 1);
    }
}
