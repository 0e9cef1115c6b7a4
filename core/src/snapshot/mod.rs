//! Saves a world to plain bytes and loads it: for files, for players who join late, and for more room.
//!
//! A snapshot has what cannot be derived: the configuration, the objects, and the last result with what the
//! next events are compared with. It has no tree and no record: the next step makes these anew. What is not
//! there cannot be wrong. It holds positions and no addresses, so any world of the same kind can load it, on
//! any machine of the same byte order. To go back within a program a copy of the memory is faster.

pub(crate) mod check;
pub(crate) mod stored;

use crate::access::Access;
use crate::config::Config;
use crate::error::{Error, Field};
use crate::id::Index;
use crate::memory::layout::Sizes;
use crate::memory::state::{Setup, State};
use crate::world::World;
use stored::Stored;

/// What a snapshot starts with: [`MAGIC`], the bytes behind the header, and their checksum.
type Header = [u64; 3];

/// The version; it also tells the byte order.
const MAGIC: u64 = 0x7472_6973_6170_0010;

/// Snapshots: plain bytes, for files, for players who join late, and to go back.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let id = world.insert(cube(0.0))?;
/// world.insert(cube(0.5))?;
/// world.step()?;
/// let mut snapshot = vec![0; world.snapshot_size()];
/// world.save(&mut snapshot)?;
///
/// world.set_aabb(id, cube(5.0))?;
/// assert_eq!(world.step()?.lost(), [[0, 1]]);
/// world.load(&snapshot)?; // as if it had not been
/// assert_eq!(world.pairs(), [[0, 1]]);
/// assert!(world.step()?.lost().is_empty());
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// The bytes of a snapshot of the world as it is now. O(n / 32).
    #[must_use]
    pub fn snapshot_size(&self) -> usize {
        let mut size = size_of::<Header>();
        Stored::of(&self.parts).write(&mut |bytes| size += bytes.len());
        size
    }

    /// Writes a snapshot to the front of `out` and returns its length. O(n + pairs).
    ///
    /// # Errors
    /// [`Error::OutputFull`]; nothing is written then.
    #[doc(alias = "serialize")]
    pub fn save(&self, out: &mut [u8]) -> Result<usize, Error> {
        let needed = self.snapshot_size();
        let full = Error::OutputFull { needed: needed as u64, room: out.len() };
        let out = out.get_mut(..needed).ok_or(full)?;
        let mut at = size_of::<Header>();
        Stored::of(&self.parts).write(&mut |bytes| {
            out.span_mut(at, bytes.len()).copy_in(bytes);
            at += bytes.len();
        });
        let body = out.get(size_of::<Header>()..).unwrap_or_default();
        let header: Header = [MAGIC, body.len() as u64, checksum(body)];
        out.copy_in(bytemuck::bytes_of(&header));
        Ok(needed)
    }

    /// Replaces the world by that of a snapshot, with its last result. The configurations may differ as for
    /// [`move_into`](Self::move_into); the world keeps its own. Builds with other features read each other's
    /// snapshots of worlds that both can make. O(bytes).
    ///
    /// The next step finds all pairs anew, and tells as events what has changed since the result that was
    /// saved. The order of pairs and the kinds of later steps may differ from the world's that was
    /// saved; worlds that load the same snapshot go on alike, byte for byte, if their configurations are the
    /// same. Until that step queries look at all objects.
    ///
    /// The checksum notices damage, not intent. Forged bytes with a right checksum are refused, or they are a
    /// world: each object and each pair of it can be, and the pairs of every step are the overlaps of its
    /// boxes. The saved result and what the events of the first step compare with are as the bytes say.
    ///
    /// # Errors
    /// [`Error::BadSnapshot`] if the bytes are no snapshot, or have changed since;
    /// [`Error::CapacityTooLarge`] or [`Error::BadMargin`] if this build cannot make such a world;
    /// [`Error::NoRoom`] or [`Error::OtherConfig`] as for [`move_into`](Self::move_into). The world stays as it
    /// is.
    #[doc(alias("restore", "deserialize", "rollback"))]
    pub fn load(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let body = opened(snapshot).ok_or(Error::BadSnapshot)?;
        let (state, sections) = body.split_at_checked(size_of::<State>()).ok_or(Error::BadSnapshot)?;
        let state: State = bytemuck::try_pod_read_unaligned(state).map_err(|_| Error::BadSnapshot)?;
        if !state.is_portable() {
            return Err(Error::BadSnapshot);
        }
        if let Some(field) = state.setup.difference(&self.parts.state.setup) {
            return Err(Error::OtherConfig { field });
        }
        check_config::<I>(&state)?;
        let stored = Stored::<I>::cut(state, sections).ok_or(Error::BadSnapshot)?;
        check::all(&stored).map_err(|_| Error::BadSnapshot)?;
        check_room(&state, &self.parts.sizes)?;
        self.parts.clear(false);
        stored.put(&mut self.parts);
        Ok(())
    }
}

