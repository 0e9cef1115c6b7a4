//! Saves a world to plain bytes and brings it back, for rollback and for files.
//!
//! A snapshot has what the next step needs and nothing that it can work out: no scratch memory, no records of the tree, no
//! boxes of the last step that are still the boxes of this one. It holds positions, never addresses, so it can be loaded
//! into any world of the same configuration on any machine of the same byte order.

use crate::access::{Access, bits};
use crate::arch::Simd as _;
use crate::arch::scalar::Scalar;
use crate::error::Error;
use crate::id::Index;
use crate::layout::FINER;
use crate::state::State;
use crate::storage::Parts;
use crate::world::World;
use bytemuck::{Pod, Zeroable};

/// What a snapshot starts with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    magic: u64,
    /// Bytes behind the header.
    len: u64,
    /// Of these bytes.
    checksum: u64,
}

/// Also tells the version and the byte order.
const MAGIC: u64 = 0x7472_6973_6170_0006;

impl<I: Index> World<'_, I> {
    /// The bytes of a snapshot of the world as it is now. O(n / 32).
    #[must_use]
    pub fn snapshot_size(&self) -> usize {
        let mut count = 0;
        saved(&self.parts, &mut |bytes| count += bytes.len());
        size_of::<Header>() + count
    }

    /// Writes a snapshot to the front of `out` and returns its length. O(n + pairs).
    ///
    /// # Errors
    /// [`Error::OutputFull`]; nothing is written then.
    pub fn save(&self, out: &mut [u8]) -> Result<usize, Error> {
        let needed = self.snapshot_size();
        let full = Error::OutputFull { needed: needed as u64 };
        let out = out.get_mut(..needed).ok_or(full)?;
        let (header, body) = out.split_at_mut_checked(size_of::<Header>()).ok_or(full)?;
        let mut at = 0;
        saved(&self.parts, &mut |bytes| {
            body.span_mut(at, bytes.len()).copy_in(bytes);
            at += bytes.len();
        });
        let len = body.len() as u64;
        header.copy_in(bytemuck::bytes_of(&Header { magic: MAGIC, len, checksum: checksum(body) }));
        Ok(needed)
    }

    /// Replaces the world by the one that a snapshot was taken of; its last result comes with it. The configuration must be
    /// the same, but for the number of workers. O(n log n + pairs): all invariants are checked.
    ///
    /// # Errors
    /// [`Error::BadSnapshot`] where the bytes are no snapshot, or have changed since: the world stays as it is. Bytes that
    /// were forged so well that the checksum is right give the same error, and may leave an empty world.
    pub fn load(&mut self, snapshot: &[u8]) -> Result<(), Error> {
        let (header, body) = snapshot.split_at_checked(size_of::<Header>()).ok_or(Error::BadSnapshot)?;
        let header: Header = bytemuck::try_pod_read_unaligned(header).map_err(|_| Error::BadSnapshot)?;
        let len = usize::try_from(header.len).map_err(|_| Error::BadSnapshot)?;
        let body = body.get(..len).ok_or(Error::BadSnapshot)?;
        if header.magic != MAGIC || header.checksum != checksum(body) {
            return Err(Error::BadSnapshot);
        }
        let state = body.get(..size_of::<State>()).ok_or(Error::BadSnapshot)?;
        let mut state: State = bytemuck::try_pod_read_unaligned(state).map_err(|_| Error::BadSnapshot)?;
        if !state.is_like(self.parts.state) {
            return Err(Error::BadSnapshot);
        }
        state.adopt(self.parts.state);
        let config = self.config();
        if self.replace(state, body).is_none() {
            // It was whole when it was made, so it can be made again.
            *self.parts.state = State::new(&config, size_of::<I>());
            self.parts.clear();
            return Err(Error::BadSnapshot);
        }
        Ok(())
    }

    /// `None` where the bytes are not those of a valid world.
    fn replace(&mut self, state: State, body: &[u8]) -> Option<()> {
        let parts = &mut self.parts;
        parts.clear();
        *parts.state = state;
        in_range(parts).then_some(())?;
        let mut rest = body;
        let mut whole = true;
        loaded(parts, &mut |bytes| match rest.split_at_checked(bytes.len()) {
            Some((taken, left)) => {
                bytes.copy_in(taken);
                rest = left;
            }
            None => whole = false,
        });
        // The state came first, with the snapshot's number of workers.
        *parts.state = state;
        (whole && rest.is_empty() && slots_in_range(parts)).then_some(())?;
        remake(parts);
        are_in_place(parts).then_some(())?;
        self.validate().ok()
    }
}

