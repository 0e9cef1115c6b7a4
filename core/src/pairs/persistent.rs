//! Keeps pairs from one step to the next. Pairs of two resting objects are parked, so that a step with few movers
//! does not touch them (paper, section III.B.1; erratum E6).
//!
//! Parked pairs are at the front of the pair buffer. Neither object of such a pair is *active*. While only active
//! objects get other boxes, parked pairs stay, and a step deals with the others alone. When another object gets
//! another box, it becomes active, and its parked pairs are unparked. When far fewer objects get other boxes than are
//! active, the others become inactive again.
//!
//! With margins, an object that moves inside its fat box is active too, since its exact pairs change. So no object of
//! a parked surplus pair is active either.

use crate::access::{Access, bits};
use crate::id::{Index, Pair};
use crate::memory::slab::Parts;
use crate::memory::state::{PairState, State};

/// This many times as many objects may be active as have another box, before the others become inactive.
const ACTIVE_FOR_EACH: u32 = 8;

/// Whether worlds can park pairs. Small builds have only worlds without a tree, which do not.
const PARKS: bool = cfg!(feature = "large");

/// For a step that tests only moved objects: brings the pairs of two others to the front of the buffer, those of the
/// result first, and returns how many there are. With events, the other pairs of the result are set aside to be compared.
pub(crate) fn persistent<I: Index>(parts: &mut Parts<'_, I>) -> u64 {
    if PARKS && !parts.sizes.is_small() && parts.sizes.tree > 0 {
        keep_parked(parts);
    }
    let Parts { state, moved, output, .. } = parts;
    let (swept, result, parked) =
        (state.pairs.swept as usize, state.pairs.result().end, state.pairs.parked as usize);
    let (mut kept, mut kept_result, mut gone) = (swept, result, 0);
    if cfg!(feature = "large") && moved.count() > 0 {
        let pairs = output.pairs.span_mut(0, swept);
        (kept_result, gone) = keep_clear(pairs, parked..result, parked, moved.words, output.previous);
        (kept, _) = keep_clear(pairs, result..swept, kept_result, moved.words, &mut []);
    }
    // From now on these are the last complete result.
    state.pairs.complete = 0;
    state.pairs.previous = gone as u64;
    (state.pairs.kept, state.pairs.kept_result) = (kept as u32, kept_result as u32);
    kept as u64
}

/// Pairs that are looked at together.
const TOGETHER: usize = 64;

/// Moves the pairs of a range without an object of a set to a position at or before it, in order, and writes the others to
/// another buffer as far as there is room. Returns where the first ones end and how many the others are.
fn keep_clear<I: Index>(
    pairs: &mut [Pair<I>],
    range: core::ops::Range<usize>,
    mut to: usize,
    set: &[u32],
    others: &mut [Pair<I>],
) -> (usize, usize) {
    let mut gone = 0;
    for start in range.clone().step_by(TOGETHER) {
        let len = TOGETHER.min(range.end - start);
        let mut goes = 0u64;
        for (bit, pair) in pairs.span(start, len).iter().enumerate() {
            goes |= u64::from(!is_clear_of(set, pair)) << bit;
        }
        if goes == 0 && to == start {
            to += len;
            continue;
        }
        for index in start..start + len {
            let pair = pairs.at(index);
            // Always written, kept or not: there is no branch to predict.
            pairs.put(to, pair);
            to += usize::from(goes & 1 == 0);
            if let Some(other) = others.get_mut(gone) {
                *other = pair;
                gone += usize::from(goes & 1 != 0);
            }
            goes >>= 1;
        }
    }
    (to, gone)
}

/// With events: sets aside the kept pairs of the result from a position on, too.
pub(crate) fn set_aside<I: Index>(parts: &mut Parts<'_, I>, from: usize) {
    let PairState { kept_result, previous, .. } = &mut parts.state.pairs;
    let pairs = parts.output.pairs.get(from..*kept_result as usize).unwrap_or_default();
    if let Some(to) = parts.output.previous.get_mut(*previous as usize..) {
        to.copy_in(pairs);
        *previous += pairs.len().min(to.len()) as u64;
    }
    *kept_result = (from as u32).min(*kept_result);
}

/// For a step that finds all pairs anew. With events, the last complete result is kept to be compared: the two
/// buffers change places.
pub(crate) fn start_over<I: Index>(parts: &mut Parts<'_, I>) {
    if parts.state.pairs.complete == 0 {
        set_aside(parts, parts.state.pairs.parked as usize);
    }
    let Parts { state, output, .. } = parts;
    let result = state.pairs.result();
    if parts.sizes.previous > 0 && state.pairs.complete != 0 {
        // The surplus in front is dropped. The last pairs of the result take its place.
        if PARKS {
            for at in 0..result.start.min(result.len()) {
                output.pairs.put(at, output.pairs.at(result.end - 1 - at));
            }
        }
        core::mem::swap(&mut output.pairs, &mut output.previous);
        state.pairs.swapped ^= 1;
        state.pairs.previous = result.len() as u64;
    } else if PARKS && parts.sizes.previous > 0 {
        // The step that did not end, or had no room for all its pairs, has set aside the others. The parked ones are still here.
        let parked = result.start..state.pairs.parked as usize;
        let others = state.pairs.previous as usize;
        state.pairs.previous += parked.len() as u64;
        let parked = output.pairs.span(parked.start, parked.len());
        output.previous.span_mut(others, parked.len()).copy_in(parked);
    }
    state.pairs.complete = 0;
    (state.pairs.parked, state.pairs.surplus_parked) = (0, 0);
    (state.pairs.kept, state.pairs.kept_result) = (0, 0);
    state.pairs.active = u32::MAX;
}

