//! Heaps and the heap sort: no scratch memory, no recursion, no panic.

use crate::access::Access;

/// Sorts items by a total order. O(n log n).
#[inline(never)]
pub(crate) fn heapsort<T: Copy + Default>(items: &mut [T], precedes: impl Fn(T, T) -> bool) {
    // The first rounds make the heap, the others take the last items off it.
    let count = items.len();
    for round in (0..count + count / 2).rev() {
        let (root, end) = if round >= count { (round - count, count) } else { (0, round) };
        if round < count {
            items.swap_at(0, round);
        }
        // Down to a leaf by the larger children, then up again. Most items belong near the leaves, and this way down
        // takes one comparison a level instead of two.
        let item = items.at(root);
        let mut at = root;
        loop {
            let mut child = 2 * at + 1;
            if child >= end {
                break;
            }
            if child + 1 < end && precedes(items.at(child), items.at(child + 1)) {
                child += 1;
            }
            items.put(at, items.at(child));
            at = child;
        }
        while at > root && precedes(items.at((at - 1) / 2), item) {
            items.put(at, items.at((at - 1) / 2));
            at = (at - 1) / 2;
        }
        items.put(at, item);
    }
}

/// Moves the last item of a heap up to its place. The last item in order is at the root. O(log n).
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

/// Moves an item of such a heap down to its place. O(log n).
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