/// Growth.
impl<I: Index> World<'_, I> {
    /// Moves the world to other memory and another configuration, smaller ones if all fits. `slab`: as for
    /// [`new_in`](Self::new_in); what was in it is gone. This world stays as it is. O(bytes of the new slab).
    ///
    /// Everything goes on: ids, boxes, margins, filters, values, rest, the last result, so the next step
    /// tells what is found and lost since. After [`Error::PairsFull`] it can move to where there is room for
    /// the pairs; a step there tells events as if there had always been room. The next step finds all pairs
    /// anew.
    ///
    /// Capacities, workers, the margin of new objects and all choices about speed may change. The mode,
    /// events, filters, values and whether there are margins may not.
    ///
    /// # Errors
    /// [`Error::NoRoom`], which says what does not fit; [`Error::OtherConfig`]; the errors of `new_in`.
    /// Nothing is written then.
    ///
    /// ```
    /// use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
    ///
    /// const FEW: Config = Config::new(Capacity::for_objects(2).with_pairs(1)).with_events();
    /// const MORE: Config = Config::new(Capacity::for_objects(4).with_pairs(6)).with_events();
    /// let mut memory = InlineWorld::<{ layout::<u16>(&FEW).unwrap().bytes }>::EMPTY;
    /// let mut larger = InlineWorld::<{ layout::<u16>(&MORE).unwrap().bytes }>::EMPTY;
    ///
    /// let cube = Aabb::new([0.0; 3], [1.0; 3]);
    /// let mut world = memory.init::<u16>(&FEW)?;
    /// let ids = [world.insert(cube)?, world.insert(cube)?];
    /// world.step()?;
    /// assert_eq!(world.insert(cube), Err(Error::ObjectsFull { needed: 3, room: 2 }));
    ///
    /// let mut world = larger.receive(&world, &MORE)?;
    /// world.insert(cube)?;
    /// assert!(world.contains(ids[1]));
    /// assert_eq!(world.step()?.found().len(), 2);
    /// # Ok::<(), Error>(())
    /// ```
    #[doc(alias("move_to", "resize", "grow"))]
    pub fn move_into<'n>(&self, slab: &'n mut [u8], config: &Config) -> Result<World<'n, I>, Error> {
        let sizes = Sizes::of::<I>(config)?;
        let setup = Setup::new(config, size_of::<I>());
        if let Some(field) = self.parts.state.setup.difference(&setup) {
            return Err(Error::OtherConfig { field });
        }
        let stored = Stored::of(&self.parts);
        check_room(&stored.state, &sizes)?;
        let mut world = World::new_in(slab, config)?;
        stored.put(&mut world.parts);
        world.parts.watch.follow(&self.parts.watch);
        Ok(world)
    }
}

/// The bytes behind the header, if that is right.
fn opened(snapshot: &[u8]) -> Option<&[u8]> {
    let (header, body) = snapshot.split_at_checked(size_of::<Header>())?;
    let [magic, len, sum]: Header = bytemuck::try_pod_read_unaligned(header).ok()?;
    let body = body.get(..usize::try_from(len).ok()?)?;
    (magic == MAGIC && sum == checksum(body)).then_some(body)
}

/// Checks that this build can make the world of a state. Its sizes take no stack of a load.
#[inline(never)]
fn check_config<I: Index>(state: &State) -> Result<(), Error> {
    let config = state.setup.portable_config(size_of::<I>()).ok_or(Error::BadSnapshot)?;
    Sizes::of::<I>(&config).map(drop)
}

/// Checks that there is room for a world.
fn check_room(state: &State, sizes: &Sizes) -> Result<(), Error> {
    let (objects, pairs) = (state.objects.slots.into(), state.pairs.reported.max(state.pairs.previous));
    for (field, needed, room) in
        [(Field::Objects, objects, sizes.objects), (Field::Pairs, pairs, sizes.pairs)]
    {
        if needed > room as u64 {
            // All counts fit into 32 bits.
            return Err(Error::NoRoom { field, needed: needed as u32, room: room as u32 });
        }
    }
    Ok(())
}

/// Four chains of multiplications in turn, eight bytes at a time: any changed byte changes the result.
fn checksum(bytes: &[u8]) -> u64 {
    const PRIME: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut sums = [1u64, 2, 3, 4];
    let (lines, rest) = bytes.as_chunks::<32>();
    for line in lines {
        let (words, _) = line.as_chunks::<8>();
        for (sum, word) in sums.iter_mut().zip(words) {
            *sum = (*sum ^ u64::from_ne_bytes(*word)).wrapping_mul(PRIME).rotate_left(29);
        }
    }
    let mut sum = bytes.len() as u64;
    for byte in rest {
        sum = (sum ^ u64::from(*byte)).wrapping_mul(PRIME).rotate_left(29);
    }
    sums.iter().fold(sum, |sum, part| (sum ^ part).wrapping_mul(PRIME).rotate_left(29))
}
