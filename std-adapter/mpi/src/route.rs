//! Which rank has to hear what of an object.

use crate::message::{Batch, Change, Newcomer};
use crate::split::{Cell, Split};
use crate::table::Object;

/// The split of the last step and that of this one.
pub(crate) struct Route<'s> {
    rank: usize,
    before: &'s Split,
    now: &'s Split,
    pub(crate) cell_before: Cell,
    pub(crate) cell_now: Cell,
    /// What each rank is told.
    pub(crate) batches: Vec<Batch>,
    reached_before: Vec<usize>,
    reached_now: Vec<usize>,
}

/// What becomes of an object on the rank that had it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// The rank owns it on.
    Stays,
    /// It belongs to another rank now, and still reaches this one.
    Ghost(usize),
    /// It belongs to another rank now and does not reach this one.
    Leaves(usize),
}

impl<'s> Route<'s> {
    pub(crate) fn new(rank: usize, before: &'s Split, now: &'s Split) -> Self {
        Self {
            rank,
            before,
            now,
            cell_before: before.cell(rank),
            cell_now: now.cell(rank),
            batches: vec![Batch::default(); now.ranks()],
            reached_before: Vec::new(),
            reached_now: Vec::new(),
        }
    }

    /// Tells all ranks that have to know of an object that this rank has had or removes. The box of the last step says who
    /// knows it so far.
    #[inline]
    pub(crate) fn tell(&mut self, object: &Object) -> Fate {
        let was_inside = self.cell_before.encloses(&object.before);
        if was_inside && self.cell_now.encloses(&object.now) {
            return Fate::Stays;
        }
        self.before.reach(&object.before, &mut self.reached_before);
        self.tell_others(object)
    }

    /// Tells all ranks that have to know of an object that this rank was given, and that nobody knows so far.
    pub(crate) fn tell_of_new(&mut self, object: &Object) -> Fate {
        self.reached_before.clear();
        self.tell_others(object)
    }

    fn tell_others(&mut self, object: &Object) -> Fate {
        let Object { key, now, before } = *object;
        self.now.reach(&now, &mut self.reached_now);
        let owner = self.now.rank_of(now.min);
        let newcomer = Newcomer { key, now, before };
        for &rank in self.reached_now.iter().filter(|&&rank| rank != self.rank) {
            let batch = &mut self.batches[rank];
            if rank == owner {
                batch.owned.push(newcomer);
            } else if !self.reached_before.contains(&rank) {
                batch.entered.push(newcomer);
            } else if now != before {
                batch.moved.push(Change { key, now });
            }
        }
        for &rank in self.reached_before.iter().filter(|&&rank| rank != self.rank) {
            if !self.reached_now.contains(&rank) {
                self.batches[rank].left.push(Change { key, now });
            }
        }
        if self.reached_now.is_empty() || owner == self.rank {
            Fate::Stays
        } else if self.reached_now.contains(&self.rank) {
            Fate::Ghost(owner)
        } else {
            Fate::Leaves(owner)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::NOWHERE;
    use trisap::Aabb;

    /// Two ranks: below and from x = 0 on.
    fn split(ranks: usize) -> Split {
        let mut points: Vec<_> = (-50..50).map(|i| [i as f32, 0.0, 0.0]).collect();
        Split::first_has_all(ranks).moved(&mut points)
    }

    fn cube(x: f32) -> Aabb {
        Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
    }

    fn told(before: Aabb, now: Aabb) -> (Fate, Batch) {
        let split = split(2);
        let mut route = Route::new(0, &split, &split);
        let fate = route.tell(&Object { key: 1, now, before });
        assert_eq!(route.batches[0], Batch::default(), "no rank tells itself");
        (fate, route.batches.remove(1))
    }

    #[test]
    fn others_hear_what_they_need() {
        let change = |now| vec![Change { key: 1, now }];
        let newcomer = |now, before| vec![Newcomer { key: 1, now, before }];
        let (inside, across, far) = (cube(-9.0), cube(-0.5), cube(5.0));
        assert_eq!(told(inside, cube(-8.0)), (Fate::Stays, Batch::default()));
        let entered = Batch { entered: newcomer(across, inside), ..Batch::default() };
        assert_eq!(told(inside, across), (Fate::Stays, entered));
        assert_eq!(told(across, across), (Fate::Stays, Batch::default()));
        let moved = Batch { moved: change(cube(-0.6)), ..Batch::default() };
        assert_eq!(told(across, cube(-0.6)), (Fate::Stays, moved));
        let left = Batch { left: change(inside), ..Batch::default() };
        assert_eq!(told(across, inside), (Fate::Stays, left));
        let removed = Batch { left: change(NOWHERE), ..Batch::default() };
        assert_eq!(told(across, NOWHERE), (Fate::Stays, removed));
        let owned = Batch { owned: newcomer(far, inside), ..Batch::default() };
        assert_eq!(told(inside, far), (Fate::Leaves(1), owned));
    }

    #[test]
    fn who_is_given_is_new_to_all() {
        let split = split(4);
        let mut route = Route::new(3, &split, &split);
        let all = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        let fate = route.tell_of_new(&Object { key: 1, now: all, before: all });
        assert_eq!(fate, Fate::Ghost(0));
        let counts: Vec<_> =
            route.batches.iter().map(|batch| (batch.owned.len(), batch.entered.len())).collect();
        assert_eq!(counts, [(1, 0), (0, 1), (0, 1), (0, 0)]);
    }

    #[test]
    fn where_planes_move_only_what_they_pass_travels() {
        let before = split(2);
        // The plane goes from 0 to 10.
        let mut points: Vec<_> = (-40..60).map(|i| [i as f32, 0.0, 0.0]).collect();
        let now = before.moved(&mut points);
        assert_ne!(now, before);
        // The second rank owned all from 0 on: it keeps what is from 10 on.
        let mut route = Route::new(1, &before, &now);
        for x in 0..50 {
            let aabb = cube(x as f32 + 0.5);
            let fate = route.tell(&Object { key: x, now: aabb, before: aabb });
            let expected = match x {
                0..9 => Fate::Leaves(0),
                9 => Fate::Ghost(0),
                _ => Fate::Stays,
            };
            assert_eq!(fate, expected, "{x}");
        }
        let owned: Vec<_> = route.batches[0].owned.iter().map(|newcomer| newcomer.key).collect();
        assert_eq!(owned, (0..10).collect::<Vec<_>>());
        assert_eq!(route.batches[0], Batch { owned: route.batches[0].owned.clone(), ..Batch::default() });
    }
}
