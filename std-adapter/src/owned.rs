//! A world that brings its own memory.

use crate::memory::Memory;
use core::fmt;
use self_cell::{MutBorrow, self_cell};
use std::any::Any;
use std::sync::{Mutex, OnceLock, PoisonError};
use trisap_core::{Config, Error, Executor, Index, Rule, World};

/// A world in memory of its own, allocated once: on Linux in huge pages if it has two MiB or more, else on the heap.
///
/// [`OwnedWorld::world`] opens the [`World`] to change it. All state is in the memory, so a world that is opened
/// again goes on where the last one stopped. [`OwnedWorld::as_world`] looks at it through a shared reference, from
/// any number of threads.
///
/// ```
/// use trisap::{Aabb, Capacity, Config, OwnedWorld, Region};
///
/// let mut owned = OwnedWorld::new(&Config::new(Capacity::for_objects(100)))?;
/// let id = owned.world().insert(Aabb::new([0.0; 3], [1.0; 3]))?;
/// owned.world().step()?;
///
/// let shared = &owned; // as a resource of an ECS, or behind an Arc
/// std::thread::scope(|scope| {
///     for _ in 0..2 {
///         scope.spawn(|| {
///             let mut found = [None];
///             assert_eq!(shared.as_world().overlaps(&Region::Point([0.5; 3]), &mut found), Ok(1));
///             assert_eq!(found, [Some(id)]);
///         });
///     }
/// });
/// # Ok::<(), trisap::Error>(())
/// ```
pub struct OwnedWorld<I: Index = u32> {
    /// The memory, if the world has changed since it was last looked at.
    memory: Mutex<Option<Memory>>,
    /// Else the memory and the world in it.
    held: OnceLock<Box<dyn Held<I>>>,
    bytes: usize,
}

