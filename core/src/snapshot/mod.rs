//! Saves a world to plain bytes and loads it, for rollback and for files.
//!
//! A snapshot has what the next step needs, and nothing that follows from the rest: no scratch memory, no lists, no
//! cells and records, no boxes of the last step that are still the same. What is not there cannot be wrong. It holds
//! positions and no addresses, so any world of the same configuration can load it, on any machine of the same byte
//! order.

mod image;
mod replace;
mod transfer;

use crate::access::{Access, bits};
use crate::error::Error;
use crate::id::Index;
use crate::memory::layout::{Sizes, layout};
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::step::recount::prove_at_once;
use crate::tree::Frame;
use crate::validate::content::leaf;
use crate::validate::{content, content_without_tree, numbers};
use crate::world::World;
use bytemuck::{Pod, Zeroable};
use image::{Image, Lengths, Stored};
use replace::replace;
use transfer::{check_room, transfer};

/// What a snapshot starts with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    magic: u64,
    /// The bytes behind the header.
    len: u64,
    /// Of these bytes.
    checksum: u64,
}

/// The version; it also tells the byte order.
const MAGIC: u64 = 0x7472_6973_6170_000a;

/// Snapshots: plain bytes, for rollback and for files.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
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
        let mut count = Count(0);
        saved(&self.parts, &mut count);
        size_of::<Header>() + count.0
    }

    /// Writes a snapshot to the front of `out` and returns its length. A world that loads it goes on like this one,
    /// byte for byte: pairs, their order, events, statistics. O(n + pairs).
    ///
    /// # Errors
    /// [`Error::OutputFull`]; nothing is written then.
    pub fn save(&self, out: &mut [u8]) -> Result<usize, Error> {
        let needed = self.snapshot_size();
        let full = Error::OutputFull { needed: needed as u64, room: out.len() };
        let out = out.get_mut(..needed).ok_or(full)?;
        let (header, body) = out.split_at_mut_checked(size_of::<Header>()).ok_or(full)?;
        saved(&self.parts, &mut Write(&mut *body));
        let len = body.len() as u64;
        header.copy_in(bytemuck::bytes_of(&Header { magic: MAGIC, len, checksum: checksum(body) }));
        Ok(needed)
    }

    /// Replaces the world by that of a snapshot, with its last result. Builds with and without the feature `large`
    /// read each other's snapshots. O(n + pairs).
    ///
    /// If the configurations are the same, workers aside, the world goes on byte for byte. Else it goes on as after
    /// [`move_into`](Self::move_into), in its own configuration: with the same pairs and events, after a step that
    /// finds all pairs anew.
    ///
    /// Everything is checked before anything changes, also in bytes that were forged with a right checksum. A loaded
    /// world is [valid](Self::validate), and its steps find what brute force finds. Only the last result, the boxes
    /// that the next events compare with, and the statistics are as the bytes say. So the first step that would keep
    /// pairs looks once whether they are all; it takes several times as long as a step that finds them anew.
    ///
    /// # Errors
    /// [`Error::BadSnapshot`] if the bytes are no snapshot, or have changed since; [`Error::NoRoom`] or
    /// [`Error::OtherConfig`] as for [`move_into`](Self::move_into). The world stays as it is.
    pub fn load(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let body = opened(snapshot).ok_or(Error::BadSnapshot)?;
        let (state, sections) = body.split_at_checked(size_of::<State>()).ok_or(Error::BadSnapshot)?;
        let state: State = bytemuck::try_pod_read_unaligned(state).map_err(|_| Error::BadSnapshot)?;
        let parts = &mut self.parts;
        // Parts that belong to a world alone must be empty.
        if !state.is_portable() {
            return Err(Error::BadSnapshot);
        }
        if !state.setup.is_like(&parts.state.setup) {
            return adapted(parts, &state, sections);
        }
        if numbers(&state, &parts.sizes).is_err() {
            return Err(Error::BadSnapshot);
        }
        let stored = Stored::cut(&state, &parts.sizes, sections).ok_or(Error::BadSnapshot)?;
        // The histogram is scratch memory here.
        let placed = &mut *parts.tree.histogram;
        placed.fill(0);
        let mut image = Image { sizes: &parts.sizes, state: &state, stored, placed };
        content(&mut image).map_err(|_| Error::BadSnapshot)?;
        replace(parts, &state, &stored);
        Ok(())
    }
}

/// Replaces a world by one of another configuration.
fn adapted<I: Index>(parts: &mut Parts<'_, I>, state: &State, sections: &[u8]) -> Result<(), Error> {
    if let Some(field) = state.setup.difference(&parts.state.setup) {
        return Err(Error::OtherConfig { field });
    }
    let config = state.setup.portable_config(size_of::<I>()).ok_or(Error::BadSnapshot)?;
    let known = layout::<I>(&config).and_then(|_| Sizes::of::<I>(&config));
    let sizes = &known.ok_or(Error::BadSnapshot)?;
    numbers(state, sizes).map_err(|_| Error::BadSnapshot)?;
    let stored = Stored::cut(state, sizes, sections).ok_or(Error::BadSnapshot)?;
    // The tree stays behind, so it is not checked.
    let image = Image { sizes, state, stored, placed: &mut [] };
    content_without_tree(&image).map_err(|_| Error::BadSnapshot)?;
    check_room(state, &parts.sizes)?;
    parts.clear();
    transfer(&image, parts);
    parts.state.pairs.unproven = 1;
    if !cfg!(feature = "large") {
        prove_at_once(parts);
    }
    Ok(())
}