/// Calls a function with the bytes of each section. One list for both directions, so that they cannot disagree.
macro_rules! walk {
    ($parts:ident, $each:ident, $span:ident, $bytes:ident) => {{
        let slots = $parts.state.slots as usize;
        let listed = if $parts.state.stale_lists == 0 { $parts.state.listed as usize } else { 0 };
        let words = bits::words(slots);
        let some = |len: usize, count: usize| if len == 0 { 0 } else { count };
        let leaves = if $parts.state.planted > 0 { $parts.tree.planes.len() } else { 0 };
        let large = if $parts.state.filled != 0 { $parts.state.large as usize } else { 0 };
        let pairs = $parts.state.swept_pairs as usize;
        let previous = match $parts.state.complete {
            0 => $parts.state.previous_result,
            _ => $parts.state.lost,
        } as usize;
        $each($bytes!($parts.boxes.now.$span(0, slots)));
        $each($bytes!($parts.boxes.fat.$span(0, some($parts.boxes.fat.len(), slots))));
        $each($bytes!($parts.boxes.margins.$span(0, some($parts.boxes.margins.len(), slots))));
        $each($bytes!($parts.filters.of.$span(0, some($parts.filters.of.len(), slots))));
        $each($bytes!($parts.filters.classes.$span(0, $parts.filters.classes.len())));
        $each($bytes!($parts.filters.changed.words.$span(0, some($parts.filters.of.len(), words))));
        $each($bytes!($parts.generations.$span(0, slots)));
        $each($bytes!($parts.moved.words.$span(0, words)));
        $each($bytes!($parts.resting.$span(0, words)));
        $each($bytes!($parts.changed.words.$span(0, some($parts.changed.words.len(), words))));
        $each($bytes!($parts.awake.$span(0, some($parts.awake.len(), words))));
        $each($bytes!($parts.order[0].$span(0, listed)));
        $each($bytes!($parts.order[1].$span(0, listed)));
        $each($bytes!($parts.order[2].$span(0, listed)));
        $each($bytes!($parts.output.planes.$span(0, $parts.output.planes.len())));
        $each($bytes!($parts.home.$span(0, some($parts.home.len(), slots))));
        $each($bytes!($parts.place.$span(0, some($parts.place.len(), slots))));
        $each($bytes!($parts.tree.planes.$span(0, leaves)));
        $each($bytes!($parts.tree.cells.$span(0, leaves)));
        $each($bytes!($parts.tree.frames.$span(0, leaves >> FINER)));
        $each($bytes!($parts.tree.leaves.$span(0, leaves)));
        $each($bytes!($parts.tree.bounds.$span(0, leaves)));
        $each($bytes!($parts.tree.nodes.$span(0, 2 * leaves >> FINER)));
        $each($bytes!(
            $parts.tree.fronts.$span($parts.state.large_start as usize * usize::from(large > 0), large)
        ));
        $each($bytes!($parts.output.pairs.$span(0, pairs)));
        $each($bytes!($parts.output.previous.$span(0, some($parts.output.previous.len(), previous))));
        // Of the boxes that the last step reported only those that differ from what it would report now.
        for slot in 0..some($parts.boxes.before.len(), slots) {
            if bits::test($parts.changed.words, slot) {
                $each($bytes!($parts.boxes.before.$span(slot, 1)));
            }
        }
    }};
}

macro_rules! bytes {
    ($items:expr) => {
        bytemuck::try_cast_slice::<_, u8>($items).unwrap_or_default()
    };
}

macro_rules! bytes_mut {
    ($items:expr) => {
        bytemuck::try_cast_slice_mut::<_, u8>($items).unwrap_or_default()
    };
}

fn saved<I: Index>(parts: &Parts<'_, I>, each: &mut dyn FnMut(&[u8])) {
    each(bytemuck::bytes_of(&parts.state.portable()));
    walk!(parts, each, span, bytes);
}

/// The state has to be there already, since it says how long the others are.
fn loaded<I: Index>(parts: &mut Parts<'_, I>, each: &mut dyn FnMut(&mut [u8])) {
    each(bytemuck::bytes_of_mut(parts.state));
    walk!(parts, each, span_mut, bytes_mut);
}

/// Whether the numbers of the state stay within the arrays.
fn in_range<I: Index>(parts: &Parts<'_, I>) -> bool {
    let (state, sizes) = (&*parts.state, &parts.sizes);
    let objects = state.live <= state.slots
        && state.slots as usize <= sizes.objects
        && state.free <= state.slots
        && (state.stale_lists != 0 || state.listed <= state.slots)
        && state.list_axis < 3
        && state.strip_axis < 3;
    // Planes go deeper than full steps do.
    let tree = state.depth <= sizes.depth.saturating_sub(FINER)
        && (state.refined == 0 || sizes.tree > 0 && u64::from(state.refined) <= (1 << state.depth) + 1)
        && state.planted as usize <= sizes.tree
        && (state.filled == 0 || state.planted > 0)
        && state.settled <= u64::from(state.planted).pow(2)
        && state.large_start as u64 + u64::from(state.large) <= sizes.fronts as u64;
    let aside = u64::from(state.aside);
    let result_end = u64::from(state.surplus_aside).saturating_add(state.result_pairs);
    let pairs = state.swept_pairs <= sizes.pairs as u64
        && result_end <= state.swept_pairs
        && state.surplus_aside <= state.aside
        && aside <= result_end
        && (state.aside == 0 || sizes.tree > 0)
        && state.found <= result_end - aside
        && state.previous_result <= sizes.previous as u64
        && state.lost <= state.previous_result;
    objects && tree && pairs
}

