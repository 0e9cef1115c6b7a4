//! The shared lists: all objects in order on each axis.

use crate::Aabb;
use std::cmp::Ordering;

const NONE: u32 = u32::MAX;

/// The moves an object, on average, after which insertion sort is given up and the list is sorted anew (E13).
const MOST_MOVES: u64 = 3;

/// Three doubly linked lists of the same objects. The links of an object stand at its index, for each axis (E12).
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists([List; 3]);

#[derive(Clone, Debug, Default)]
struct List {
    /// The minimum of each object on the axis.
    keys: Vec<f32>,
    first: u32,
    next: Vec<u32>,
    previous: Vec<u32>,
}

impl Lists {
    /// Brings the lists in the order of these boxes. Tells by how many places nodes went back, and how many lists were
    /// sorted anew.
    pub(crate) fn update(&mut self, boxes: &[Aabb]) -> (u64, u32) {
        let (mut moves, mut sorted) = (0, 0);
        for (axis, list) in self.0.iter_mut().enumerate() {
            list.keys.clear();
            list.keys.extend(boxes.iter().map(|aabb| aabb.min[axis]));
            let is_new = list.next.len() != boxes.len();
            let of_list = if is_new { Err(0) } else { list.repair() };
            if of_list.is_err() {
                list.sort();
                sorted += 1;
            }
            moves += of_list.unwrap_or_else(|moves| moves);
        }
        (moves, sorted)
    }

    /// The objects in order on an axis.
    pub(crate) fn in_order(&self, axis: usize) -> impl Iterator<Item = u32> {
        let List { first, next, .. } = &self.0[axis];
        let mut at = *first;
        std::iter::from_fn(move || {
            let id = at;
            // Behind the last object, and in an empty list, there is no such index.
            at = *next.get(id as usize)?;
            Some(id)
        })
    }
}

/// By the minimum alone, and by the index where two are equal (E10).
fn order((x, a): (f32, u32), (y, b): (f32, u32)) -> Ordering {
    // Valid boxes have no NaN. Zeros of both signs are equal here, as they are in the sweep.
    x.partial_cmp(&y).unwrap_or(Ordering::Equal).then(a.cmp(&b))
}

impl List {
    /// By quicksort, from any order.
    fn sort(&mut self) {
        let objects = self.keys.len();
        let mut ids: Vec<(f32, u32)> = self.keys.iter().copied().zip(0..).collect();
        ids.sort_unstable_by(|&a, &b| order(a, b));
        self.next = vec![NONE; objects];
        self.previous = vec![NONE; objects];
        self.first = ids.first().map_or(NONE, |&(_, id)| id);
        for two in ids.windows(2) {
            let [before, after] = [two[0].1, two[1].1];
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
        }
    }

    /// By insertion sort, from an order that was right in the last step. Tells the moves: as an error where there were too
    /// many, and the order is not right yet.
    fn repair(&mut self) -> Result<u64, u64> {
        let most = MOST_MOVES * self.next.len() as u64;
        let mut moves = 0;
        // All up to here are in order.
        let mut last = self.first;
        while moves <= most {
            let Some(&id) = self.next.get(last as usize).filter(|&&id| id != NONE) else { return Ok(moves) };
            let with_key = |id: u32| (self.keys[id as usize], id);
            let mut before = last;
            while before != NONE && order(with_key(id), with_key(before)).is_lt() {
                before = self.previous[before as usize];
                moves += 1;
            }
            if before == last {
                last = id;
            } else {
                self.unlink(id);
                self.link_after(before, id);
            }
        }
        Err(moves)
    }

    fn unlink(&mut self, id: u32) {
        let (previous, next) = (self.previous[id as usize], self.next[id as usize]);
        self.join(previous, next);
    }

    /// `before`: `NONE` for the first place.
    fn link_after(&mut self, before: u32, id: u32) {
        let after = if before == NONE { self.first } else { self.next[before as usize] };
        self.join(before, id);
        self.join(id, after);
    }

    /// Makes two objects neighbours. `NONE` stands before the first object and behind the last.
    fn join(&mut self, before: u32, after: u32) {
        match self.next.get_mut(before as usize) {
            Some(next) => *next = after,
            None => self.first = after,
        }
        if let Some(previous) = self.previous.get_mut(after as usize) {
            *previous = before;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(minima: &[f32]) -> Vec<Aabb> {
        minima.iter().map(|&x| Aabb::new([x, -x, 0.0], [x + 1.0, 1.0 - x, 1.0])).collect()
    }

    fn in_order(lists: &Lists, boxes: &[Aabb]) {
        for axis in 0..3 {
            let ids: Vec<u32> = lists.in_order(axis).collect();
            let mut expected: Vec<u32> = (0..boxes.len() as u32).collect();
            let key = |id: u32| boxes[id as usize].min[axis];
            // `sort_by` keeps the order of the index where two are equal.
            expected.sort_by(|&a, &b| key(a).partial_cmp(&key(b)).expect("numbers"));
            assert_eq!(ids, expected, "axis {axis}");
            let List { first, previous, .. } = &lists.0[axis];
            assert_eq!(previous[*first as usize], NONE);
            assert!(ids.windows(2).all(|two| previous[two[1] as usize] == two[0]));
        }
    }

    #[test]
    fn insertion_repairs_each_axis() {
        let mut lists = Lists::default();
        let first = boxes(&[4.0, 2.0, 0.0, -0.0, 9.0, 2.0]);
        assert_eq!(lists.update(&first), (0, 3));
        in_order(&lists, &first);
        // 5.0 goes behind 4.0 on x and before it on y; the first and the last of a list change as well.
        let second = boxes(&[4.0, 5.0, 10.0, -0.0, 9.0, -3.0]);
        let (moves, sorted) = lists.update(&second);
        assert!(moves > 0 && sorted == 0);
        in_order(&lists, &second);
        assert_eq!(lists.update(&second), (0, 0));
    }

    #[test]
    fn a_list_that_is_turned_round_is_sorted_anew() {
        let minima: Vec<f32> = (0..1000).map(|x| x as f32).collect();
        let turned: Vec<f32> = minima.iter().map(|x| -x).collect();
        let mut lists = Lists::default();
        lists.update(&boxes(&minima));
        let (moves, sorted) = lists.update(&boxes(&turned));
        assert_eq!(sorted, 2);
        assert!(moves < 2 * (MOST_MOVES + 1) * 1000, "{moves}");
        in_order(&lists, &boxes(&turned));
    }

    #[test]
    fn an_empty_list_has_nobody() {
        let mut lists = Lists::default();
        assert_eq!(lists.in_order(0).count(), 0);
        lists.update(&[]);
        assert_eq!(lists.in_order(2).count(), 0);
    }
}
