//! A world with memory of its own.

use super::World;
use crate::config::Config;
use crate::error::Error;
use crate::id::Index;
use bytemuck::Zeroable;
use core::fmt;

/// Memory for a world, in a static, a struct or on the stack.
///
/// `BYTES` comes from [`layout`](crate::layout), so the memory is exactly what the configuration needs. It is all
/// zero until [`init`](Self::init), so a static is in `.bss`.
///
/// ```
/// use trisap_core::{Aabb, Capacity, Config, InlineWorld, layout};
///
/// const CONFIG: Config = Config::new(Capacity::for_objects(64));
/// const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
///
/// let mut memory = InlineWorld::<BYTES>::EMPTY;
/// let mut world = memory.init::<u16>(&CONFIG)?;
/// world.insert(Aabb::new([0.0; 3], [1.0; 3]))?;
/// assert_eq!(format!("{memory:?}"), format!("InlineWorld<{BYTES}>"));
/// # Ok::<(), trisap_core::Error>(())
/// ```
#[repr(C, align(64))]
#[derive(Clone)]
pub struct InlineWorld<const BYTES: usize>([u8; BYTES]);

impl<const BYTES: usize> InlineWorld<BYTES> {
    /// No world yet: all zero.
    pub const EMPTY: Self = Self([0; BYTES]);

    /// Makes an empty world, whatever was there before.
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`], [`Error::CapacityTooLarge`] or [`Error::BadMargin`].
    pub fn init<I: Index>(&mut self, config: &Config) -> Result<World<'_, I>, Error> {
        World::new_in(&mut self.0, config)
    }

    /// Moves a world here, from wherever it is: see [`World::move_into`].
    ///
    /// # Errors
    /// Those of [`World::move_into`].
    #[doc(alias = "move_to")]
    pub fn receive<I: Index>(
        &mut self,
        world: &World<'_, I>,
        config: &Config,
    ) -> Result<World<'_, I>, Error> {
        world.move_into(&mut self.0, config)
    }

    /// The world that [`init`](Self::init) made.
    ///
    /// # Errors
    /// [`Error::NotAWorld`] before that, or if the index width differs.
    pub fn world<I: Index>(&mut self) -> Result<World<'_, I>, Error> {
        World::open(&mut self.0)
    }
}

impl<const BYTES: usize> fmt::Debug for InlineWorld<BYTES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "InlineWorld<{BYTES}>")
    }
}

impl<const BYTES: usize> Default for InlineWorld<BYTES> {
    fn default() -> Self {
        Self(Zeroable::zeroed())
    }
}
