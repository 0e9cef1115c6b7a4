//! From overlaps of swept boxes to the result: the exact test, and which pairs are new or gone.
//!
//! A pair is new exactly if its boxes did not overlap when the last complete step reported them, and gone exactly if
//! it stood in that step's result and does not overlap now. That needs no search: only the boxes that changed are
//! kept from then, and an object that is new or gone has the empty box. A reused slot follows by itself, since
//! the empty box is between the two objects.

use crate::access::{Access, bits};
use crate::id::{Index, Pair};
use crate::key::KeyBox;
use crate::storage::Parts;

/// The boxes that a result speaks of, now and at the last complete step.
struct Reported<'r> {
    now: &'r [KeyBox],
    before: &'r [KeyBox],
    changed: &'r [u32],
}

impl Reported<'_> {
    fn overlap_now(&self, a: usize, b: usize) -> bool {
        self.now.at(a).overlaps(&self.now.at(b))
    }

    fn then(&self, slot: usize) -> KeyBox {
        if bits::test(self.changed, slot) { self.before.at(slot) } else { self.now.at(slot) }
    }

    fn overlapped_then(&self, a: usize, b: usize) -> bool {
        self.then(a).overlaps(&self.then(b))
    }

    fn either_changed(&self, a: usize, b: usize) -> bool {
        bits::test(self.changed, a) || bits::test(self.changed, b)
    }
}

/// Keeps the pairs of two resting objects (erratum E6). With events they come from the other buffer, which stays as
/// it is. Returns how many there are.
pub(crate) fn carry_resting<I: Index>(parts: &mut Parts<'_, I>) -> u64 {
    let moved = &*parts.moved;
    let rests = |pair: &Pair<I>| !bits::test(moved, pair[0].at()) && !bits::test(moved, pair[1].at());
    let mut kept = 0;
    if parts.sizes.previous > 0 {
        for pair in parts.output.previous.span(0, parts.state.previous_swept as usize) {
            // Written always, kept or not, so that nothing depends on a guess of the branch predictor.
            parts.output.pairs.put(kept, *pair);
            kept += usize::from(rests(pair));
        }
    } else {
        for index in 0..parts.state.swept_pairs as usize {
            let pair = parts.output.pairs.at(index);
            parts.output.pairs.put(kept, pair);
            kept += usize::from(rests(&pair));
        }
    }
    kept as u64
}

/// Orders the first `swept` pairs of the buffer: persisting, found, surplus; and finds the lost ones. Events only where
/// the pairs are complete: of a part nobody can tell what is lost.
pub(crate) fn sort_out<I: Index>(parts: &mut Parts<'_, I>, swept: u64, exact_test: bool, complete: bool) {
    let events = parts.sizes.previous > 0 && complete;
    parts.state.lost = 0;
    let reported = Reported {
        now: parts.boxes.reported(parts.state.mode()),
        before: parts.boxes.before,
        changed: parts.changed,
    };
    let pairs = parts.output.pairs.span_mut(0, swept as usize);
    let result = if exact_test {
        partition(pairs, |pair| reported.overlap_now(pair[0].at(), pair[1].at()))
    } else {
        pairs.len()
    };
    let mut persisting = result;
    if events {
        persisting = partition(pairs.span_mut(0, result), |pair| {
            let (a, b) = (pair[0].at(), pair[1].at());
            !reported.either_changed(a, b) || reported.overlapped_then(a, b)
        });
        let previous = parts.output.previous.span_mut(0, parts.state.previous_result as usize);
        let lost = partition(previous, |pair| {
            let (a, b) = (pair[0].at(), pair[1].at());
            reported.either_changed(a, b) && !(reported.overlapped_then(a, b) && reported.overlap_now(a, b))
        });
        parts.state.lost = lost as u64;
    }
    parts.state.swept_pairs = swept;
    parts.state.result_pairs = result as u64;
    parts.state.found = (result - persisting) as u64;
}

/// Brings the pairs that `first` is true of to the front and returns how many there are.
fn partition<I: Index>(pairs: &mut [Pair<I>], first: impl Fn(&Pair<I>) -> bool) -> usize {
    let mut front = 0;
    for index in 0..pairs.len() {
        let pair = pairs.at(index);
        if first(&pair) {
            pairs.put(index, pairs.at(front));
            pairs.put(front, pair);
            front += 1;
        }
    }
    front
}