/// Memory and the world that was opened in it. A struct that refers to itself cannot be generic: there is one for each width.
trait Held<I: Index>: Send + Sync {
    fn world(&self) -> &World<'_, I>;
    fn change(&mut self, change: &mut dyn FnMut(&mut World<'_, I>));
    /// Compiled here, and not with the caller, which may not be optimised.
    fn step(&mut self, executor: &dyn Executor, rule: Option<&Rule<'_>>) -> Result<(), Error>;
    fn into_memory(self: Box<Self>) -> Memory;
}

macro_rules! held {
    ($($name:ident $world:ident $index:ty;)*) => {$(
        type $world<'m> = World<'m, $index>;

        self_cell!(
            struct $name {
                owner: MutBorrow<Memory>,
                #[covariant]
                dependent: $world,
            }
        );

        impl Held<$index> for $name {
            fn world(&self) -> &World<'_, $index> {
                self.borrow_dependent()
            }

            fn change(&mut self, change: &mut dyn FnMut(&mut World<'_, $index>)) {
                self.with_dependent_mut(|_, world| change(world));
            }

            fn step(&mut self, executor: &dyn Executor, rule: Option<&Rule<'_>>) -> Result<(), Error> {
                self.with_dependent_mut(|_, world| {
                    let stepper = world.on(executor);
                    let stepper = if let Some(rule) = rule { stepper.with_rule(rule) } else { stepper };
                    stepper.step().map(|_| ())
                })
            }

            fn into_memory(self: Box<Self>) -> Memory {
                self.into_owner().into_inner()
            }
        }
    )*};
}

held! {
    Narrow NarrowWorld u16;
    Wide WideWorld u32;
}

fn hold<I: Index>(memory: Memory) -> Box<dyn Held<I>> {
    let memory = MutBorrow::new(memory);
    let held: Box<dyn Any> = if size_of::<I>() == size_of::<u16>() {
        Box::new(Box::new(Narrow::new(memory, |memory| open(memory.borrow_mut()))) as Box<dyn Held<u16>>)
    } else {
        Box::new(Box::new(Wide::new(memory, |memory| open(memory.borrow_mut()))) as Box<dyn Held<u32>>)
    };
    *held.downcast().expect("slots have 16 or 32 bits")
}

impl OwnedWorld<u32> {
    /// An empty world for `config`, with slots of 32 bits. O(bytes).
    ///
    /// # Errors
    /// Those of [`World::new_in`]; memory that cannot be had is [`Error::NoMemory`].
    pub fn new(config: &Config) -> Result<Self, Error> {
        Self::with_index(config)
    }
}

impl<I: Index> OwnedWorld<I> {
    /// An empty world with slots of any width. O(bytes).
    ///
    /// # Errors
    /// Those of [`World::new_in`]; memory that cannot be had is [`Error::NoMemory`].
    pub fn with_index(config: &Config) -> Result<Self, Error> {
        let (mut memory, bytes) = memory::<I>(config)?;
        World::<I>::new_in(&mut memory, config)?;
        Ok(Self::of(memory, bytes))
    }

    /// As [`with_index`](Self::with_index), in the memory given if that is enough, or in some that nobody has written to: the pages
    /// come as they are used.
    pub(crate) fn reserved(used: Option<Memory>, config: &Config) -> Result<Self, Error> {
        let bytes = bytes::<I>(config)?;
        let used = used.filter(|memory| memory.len() >= bytes);
        let mut memory = used.or_else(|| Memory::reserved(bytes)).ok_or(Error::NoMemory { bytes })?;
        World::<I>::new_in(&mut memory, config)?;
        Ok(Self::of(memory, bytes))
    }

    /// The memory, for another world.
    pub(crate) fn into_memory(self) -> Memory {
        let memory = self.memory.into_inner().unwrap_or_else(PoisonError::into_inner);
        memory.or_else(|| self.held.into_inner().map(Held::into_memory)).expect(OWNED)
    }

    fn of(memory: Memory, bytes: usize) -> Self {
        Self { memory: Mutex::new(Some(memory)), held: OnceLock::new(), bytes }
    }

    /// The world, to change it. Opens it anew each time: O(1), some hundred nanoseconds. For many single changes keep what this
    /// returns, or use [`change`](Self::change).
    #[must_use]
    pub fn world(&mut self) -> World<'_, I> {
        let memory = self.memory.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(held) = self.held.take() {
            *memory = Some(held.into_memory());
        }
        open(memory.as_mut().expect(OWNED))
    }

    /// Changes the world, which stays open between such calls and looks: some nanoseconds each.
    pub fn change<T>(&mut self, change: impl FnOnce(&mut World<'_, I>) -> T) -> T {
        let _ = self.as_world();
        let (mut change, mut changed) = (Some(change), None);
        self.held
            .get_mut()
            .expect(OWNED)
            .change(&mut |world| changed = change.take().map(|change| change(world)));
        changed.expect("it is called once")
    }

    /// Steps: see [`World::on`] and [`World::with_rule`].
    pub(crate) fn step(&mut self, executor: &dyn Executor, rule: Option<&Rule<'_>>) -> Result<(), Error> {
        let _ = self.as_world();
        self.held.get_mut().expect(OWNED).step(executor, rule)
    }

    /// The world, to look at it: queries, results, boxes. Any number of threads may at once. O(1).
    #[must_use]
    pub fn as_world(&self) -> &World<'_, I> {
        let hold = || hold(self.memory.lock().unwrap_or_else(PoisonError::into_inner).take().expect(OWNED));
        self.held.get_or_init(hold).world()
    }

    /// Moves the world to memory for another configuration, with everything that it holds: see [`World::move_into`].
    ///
    /// # Errors
    /// Those of [`World::move_into`]; memory that cannot be had is [`Error::NoMemory`]. The world stays as it is then.
    #[doc(alias("move_into", "resize", "grow"))]
    pub fn move_to(&mut self, config: &Config) -> Result<(), Error> {
        let (mut memory, bytes) = memory::<I>(config)?;
        let _ = self.world().move_into(&mut memory, config)?;
        *self = Self::of(memory, bytes);
        Ok(())
    }

    /// The bytes of the world. Huge pages take up to two MiB more.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

const OWNED: &str = "either the memory or the world in it is there";

/// The bytes of a world.
fn bytes<I: Index>(config: &Config) -> Result<usize, Error> {
    // No memory is too little for any world.
    match World::<I>::new_in(&mut [], config) {
        Err(Error::SlabTooSmall { needed, .. }) => Ok(needed),
        said => said.map(|_| 0),
    }
}

fn memory<I: Index>(config: &Config) -> Result<(Memory, usize), Error> {
    let bytes = bytes::<I>(config)?;
    Ok((Memory::zeroed(bytes).ok_or(Error::NoMemory { bytes })?, bytes))
}

fn open<I: Index>(memory: &mut Memory) -> World<'_, I> {
    World::open(memory)
        .expect("a world of this width was made in the memory, and nobody else can write to it")
}

/// A copy goes on as the world would have, byte for byte: the way to go back to a frame is to keep copies.
/// [`clone_from`](Clone::clone_from) uses the memory that there is, and takes at most as long as a copy of it.
///
/// # Panics
/// If there is no memory for a copy.
impl<I: Index> Clone for OwnedWorld<I> {
    fn clone(&self) -> Self {
        let mut copy = Self::with_index(&self.as_world().config()).expect("memory for a copy");
        copy.world().copy_from(self.as_world()).expect("a world of the same configuration");
        copy
    }

    fn clone_from(&mut self, source: &Self) {
        if self.world().copy_from(source.as_world()).is_err() {
            *self = source.clone();
        }
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
    use trisap_core::{Aabb, Capacity, Field, Kernels};

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
        let too_large = |field, most| Err(Error::CapacityTooLarge { field, most });
        assert_eq!(
            OwnedWorld::<u16>::with_index(&more_than_u16).map(drop),
            too_large(Field::Objects, 65_534)
        );
        let no_worker = Config::new(Capacity::for_objects(8)).with_workers(0);
        assert_eq!(OwnedWorld::<u32>::new(&no_worker).map(drop), too_large(Field::Workers, 32));
    }

    /// Looking and changing take turns; a look sees the last change.
    #[test]
    fn several_threads_look_at_once() -> Result<(), Error> {
        let config = Config::new(Capacity::for_objects(8)).with_events();
        let mut owned = OwnedWorld::<u16>::with_index(&config)?;
        for count in 1..=5 {
            owned.world().insert(CUBE)?;
            owned.world().step()?;
            if count == 3 {
                owned.move_to(&config.with_capacity(Capacity::for_objects(70)))?;
            }
            let shared = &owned;
            let look = || {
                let world = shared.as_world();
                let mut hits = [None; 8];
                let near = world.nearest([0.5; 3], &mut hits).expect("a good point");
                (world.pairs().len(), world.found().len(), near)
            };
            std::thread::scope(|scope| {
                let threads = [(); 3].map(|()| scope.spawn(look));
                for thread in threads {
                    let seen = thread.join().expect("no panic");
                    assert_eq!(seen, (count * (count - 1) / 2, count - 1, count));
                }
            });
        }
        owned.world().clear();
        assert!(owned.as_world().is_empty() && owned.world().is_empty());
        Ok(())
    }

    /// A copy knows nothing of what happens later, and the other way round; also in other memory.
    #[test]
    fn a_copy_is_the_world_as_it_was() -> Result<(), Error> {
        let config = Config::new(Capacity::for_objects(8)).with_events();
        let mut owned = OwnedWorld::<u16>::with_index(&config)?;
        let ids = [owned.world().insert(CUBE)?, owned.world().insert(CUBE)?];
        owned.world().step()?;
        let kept = owned.clone();
        owned.world().remove(ids[0])?;
        assert_eq!(owned.world().step()?.lost(), [[0, 1]]);
        assert_eq!((kept.as_world().len(), kept.as_world().pairs()), (2, &[[0, 1]][..]));
        owned.clone_from(&kept);
        assert_eq!(owned.world().step()?.pairs(), [[0, 1]]);
        assert!(owned.as_world().contains(ids[0]) && owned.as_world().lost().is_empty());
        owned.move_to(&config.with_capacity(Capacity::for_objects(700)))?;
        owned.clone_from(&kept);
        assert_eq!((owned.as_world().config(), owned.bytes()), (config, kept.bytes()));
        Ok(())
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