/// Whether neither object of a pair is in a set.
#[inline(always)]
pub(crate) fn is_clear_of<I: Index>(set: &[u32], pair: &Pair<I>) -> bool {
    !(bits::test(set, pair[0].at()) | bits::test(set, pair[1].at()))
}

/// Updates the active objects and the parked pairs.
fn keep_parked<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, moved, changed, active, output, .. } = parts;
    // Includes boxes that have changed inside their fat boxes: they may overlap others now that they did not before,
    // or no longer.
    let stirring = if changed.words.is_empty() { moved } else { changed };
    let (mut words, mut woken, mut paired) = (0, 0, 0);
    stirring.for_each_word(|index, word| {
        words += u32::from(word != 0);
        let new = u64::from(word & !active.at(index));
        woken |= new;
        // Objects in slots that were never used before have no pairs.
        paired |= new & ((1 << (state.tree.known as usize).saturating_sub(32 * index).min(32)) - 1);
    });
    let mut division = Division::of(state, output.pairs);
    if woken != 0 {
        for (active, stirring) in active.iter_mut().zip(&*stirring.words) {
            state.pairs.active = state.pairs.active.saturating_add((stirring & !*active).count_ones());
            *active |= stirring;
        }
        if paired != 0 {
            division.unpark(active);
        }
    }
    // Each word has at least one object, which is mostly enough to decide.
    let too_many = |count: u32| state.pairs.active > ACTIVE_FOR_EACH.saturating_mul(count);
    if too_many(words) && too_many(stirring.count()) {
        active.copy_in(stirring.words);
        state.pairs.active = stirring.count();
        division.park(active);
    }
    let [surplus_parked, parked, _, _] = division.ends;
    (state.pairs.surplus_parked, state.pairs.parked) = (surplus_parked as u32, parked as u32);
}

/// The pair buffer in four parts: parked surplus, parked result, other result, other surplus.
struct Division<'p, I> {
    pairs: &'p mut [Pair<I>],
    ends: [usize; 4],
}

impl<'p, I: Index> Division<'p, I> {
    fn of(state: &State, pairs: &'p mut [Pair<I>]) -> Self {
        let result = state.pairs.result();
        Self {
            pairs,
            ends: [result.start, state.pairs.parked as usize, result.end, state.pairs.swept as usize],
        }
    }

    /// Unparks the pairs of active objects. O(parked pairs).
    fn unpark(&mut self, active: &[u32]) {
        for index in (0..self.ends[1]).rev() {
            if is_clear_of(active, &self.pairs.at(index)) {
                continue;
            }
            // The last pair of each part in between makes room and becomes the first one of the next part.
            let mut at = index;
            let ends = if index < self.ends[0] { &mut self.ends[..3] } else { &mut self.ends[1..2] };
            for end in ends {
                *end -= 1;
                self.pairs.swap_at(at, *end);
                at = *end;
            }
        }
    }

    /// Parks the pairs of two objects that are not active. O(pairs not parked).
    fn park(&mut self, active: &[u32]) {
        for index in self.ends[1]..self.ends[3] {
            if !is_clear_of(active, &self.pairs.at(index)) {
                continue;
            }
            // The first pair of each part in between makes room and becomes the last one of the part before.
            let mut at = index;
            let ends = if index < self.ends[2] { &mut self.ends[1..2] } else { &mut self.ends[..3] };
            for end in ends.iter_mut().rev() {
                self.pairs.swap_at(at, *end);
                at = *end;
                *end += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aabb, Boxes, Capacity, Config, Kernels, Margin, World, layout};
    use std::{vec, vec::Vec};

    #[repr(C, align(64))]
    #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
    struct Line([u8; 64]);

    /// With margins as without: only the pairs of objects with another box are not parked, surplus or not.
    #[test]
    fn pairs_of_all_others_are_set_aside() {
        let plain = Config::new(Capacity::for_objects(1000));
        let margin = plain.with_margin(Margin::length(0.2));
        for config in [plain, plain.with_events(), margin, margin.with_events()] {
            let mut slab = vec![Line([0; 64]); layout::<u32>(&config).unwrap().bytes / 64];
            let mut world = World::<u32>::new_in(bytemuck::cast_slice_mut(&mut slab), &config).unwrap();
            // In a row: of each two neighbours the boxes overlap, or their fat boxes alone, in turn.
            let cube = |x: f32, y: f32| Aabb::new([x, y, 0.0], [x + 1.0, y + 1.0, 1.0]);
            let boxes: Vec<Aabb> =
                (0..1000u16).map(|k| cube(f32::from(k) + f32::from(k % 2) * -0.1, 0.0)).collect();
            let ids: Vec<_> = world.insert_many(Boxes::new(&boxes)).unwrap().collect();
            world.set_kernels(Kernels::BASELINE).step().unwrap();
            for (creeper, round) in [(5, 0.0), (5, 0.1), (500, 0.0), (500, 0.1), (5, 0.05)] {
                let moved = boxes[creeper].min[0];
                world.set_aabb(ids[creeper], cube(moved, 0.01 + round)).unwrap();
                world.set_kernels(Kernels::BASELINE).step().unwrap();
                let Parts { state, active, output, .. } = &world.parts;
                for (at, pair) in output.pairs.span(0, state.pairs.swept as usize).iter().enumerate() {
                    assert_eq!(
                        at < state.pairs.parked as usize,
                        is_clear_of(active, pair),
                        "{pair:?} at {at}"
                    );
                }
                assert!(bits::test(active, creeper) && bits::count(active) <= 2);
                assert_eq!(state.pairs.surplus_parked > 400, config.margin.is_some());
            }
        }
    }
}
