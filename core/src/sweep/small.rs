//! Sweeps the boxes themselves along a sorted list (paper, section IV): no records and no batches. A small
//! processor has no vectors that would repay them.

use crate::filter::FILTERS;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::pairs::pair_filter::PairFilter;

/// The result of a sweep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    /// Overlapping pairs, whether there was room or not.
    pub(crate) pairs: usize,
    /// Pairs of boxes that overlap along the axis.
    pub(crate) candidates: usize,
}

/// Writes the pairs of overlapping boxes that fit, behind those `found` before: of a list, or of two lists if the second one has
/// objects. Lists have slots by ascending minimum on the first of two axes; the second one is tested first. O(n + candidates);
/// candidates are at most n²/2.
pub(crate) fn sweep<I: Index>(
    lists: [&[I]; 2],
    boxes: &[KeyBox],
    axes: [usize; 2],
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
    found: &mut Found,
) {
    match axes {
        [0, 1] => sweep_along::<I, 0, 1, 2>(lists, boxes, pair_filter, pairs, found),
        [0, _] => sweep_along::<I, 0, 2, 1>(lists, boxes, pair_filter, pairs, found),
        [1, 2] => sweep_along::<I, 1, 2, 0>(lists, boxes, pair_filter, pairs, found),
        [1, _] => sweep_along::<I, 1, 0, 2>(lists, boxes, pair_filter, pairs, found),
        [_, 0] => sweep_along::<I, 2, 0, 1>(lists, boxes, pair_filter, pairs, found),
        _ => sweep_along::<I, 2, 1, 0>(lists, boxes, pair_filter, pairs, found),
    }
}

/// With constant axes, and not inline, so that the inner loop stays in registers.
#[inline(never)]
fn sweep_along<I: Index, const W: usize, const U: usize, const V: usize>(
    [mut rest, mut other]: [&[I]; 2],
    boxes: &[KeyBox],
    pair_filter: Option<PairFilter<'_>>,
    pairs: &mut [Pair<I>],
    found: &mut Found,
) {
    let across = FILTERS && !other.is_empty();
    while let Some((&slot, behind)) = rest.split_first() {
        let KeyBox { min, max } = *KeyBox::of(boxes, slot.at());
        let mut others = behind;
        if across {
            // The lower one of the first two meets the other list.
            match other.first() {
                None => break,
                Some(next) if KeyBox::of(boxes, next.at()).min[W] < min[W] => {
                    core::mem::swap(&mut rest, &mut other);
                    continue;
                }
                Some(_) => others = other,
            }
        }
        rest = behind;
        let mut ahead = others;
        while let Some((&other, behind)) = ahead.split_first() {
            let Some(b) = boxes.get(other.at()) else { break };
            if b.min[W] > max[W] {
                break;
            }
            ahead = behind;
            if b.min[U] <= max[U] && min[U] <= b.max[U] && b.min[V] <= max[V] && min[V] <= b.max[V] {
                let pair = pair(slot.slot(), other.slot());
                if pair_filter.is_none_or(|pair_filter| pair_filter.lets_through(&pair)) {
                    if let Some(place) = pairs.get_mut(found.pairs) {
                        *place = pair;
                    }
                    found.pairs += 1;
                }
            }
        }
        found.candidates += others.len() - ahead.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lists::links::repair;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    /// Boxes of one size or of many, spread or on a heap, some with equal sides.
    fn boxes() -> impl Strategy<Value = Vec<KeyBox>> {
        let low = prop_oneof![-40i32..40, -4000i32..4000];
        let one = ([low.clone(), low.clone(), low], [0i32..60, 0i32..60, 0i32..60], 0i32..40);
        (prop::collection::vec(one, 0..256), 0u32..8).prop_map(|(boxes, shift)| {
            let bounds = |(min, size, large): ([i32; 3], [i32; 3], i32)| {
                let stretch = if large == 0 { 100 } else { 1 };
                let min = min.map(|low| low >> shift);
                KeyBox { min, max: [0, 1, 2].map(|k| min[k] + size[k] * stretch) }
            };
            boxes.into_iter().map(bounds).collect()
        })
    }

    /// All pairs, by brute force.
    fn overlaps(boxes: &[KeyBox]) -> Vec<Pair<u16>> {
        let all = (0..boxes.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
        all.filter(|[a, b]| boxes[*a].overlaps(&boxes[*b])).map(|pair| pair.map(|slot| slot as u16)).collect()
    }

    /// Checks that a sweep has found the right pairs, or as many of them as had room.
    fn check(boxes: &[KeyBox], full: bool, sweep: impl FnOnce(&mut [Pair<u16>]) -> Found) {
        let mut expected = overlaps(boxes);
        expected.sort_unstable();
        let mut pairs = vec![[0; 2]; if full { expected.len() / 2 } else { expected.len() }];
        let found = sweep(&mut pairs);
        assert_eq!(found.pairs, expected.len());
        assert!(found.candidates >= found.pairs && 2 * found.candidates <= boxes.len() * boxes.len());
        pairs.sort_unstable();
        if full {
            assert!(pairs.windows(2).all(|two| two[0] < two[1]));
            assert!(pairs.iter().all(|pair| expected.binary_search(pair).is_ok()));
        } else {
            assert_eq!(pairs, expected);
        }
    }

    proptest! {
        #[test]
        fn each_pair_is_found_once(boxes in boxes(), axes in (0usize..3, 1usize..3), full in any::<bool>()) {
            let axes = [axes.0, (axes.0 + axes.1) % 3];
            let mut order: Vec<u16> = (0..boxes.len() as u16).collect();
            repair(&mut order, &boxes, axes[0]);
            check(&boxes, full, |pairs| {
                let mut found = Found::default();
                sweep([&order, &[]], &boxes, axes, None, pairs, &mut found);
                found
            });
            // In two parts: each by itself, then one against the other.
            check(&boxes, full, |pairs| {
                let (a, b): (Vec<u16>, Vec<u16>) = order.iter().partition(|slot| **slot % 3 == 0);
                let mut found = Found::default();
                for part in [&a, &b] {
                    sweep([part, &[]], &boxes, axes, None, pairs, &mut found);
                }
                if !b.is_empty() {
                    sweep([&a, &b], &boxes, axes, None, pairs, &mut found);
                }
                found
            });
        }
    }
}
