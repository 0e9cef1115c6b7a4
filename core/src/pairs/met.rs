//! Events of worlds without a tree: a bit for each two slots says whether the last complete result had the
//! pair. These have few slots, and to compare the boxes of two steps takes a small processor longer.

use super::partition::{is_clear_of, one_by_one};
use crate::access::Access;
use crate::id::{Index, Pair};
use crate::memory::limits::row_of_bits;
use crate::memory::slab::{OutputParts, Parts};
use crate::memory::state::{PairState, State};

/// Brings the pairs of a complete result that the last one had, too, to its front, and those of the last one
/// that are lost to the front of that. Returns how many persist and how many are lost. Slots may be `reused`
/// since by other objects, whose pairs are others. With `FEW` slots each has one word. O(pairs + n² / 32).
// Not inline, so that its loops stay in registers.
#[inline(never)]
pub(crate) fn compare<I: Index, const FEW: bool>(
    met: &mut [u32],
    result: &mut [Pair<I>],
    last: &mut [Pair<I>],
    reused: &[u32],
) -> (usize, usize) {
    let asked = if reused.is_empty() { &[] } else { &*last };
    let others = asked.iter().filter(|pair| !is_clear_of(reused, pair));
    others.for_each(|pair| put::<I, FEW>(met, pair, false));
    let persisting = one_by_one(result, |pair| has::<I, FEW>(met, pair));
    let (same, found) = result.split_at_mut_checked(persisting).unwrap_or_default();
    let mut lost = 0;
    if persisting < last.len() {
        met.fill(0);
        same.iter().for_each(|pair| put::<I, FEW>(met, pair, true));
        lost = one_by_one(last, |pair| !has::<I, FEW>(met, pair));
    }
    found.iter().for_each(|pair| put::<I, FEW>(met, pair, true));
    (persisting, lost)
}

/// The pairs of the last complete result, of a world without a tree.
pub(crate) fn last_result<'p, I: Index>(state: &State, output: &'p OutputParts<'_, I>) -> &'p [Pair<I>] {
    let PairState { complete, reported, previous, .. } = state.pairs;
    let (from, count) = if complete != 0 { (&output.pairs, reported) } else { (&output.previous, previous) };
    from.span(0, count as usize)
}

/// Sets the bits of the last complete result. O(pairs + n² / 32).
pub(crate) fn set_all<I: Index>(parts: &mut Parts<'_, I>) {
    parts.met.fill(0);
    let last = if parts.met.is_empty() { &[] } else { last_result(parts.state, &parts.output) };
    last.iter().for_each(|pair| put::<I, false>(parts.met, pair, true));
}

/// The word of a pair's bit, and which bit it is.
#[inline(always)]
fn place<I: Index, const FEW: bool>(pair: &Pair<I>) -> (usize, u32) {
    let (low, high) = (pair[0].at(), pair[1].at());
    if FEW { (high, low as u32) } else { (row_of_bits(high) + low / 32, low as u32) }
}

#[inline(always)]
pub(crate) fn has<I: Index, const FEW: bool>(met: &[u32], pair: &Pair<I>) -> bool {
    let (word, bit) = place::<I, FEW>(pair);
    met.get(word).is_some_and(|word| word.wrapping_shr(bit) & 1 != 0)
}

#[inline(always)]
fn put<I: Index, const FEW: bool>(met: &mut [u32], pair: &Pair<I>, met_now: bool) {
    let (word, bit) = place::<I, FEW>(pair);
    if let Some(word) = met.get_mut(word) {
        *word = *word & !1u32.wrapping_shl(bit) | u32::from(met_now).wrapping_shl(bit);
    }
}
