//! Puts the result of a step into ascending order on request: a radix sort in place, the highest digits first.

use crate::access::Access;
use crate::id::{Index, Pair};
use crate::memory::slab::Parts;
use crate::pairs::results::exchange;
use crate::sort::heapsort;

/// Runs of pairs that are sorted by comparing them.
const FEW: usize = 24;

/// Sorts persisting, found and lost pairs, each by their slots. After a step without room for all pairs nothing is
/// done: which pairs fitted has no rule.
pub(crate) fn sort_results<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, output, .. } = parts;
    if state.pairs.complete == 0 {
        return;
    }
    // The parked surplus in front of the result goes behind it. Then nothing is parked.
    let surplus = core::mem::take(&mut state.pairs.surplus_parked) as usize;
    let (result, found) = (state.pairs.reported as usize, state.pairs.found as usize);
    let persisting = result - found;
    exchange(output.pairs.span_mut(0, surplus + persisting), surplus);
    exchange(output.pairs.span_mut(persisting, surplus + found), surplus);
    (state.pairs.parked, state.pairs.active) = (0, u32::MAX);
    sort(output.pairs.span_mut(0, persisting), state.objects.slots);
    sort(output.pairs.span_mut(persisting, found), state.objects.slots);
    sort(output.previous.span_mut(0, state.pairs.lost as usize), state.objects.slots);
}

/// Sorts pairs of so many slots. O(pairs) for each byte of a pair.
fn sort<I: Index>(pairs: &mut [Pair<I>], slots: u32) {
    if !cfg!(feature = "large") {
        return heapsort(pairs, |a, b| a < b);
    }
    let bits = u32::BITS - slots.leading_zeros();
    let key = |pair: &Pair<I>| u64::from(pair[0].slot()) << bits | u64::from(pair[1].slot());
    for digit in (0..(2 * bits).div_ceil(8)).rev() {
        let above = |pair: &Pair<I>| key(pair) >> (8 * digit) >> 8;
        let (mut start, mut is_sorted) = (0, true);
        // Each run of pairs with the same digits above.
        while let Some(first) = pairs.get(start).map(above) {
            let rest = pairs.get_mut(start..).unwrap_or_default();
            let len = rest.iter().take_while(|pair| above(pair) == first).count();
            let run = rest.span_mut(0, len);
            if len <= FEW {
                heapsort(run, |a, b| a < b);
            } else {
                distribute(run, |pair| (key(pair) >> (8 * digit)) as u8);
                is_sorted = false;
            }
            start += len;
        }
        if is_sorted {
            return;
        }
    }
}

/// Brings pairs into the order of a digit, each at once to where it belongs.
fn distribute<I: Index>(pairs: &mut [Pair<I>], digit: impl Fn(&Pair<I>) -> u8) {
    let (mut next, mut ends) = ([0u32; 256], [0u32; 256]);
    for pair in &*pairs {
        ends[usize::from(digit(pair))] += 1;
    }
    let mut sum = 0;
    for (next, end) in next.iter_mut().zip(&mut ends) {
        *next = sum;
        sum += *end;
        *end = sum;
    }
    for own in 0..=255u8 {
        while next[usize::from(own)] < ends[usize::from(own)] {
            let place = next[usize::from(own)] as usize;
            let mut pair = pairs.at(place);
            loop {
                let to = digit(&pair);
                if to == own {
                    break;
                }
                let at = next[usize::from(to)] as usize;
                next[usize::from(to)] += 1;
                let other = pairs.at(at);
                pairs.put(at, pair);
                pair = other;
            }
            pairs.put(place, pair);
            next[usize::from(own)] += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn it_sorts(
            slots in 2u32..70_000,
            picks in prop::collection::vec((any::<u32>(), any::<u32>()), 0..3000),
            near in 1u32..70_000,
        ) {
            let mut pairs: Vec<Pair<u32>> =
                picks.iter().map(|(a, b)| [a % slots, b % slots.min(near)]).collect();
            let mut expected = pairs.clone();
            expected.sort_unstable();
            sort(&mut pairs, slots);
            prop_assert_eq!(pairs, expected);
        }
    }
}