/// Whether the slots and positions in the arrays are those of objects, and the boxes are boxes.
fn slots_in_range<I: Index>(parts: &Parts<'_, I>) -> bool {
    let state = &*parts.state;
    let slots = state.slots as usize;
    let listed = if state.stale_lists == 0 { state.listed as usize } else { 0 };
    let is_slot = |slot: &I| slot.at() < slots;
    let boxes = parts.boxes.now.iter().chain(&*parts.boxes.fat).chain(&*parts.boxes.before);
    let mut good = boxes.into_iter().all(|bounds| bounds.is_empty() || bounds.is_valid());
    good &= parts.order.iter().all(|order| order.span(0, listed).iter().all(is_slot));
    for pairs in [&*parts.output.pairs, &*parts.output.previous] {
        good &= pairs.iter().flatten().all(|slot| slot.at() < slots.max(1));
    }
    for marks in
        [&*parts.moved.words, parts.changed.words, parts.filters.changed.words, parts.resting, parts.awake]
    {
        good &= bits::ones(marks).all(|slot| slot < slots);
    }
    good &= parts.output.planes.iter().all(|planes| planes.is_sorted());
    good &= parts.tree.leaves.iter().all(|leaf| leaf.settled as usize <= slots);
    if state.filled == 0 {
        return good;
    }
    let leaves = parts.tree.leaves.span(0, state.leaves() as usize);
    let mut end = 0;
    good &= leaves.iter().all(|leaf| {
        let follows = u64::from(leaf.start) == end;
        end += u64::from(leaf.room);
        follows && leaf.len <= leaf.room && end <= parts.tree.records.len() as u64 && leaf.axis < 3
    });
    let large = parts.tree.fronts.span(state.large_start as usize, state.large as usize);
    good &= large.iter().all(|front| (front.slot as usize) < slots);
    let mut members = 0u64;
    for (home, place) in parts.home.span(0, slots).iter().zip(&*parts.place) {
        let fits = match leaves.get(home.at()) {
            Some(leaf) => place.slot() < leaf.len,
            None => *home == I::NONE || *home == I::LARGE && place.slot() < state.large,
        };
        good &= fits;
        members += u64::from(*home < I::LARGE);
    }
    // With as many members as places, and each at a place of its leaf, `are_in_place` sees whether a place is taken twice.
    good && members == leaves.iter().map(|leaf| u64::from(leaf.len)).sum::<u64>()
}

/// Works out what the snapshot leaves out.
fn remake<I: Index>(parts: &mut Parts<'_, I>) {
    for mut marks in [parts.moved.lend(), parts.changed.lend(), parts.filters.changed.lend()] {
        marks.regroup();
    }
    let state = &*parts.state;
    let slots = state.slots as usize;
    if state.stale_lists == 0 {
        for slot in parts.order[0].span(0, state.listed as usize) {
            bits::set(parts.listed, slot.at());
        }
    }
    for slot in 0..slots.min(parts.boxes.before.len()) {
        if !bits::test(parts.changed.words, slot) {
            let reported = parts.boxes.reported(state.mode()).at(slot);
            parts.boxes.before.put(slot, reported);
        }
    }
    if state.filled == 0 {
        return;
    }
    let swept = parts.boxes.swept();
    for slot in 0..slots {
        let home = parts.home.at(slot);
        if home < I::LARGE {
            let frame = parts.tree.frames.at(home.at() >> state.finer());
            let at = parts.tree.leaves.at(home.at()).start as usize + parts.place.at(slot).at();
            parts.tree.records.put(at, Scalar.record(&frame, swept.at(slot), slot as u32));
        }
    }
}

/// Whether every object of the tree, moved since or not, stands where its home and place say, and nobody else does.
fn are_in_place<I: Index>(parts: &Parts<'_, I>) -> bool {
    let state = &*parts.state;
    if state.filled == 0 {
        return true;
    }
    let mut large = 0;
    let in_place = (0..state.slots as usize).all(|slot| {
        let (home, place) = (parts.home.at(slot), parts.place.at(slot).at());
        if home == I::LARGE {
            large += 1;
            return parts.tree.fronts.at(state.large_start as usize + place).slot as usize == slot;
        }
        let leaf = parts.tree.leaves.get(home.at()).copied().unwrap_or_default();
        home == I::NONE || parts.tree.records.at(leaf.start as usize + place).slot() as usize == slot
    });
    in_place && large == state.large
}

/// Four sums of products in turn, eight bytes at a time: fast, and any changed byte changes it.
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
