//! Sets the pairs of resting objects aside, so that a step with few movers does not touch them (paper, section III.B;
//! erratum E6).
//!
//! The pairs that are set aside stand at the front of the pair buffer. Neither object of such a pair is *awake*; as long
//! as only awake objects move, these pairs stay as they are, and a step deals with the others alone. When another object
//! moves, all pairs are looked at once, and it is awake from then on.

use crate::access::{Access, bits};
use crate::config::Mode;
use crate::error::Error;
use crate::id::{Id, Index, Pair};
use crate::storage::Parts;
use crate::world::World;

/// So many times as many objects may be awake as move, before those that do not move are taken for resting again.
const AWAKE_FOR_EACH_MOVER: u32 = 8;

/// Objects that the caller knows to rest, beside those that are seen to.
impl<I: Index> World<'_, I> {
    /// Puts objects to rest, all or none: their pairs with each other are set aside at the next step, and steps do not look at
    /// what the bounds array has for them. Whoever gets another box by [`set_aabb`](Self::set_aabb) or
    /// [`update_many`](Self::update_many) wakes. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    pub fn set_resting(&mut self, ids: &[Id]) -> Result<(), Error> {
        for id in ids {
            self.slot_of(*id)?;
        }
        let Parts { state, awake, resting, .. } = &mut self.parts;
        let mut new = false;
        for id in ids {
            let slot = id.slot() as usize;
            bits::set(resting, slot);
            if !awake.is_empty() && bits::test(awake, slot) {
                bits::clear(awake, slot);
                new = true;
            }
        }
        state.resting |= u32::from(!ids.is_empty());
        // A step that was not complete needs the pairs that are set aside.
        if new && state.complete != 0 {
            state.aside = 0;
        }
        Ok(())
    }

    /// Has steps look at the bounds array for objects again, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    pub fn wake(&mut self, ids: &[Id]) -> Result<(), Error> {
        for id in ids {
            self.slot_of(*id)?;
        }
        for id in ids {
            bits::clear(self.parts.resting, id.slot() as usize);
        }
        Ok(())
    }

    /// Whether the object was put to rest and has not been woken since.
    #[must_use]
    pub fn is_resting(&self, id: Id) -> bool {
        self.slot_of(id).is_ok_and(|slot| bits::test(self.parts.resting, slot))
    }
}

/// For a step that tests only what has moved: brings the pairs that stay to the front of the buffer and returns how many
/// there are. With events, the others are kept for the comparison.
pub(crate) fn carry<I: Index>(parts: &mut Parts<'_, I>) -> u64 {
    let margins = !parts.boxes.fat.is_empty();
    if parts.state.crept != 0 && margins && parts.state.mode() == Mode::Exact {
        // Inside their fat boxes, even resting objects may have come apart or together.
        parts.state.aside = 0;
    } else if !parts.sizes.is_small() && parts.sizes.tree > 0 && is_due(parts) {
        set_aside(parts);
    }
    keep_for_events(parts);
    let Parts { state, moved, output, .. } = parts;
    let pairs = output.pairs.span_mut(0, state.swept_pairs as usize);
    let aside = state.aside as usize;
    let mut kept = aside;
    for index in aside..pairs.len() {
        let pair = pairs.at(index);
        // Written always, kept or not, so that nothing depends on a guess of the branch predictor.
        pairs.put(kept, pair);
        kept += usize::from(is_clear_of(moved.words, &pair));
    }
    kept as u64
}

/// For a step that finds all pairs anew. With events, the last complete result is kept for the comparison.
pub(crate) fn start_over<I: Index>(parts: &mut Parts<'_, I>) {
    if parts.state.complete != 0 {
        parts.state.aside = 0;
        keep_for_events(parts);
    } else if parts.sizes.previous > 0 {
        // The others were kept by the step that found no room for all its pairs; these have stayed where they were.
        let (aside, others) = (parts.state.aside as usize, parts.state.previous_result as usize);
        parts.output.previous.span_mut(others, aside).copy_in(parts.output.pairs.span(0, aside));
        parts.state.previous_result += parts.state.aside;
    }
    parts.state.aside = 0;
}

/// With events, the reported pairs that are not set aside go to the other buffer.
fn keep_for_events<I: Index>(parts: &mut Parts<'_, I>) {
    if parts.sizes.previous > 0 {
        let first = parts.state.aside as usize;
        let count = parts.state.result_pairs as usize - first;
        parts.output.previous.span_mut(0, count).copy_in(parts.output.pairs.span(first, count));
        parts.state.previous_result = count as u64;
    }
}

/// Whether neither object of a pair is marked.
#[inline(always)]
pub(crate) fn is_clear_of<I: Index>(marks: &[u32], pair: &Pair<I>) -> bool {
    !(bits::test(marks, pair[0].at()) | bits::test(marks, pair[1].at()))
}

/// Whether other pairs should be set aside than those that are.
fn is_due<I: Index>(parts: &Parts<'_, I>) -> bool {
    parts.state.aside == 0 || parts.moved.exceeds(parts.awake)
}

/// Divides the pairs by who is awake: whoever moves now, and whoever has moved lately.
fn set_aside<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, moved, awake, output, .. } = parts;
    let most = AWAKE_FOR_EACH_MOVER.saturating_mul(moved.count());
    let lately = if state.aside > 0 && bits::count(awake) <= most { u32::MAX } else { 0 };
    for (awake, moved) in awake.iter_mut().zip(&*moved.words) {
        *awake = *awake & lately | moved;
    }
    let pairs = output.pairs.span_mut(0, state.result_pairs as usize);
    let mut aside = 0;
    for index in 0..pairs.len() {
        let pair = pairs.at(index);
        pairs.put(index, pairs.at(aside));
        pairs.put(aside, pair);
        aside += usize::from(is_clear_of(awake, &pair));
    }
    state.aside = aside as u64;
}
