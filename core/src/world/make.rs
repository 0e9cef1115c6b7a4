//! Makes worlds in memory of the caller or of their own, and opens them there again.

use super::{Unfinished, World};
use crate::config::Config;
use crate::error::{Error, Field};
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::simd::kernels::Kernels;
use core::fmt;

/// Making.
///
/// ```
/// use trisap_core::{Aabb, Capacity, Config, Error, World, layout};
///
/// const CONFIG: Config = Config::new(Capacity::for_objects(100).with_pairs(400)).with_events();
/// const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
///
/// // From a static, an arena, the heap; or an `InlineWorld`, which has the right size and alignment.
/// #[repr(align(64))]
/// struct Memory([u8; BYTES]);
/// let mut memory = Box::new(Memory([0; BYTES]));
///
/// let mut world = World::<u16>::new_in(&mut memory.0, &CONFIG)?;
/// let id = world.insert(Aabb::new([0.0; 3], [1.0; 3]))?;
/// // The view can go; the world stays in its memory.
/// let world = World::<u16>::open(&mut memory.0)?;
/// assert!(world.contains(id) && world.config() == CONFIG);
/// # Ok::<(), Error>(())
/// ```
impl<'m, I: Index> World<'m, I> {
    /// Makes an empty world in `slab`, which must be as long and as aligned as [`layout`](crate::layout)
    /// says. What was in the slab does not matter; bytes beyond the needed length are not touched. O(bytes).
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`], [`Error::SlabMisaligned`], [`Error::CapacityTooLarge`], [`Error::BadMargin`].
    pub fn new_in(slab: &'m mut [u8], config: &Config) -> Result<Self, Error> {
        Parts::init(slab, config).map(Self::of)
    }

    /// Opens the world that [`new_in`](Self::new_in) made in `slab`, with all that it holds. O(1), or O(n)
    /// where its process ended within a step.
    ///
    /// # Errors
    /// [`Error::NotAWorld`] where there is none of this index width, and the errors of `new_in`.
    pub fn open(slab: &'m mut [u8]) -> Result<Self, Error> {
        let mut parts = Parts::open(slab);
        // Where they stand, as they take much stack to move.
        if let Some(parts) = parts.as_mut().ok().filter(|parts| parts.state.stepping != 0) {
            parts.mend_boxes();
            drop(Unfinished(parts));
        }
        parts.map(Self::of)
    }

    fn of(parts: Parts<'m, I>) -> Self {
        Self { parts, kernels: Kernels::detect() }
    }

    /// Becomes a copy of another world, which has the same memory and kind: it goes on as that one would,
    /// byte for byte. To go back, keep a copy from before. Takes at most as long as a copy of the memory,
    /// less where room is not used. A copy of the memory itself, opened again, is the same.
    ///
    /// # Errors
    /// [`Error::OtherConfig`]; nothing is done then.
    #[doc(alias("clone", "rollback"))]
    pub fn copy_from(&mut self, other: &World<'_, I>) -> Result<(), Error> {
        let (own, others) = (&self.parts, &other.parts);
        let field = others.state.setup.difference(&own.state.setup);
        let [memory, given] = [own, others]
            .map(|parts| parts.config())
            .map(|of| (of.capacity, of.workers, of.lean, of.predicted));
        if let Some(field) = field.or((memory != given).then_some(Field::Bytes)) {
            return Err(Error::OtherConfig { field });
        }
        self.parts.copy(&other.parts);
        self.parts.watch.follow(&other.parts.watch);
        Ok(())
    }

    /// What the world was made for.
    #[must_use]
    pub fn config(&self) -> Config {
        *self.parts.config()
    }
}

/// Memory for a world, in a static, a struct or on the stack.
///
/// `BYTES` comes from [`layout`](crate::layout), so the memory is exactly what the configuration needs. It is
/// all zero until [`init`](Self::init), so a static is in `.bss`.
#[repr(C, align(64))]
#[derive(Clone)]
pub struct InlineWorld<const BYTES: usize>([u8; BYTES]);

impl<const BYTES: usize> InlineWorld<BYTES> {
    /// No world yet: all zero.
    pub const EMPTY: Self = Self([0; BYTES]);

    /// Makes an empty world, whatever was there before: see [`World::new_in`].
    pub fn init<I: Index>(&mut self, config: &Config) -> Result<World<'_, I>, Error> {
        World::new_in(&mut self.0, config)
    }

    /// Moves a world here, from wherever it is: see [`World::move_into`].
    #[doc(alias = "move_to")]
    pub fn receive<I: Index>(
        &mut self,
        world: &World<'_, I>,
        config: &Config,
    ) -> Result<World<'_, I>, Error> {
        world.move_into(&mut self.0, config)
    }

    /// The world that [`init`](Self::init) made; before that none can be opened: see [`World::open`].
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
        Self::EMPTY
    }
}
