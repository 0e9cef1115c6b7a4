//! Sorts where the items are: no scratch memory, no recursion, no panic. Also keeps the first ones of a stream.

use crate::access::Access;

/// Sorts items by a total order. O(n log n).
pub(crate) fn heapsort<T: Copy + Default>(items: &mut [T], precedes: impl Fn(T, T) -> bool) {
    for root in (0..items.len() / 2).rev() {
        sift_down(items, root, &precedes);
    }
    for end in (1..items.len()).rev() {
        items.swap_at(0, end);
        sift_down(items.span_mut(0, end), 0, &precedes);
    }
}

/// Brings the last item of a heap, whose last one in order is at the root, up to its place. O(log n).
pub(crate) fn sift_up<T: Copy + Default>(heap: &mut [T], precedes: &impl Fn(T, T) -> bool) {
    let mut at = heap.len().saturating_sub(1);
    while at > 0 {
        let parent = (at - 1) / 2;
        if !precedes(heap.at(parent), heap.at(at)) {
            return;
        }
        heap.swap_at(parent, at);
        at = parent;
    }
}

/// Brings an item of such a heap down to its place. O(log n).
pub(crate) fn sift_down<T: Copy + Default>(heap: &mut [T], mut at: usize, precedes: &impl Fn(T, T) -> bool) {
    loop {
        let mut child = 2 * at + 1;
        if child >= heap.len() {
            return;
        }
        if child + 1 < heap.len() && precedes(heap.at(child), heap.at(child + 1)) {
            child += 1;
        }
        if !precedes(heap.at(at), heap.at(child)) {
            return;
        }
        heap.swap_at(at, child);
        at = child;
    }
}
