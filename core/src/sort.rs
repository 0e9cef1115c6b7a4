//! Heaps, the heap sort and a selection: no scratch memory, no recursion, no panic.

use crate::access::Access;

/// Sorts items by a total order. O(n log n).
#[inline(never)]
pub fn heapsort<T: Copy + Default>(items: &mut [T], precedes: impl Fn(T, T) -> bool) {
    for root in (0..items.len() / 2).rev() {
        sift_down(items, root, &precedes);
    }
    for end in (1..items.len()).rev() {
        items.swap_at(0, end);
        sift_down(items.span_mut(0, end), 0, &precedes);
    }
}

/// Brings the first `middle` items of a total order to the front. Expected O(n), at most O(n log n).
pub(crate) fn select<T: Copy + Default>(
    mut items: &mut [T],
    mut middle: usize,
    precedes: &impl Fn(&T, &T) -> bool,
) {
    for _ in 0..2 * (usize::BITS - items.len().leading_zeros()) {
        if items.len() <= 16 {
            break;
        }
        // The median of three has items on both sides.
        let (mut low, mut pivot, high) = (items.at(0), items.at(items.len() / 2), items.at(items.len() - 1));
        if precedes(&pivot, &low) {
            core::mem::swap(&mut low, &mut pivot);
        }
        if precedes(&high, &pivot) {
            pivot = if precedes(&high, &low) { low } else { high };
        }
        let mut end = 0;
        for at in 0..items.len() {
            if precedes(&items.at(at), &pivot) {
                items.swap_at(at, end);
                end += 1;
            }
        }
        let (front, back) = items.split_at_mut_checked(end).unwrap_or_default();
        items = if middle < end { front } else { back };
        middle = if middle < end { middle } else { middle - end };
        if middle == 0 {
            return;
        }
    }
    heapsort(items, |a, b| precedes(&a, &b));
}

/// Puts an item to a free place of a heap, or above it, at most at `root`, for which items move down. The last
/// item in order is at the root. O(log n).
#[inline(always)]
pub(crate) fn sift_up<T: Copy + Default>(
    heap: &mut [T],
    root: usize,
    mut at: usize,
    item: T,
    precedes: &impl Fn(T, T) -> bool,
) {
    while at > root && precedes(heap.at((at - 1) / 2), item) {
        heap.put(at, heap.at((at - 1) / 2));
        at = (at - 1) / 2;
    }
    heap.put(at, item);
}

/// Moves an item of such a heap down to its place. O(log n).
pub(crate) fn sift_down<T: Copy + Default>(heap: &mut [T], root: usize, precedes: &impl Fn(T, T) -> bool) {
    // Down to a leaf by the larger children, then up again. Most items belong near the leaves, and this way
    // down takes one comparison a level instead of two.
    let item = heap.at(root);
    let mut at = root;
    loop {
        let mut child = 2 * at + 1;
        if child >= heap.len() {
            break;
        }
        if child + 1 < heap.len() && precedes(heap.at(child), heap.at(child + 1)) {
            child += 1;
        }
        heap.put(at, heap.at(child));
        at = child;
    }
    sift_up(heap, root, at, item, precedes);
}