/// The bytes behind the header, if that is right.
fn opened(snapshot: &[u8]) -> Option<&[u8]> {
    let (header, body) = snapshot.split_at_checked(size_of::<Header>())?;
    let header: Header = bytemuck::try_pod_read_unaligned(header).ok()?;
    let body = body.get(..usize::try_from(header.len).ok()?)?;
    (header.magic == MAGIC && header.checksum == checksum(body)).then_some(body)
}

/// Takes the sections of a snapshot, one after another.
trait Sections {
    fn section<T: Pod>(&mut self, items: &[T]);
    /// So many items.
    fn each<T: Pod>(&mut self, count: usize, items: impl Iterator<Item = T>);
}

/// Adds up the bytes.
struct Count(usize);

impl Sections for Count {
    fn section<T: Pod>(&mut self, items: &[T]) {
        self.0 += size_of_val(items);
    }

    fn each<T: Pod>(&mut self, count: usize, _: impl Iterator<Item = T>) {
        self.0 += count * size_of::<T>();
    }
}

/// Writes sections to bytes of any alignment.
struct Write<'o>(&'o mut [u8]);

impl Write<'_> {
    #[inline(always)]
    fn write(&mut self, bytes: &[u8]) {
        let out = core::mem::take(&mut self.0);
        let (to, rest) = out.split_at_mut_checked(bytes.len()).unwrap_or_default();
        to.copy_in(bytes);
        self.0 = rest;
    }
}

impl Sections for Write<'_> {
    fn section<T: Pod>(&mut self, items: &[T]) {
        self.write(bytemuck::try_cast_slice(items).unwrap_or_default());
    }

    #[inline(always)]
    fn each<T: Pod>(&mut self, count: usize, items: impl Iterator<Item = T>) {
        let out = core::mem::take(&mut self.0);
        let (to, rest) = out.split_at_mut_checked(count * size_of::<T>()).unwrap_or_default();
        for (to, item) in to.chunks_exact_mut(size_of::<T>()).zip(items) {
            to.copy_in(bytemuck::bytes_of(&item));
        }
        self.0 = rest;
    }
}

/// Gives the sections of a world to `to`, in the order of [`Stored`].
fn saved<I: Index>(parts: &Parts<'_, I>, to: &mut impl Sections) {
    let (state, sizes, tree) = (&*parts.state, &parts.sizes, &parts.tree);
    let lengths = Lengths::of(state, sizes);
    let Lengths { slots, words, .. } = lengths;
    let kept = |room: usize, count: usize| if room > 0 { count } else { 0 };
    to.section(&[state.portable()]);
    to.section(parts.boxes.now.span(0, slots));
    to.section(parts.boxes.swept().span(0, kept(sizes.fat, slots)));
    to.section(parts.boxes.margins.span(0, kept(sizes.fat, slots)));
    to.section(parts.filters.of.span(0, kept(sizes.filters, slots)));
    to.section(parts.filters.classes);
    to.section(parts.filters.changed.words.span(0, kept(sizes.filters, words)));
    to.section(parts.values.of.span(0, kept(sizes.values, slots)));
    to.section(parts.generations.span(0, slots));
    to.section(parts.moved.words.span(0, words));
    to.section(parts.resting.span(0, words));
    to.section(parts.changed.words.span(0, kept(sizes.changed, words)));
    to.section(parts.active.span(0, kept(sizes.tree, words)));
    to.section(tree.planes.span(0, lengths.planes));
    to.each(lengths.leaves, (0..lengths.leaves).map(|index| leaf(parts, index)));
    let far = |whole: usize| tree.cells.at(whole << state.tree.sub_levels()).far();
    to.each(lengths.whole_leaves, (0..lengths.whole_leaves).map(far));
    let frames = tree.frames.span(0, lengths.whole_leaves).iter().map(Frame::parts);
    to.each(lengths.whole_leaves, frames);
    to.each(lengths.bounds, tree.bounds.span(0, lengths.bounds).iter().map(|bounds| bounds.lanes));
    to.section(tree.nodes.span(usize::from(lengths.nodes > 0), lengths.nodes));
    let filled = if state.tree.filled != 0 { lengths.leaves } else { 0 };
    for leaf in tree.leaves.span(0, filled) {
        let members = tree.records.span(leaf.start as usize, leaf.len as usize);
        to.each(members.len(), members.iter().map(|record| I::from_slot(record.slot())));
    }
    let large = tree.straddlers.span(kept(lengths.large, state.tree.large_start as usize), lengths.large);
    to.each(large.len(), large.iter().map(|straddler| I::from_slot(straddler.slot)));
    to.section(parts.output.pairs.span(0, lengths.pairs));
    to.section(parts.output.previous.span(0, kept(sizes.previous, lengths.previous)));
    let segments = &parts.output.segments;
    to.section([segments.blocks() as u32].span(0, kept(sizes.event_blocks, 1)));
    to.section(segments.ends.span(0, 2 * segments.blocks()));
    // Of the boxes that the last step reported, only those that may have changed since.
    let changed = parts.changed.words.span(0, kept(sizes.before, words));
    to.each(bits::count(changed) as usize, bits::ones(changed).map(|slot| parts.boxes.before.at(slot)));
    let former = &parts.former;
    let reused = former.reused.words.span(0, kept(sizes.before, words));
    to.section(reused);
    let count = bits::count(reused) as usize;
    to.each(count, bits::ones(reused).map(|slot| former.generations.at(slot)));
    let former_values = bits::ones(reused).map(|slot| parts.values.former.at(slot));
    to.each(kept(sizes.former_values, count), former_values);
}

/// Four chains of multiplications in turn, eight bytes at a time: fast, and any changed byte changes the result.
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
