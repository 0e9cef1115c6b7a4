//! How space is divided between ranks: a tree of planes, one cell of it for each rank.

use trisap::Aabb;

/// Planes are kept where they are while the counts beside them differ from the goal by less than this share.
const KEPT: f64 = 0.02;
/// An axis is good enough if it divides the counts this well.
const GOOD: f64 = 0.05;

/// A number as an integer in the same order; both zeros are one. Comparing integers is exact also where a host flushes
/// denormals to zero.
#[must_use]
#[inline(always)]
pub(crate) fn order(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    if bits == i32::MIN { 0 } else { bits ^ (((bits >> 31) as u32) >> 1) as i32 }
}

/// What divides the cells of some ranks from those of the ranks after them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plane {
    axis: usize,
    /// Points with a lower coordinate are on the low side, all others on the high side.
    at: f32,
}

/// The part of space that belongs to a rank. A point belongs to exactly one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cell {
    low: [i32; 3],
    /// Not in the cell.
    high: [i32; 3],
}

impl Cell {
    /// All of space.
    pub(crate) const ALL: Self = Self { low: [i32::MIN; 3], high: [i32::MAX; 3] };

    /// Whether a point is in the cell.
    #[inline(always)]
    pub(crate) fn holds(&self, point: [f32; 3]) -> bool {
        (0..3).all(|k| (self.low[k]..self.high[k]).contains(&order(point[k])))
    }

    /// Whether a valid box is in this cell and in no other.
    #[inline(always)]
    pub(crate) fn encloses(&self, aabb: &Aabb) -> bool {
        (0..3).all(|k| order(aabb.min[k]) >= self.low[k] && order(aabb.max[k]) < self.high[k])
    }

    /// Whether two cells have a point of their closures in common.
    fn touches(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// The corner of both maxima of minima: the lowest point that two overlapping boxes share. The cell that it is in decides
/// which rank reports the pair. Both boxes reach that cell, so that the rank knows both.
#[inline(always)]
pub(crate) fn corner(a: &Aabb, b: &Aabb) -> [f32; 3] {
    let higher = |k: usize| if order(a.min[k]) > order(b.min[k]) { a.min[k] } else { b.min[k] };
    [higher(0), higher(1), higher(2)]
}

/// Planes that divide space into one cell for each rank.
///
/// The plane with index `m - 1` divides the ranks below `m` of its part from those from `m` on; the first one is in the middle
/// of all ranks, and so on in the halves. So there are no links between planes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Split {
    planes: Vec<Plane>,
}

impl Split {
    /// The first rank has all of space, as before anything is known of the boxes.
    pub(crate) fn first_has_all(ranks: usize) -> Self {
        Self { planes: vec![Plane { axis: 0, at: f32::INFINITY }; ranks - 1] }
    }

    /// The number of cells.
    pub(crate) fn ranks(&self) -> usize {
        self.planes.len() + 1
    }

    /// The rank whose cell holds a point.
    pub(crate) fn rank_of(&self, point: [f32; 3]) -> usize {
        let (mut first, mut count) = (0, self.ranks());
        while count > 1 {
            let low = count / 2;
            let plane = &self.planes[first + low - 1];
            if order(point[plane.axis]) < order(plane.at) {
                count = low;
            } else {
                first += low;
                count -= low;
            }
        }
        first
    }

    /// Writes the ranks whose cells a box reaches to `out`, in ascending order. None for a box that is not valid.
    pub(crate) fn reach(&self, aabb: &Aabb, out: &mut Vec<usize>) {
        out.clear();
        if !aabb.is_valid() {
            return;
        }
        let mut parts = vec![(0, self.ranks())];
        while let Some((first, count)) = parts.pop() {
            if count == 1 {
                out.push(first);
                continue;
            }
            let low = count / 2;
            let plane = &self.planes[first + low - 1];
            if order(aabb.max[plane.axis]) >= order(plane.at) {
                parts.push((first + low, count - low));
            }
            if order(aabb.min[plane.axis]) < order(plane.at) {
                parts.push((first, low));
            }
        }
    }

    /// The cell of a rank.
    pub(crate) fn cell(&self, rank: usize) -> Cell {
        let mut cell = Cell::ALL;
        let (mut first, mut count) = (0, self.ranks());
        while count > 1 {
            let low = count / 2;
            let plane = &self.planes[first + low - 1];
            let at = order(plane.at);
            if rank < first + low {
                cell.high[plane.axis] = cell.high[plane.axis].min(at);
                count = low;
            } else {
                cell.low[plane.axis] = cell.low[plane.axis].max(at);
                first += low;
                count -= low;
            }
        }
        cell
    }

    /// The ranks whose cells touch that of a rank.
    pub(crate) fn neighbours(&self, rank: usize) -> impl Iterator<Item = usize> {
        let own = self.cell(rank);
        (0..self.ranks()).filter(move |&other| other != rank && self.cell(other).touches(&own))
    }

    /// How many of the points are in the fullest cell.
    pub(crate) fn fullest(&self, points: &[[f32; 3]]) -> usize {
        let mut counts = vec![0; self.ranks()];
        for point in points {
            counts[self.rank_of(*point)] += 1;
        }
        counts.into_iter().max().unwrap_or(0)
    }

    /// A split whose cells hold about the same number of points each. Planes that still divide well stay where they are, and
    /// of the others those move that keep their axis where that is good enough: less has to travel then.
    pub(crate) fn moved(&self, points: &mut [[f32; 3]]) -> Self {
        let mut split = self.clone();
        let mut parts = vec![(0, self.ranks(), 0, points.len())];
        while let Some((first, count, start, end)) = parts.pop() {
            if count < 2 {
                continue;
            }
            let low = count / 2;
            let part = &mut points[start..end];
            let plane = place(&self.planes[first + low - 1], part, low as f64 / count as f64);
            split.planes[first + low - 1] = plane;
            let middle = start + partition(part, &plane);
            parts.push((first, low, start, middle));
            parts.push((first + low, count - low, middle, end));
        }
        split
    }
}

/// Puts the points on the low side of a plane first, and returns how many they are.
fn partition(points: &mut [[f32; 3]], plane: &Plane) -> usize {
    let mut low = 0;
    for index in 0..points.len() {
        if order(points[index][plane.axis]) < order(plane.at) {
            points.swap(low, index);
            low += 1;
        }
    }
    low
}

/// A plane with about this share of the points on its low side.
fn place(old: &Plane, points: &mut [[f32; 3]], share: f64) -> Plane {
    if points.is_empty() {
        return *old;
    }
    let count = points.len() as f64;
    let error = |points: &[[f32; 3]], plane: &Plane| {
        let low = points.iter().filter(|point| order(point[plane.axis]) < order(plane.at)).count();
        (low as f64 / count - share).abs()
    };
    if error(points, old) <= KEPT {
        return *old;
    }
    let goal = ((count * share) as usize).min(points.len() - 1);
    let mut best = (f64::INFINITY, *old);
    let mut axes = [0, 1, 2];
    let extents = axes.map(|axis| extent(points, axis));
    axes.sort_by(|&a, &b| extents[b].total_cmp(&extents[a]));
    // The old axis has another chance where its extent is not much less than the largest.
    if extents[old.axis] >= 0.7 * extents[axes[0]] {
        axes.sort_by_key(|&axis| axis != old.axis);
    }
    for axis in axes {
        let (_, middle, high) = points.select_nth_unstable_by_key(goal, |point| order(point[axis]));
        let at = middle[axis];
        // Many points may have the coordinate of the middle one: all of them on one side, or all on the other.
        let next =
            high.iter().map(|point| point[axis]).filter(|&x| order(x) > order(at)).min_by_key(|&x| order(x));
        for at in [Some(at), next].into_iter().flatten() {
            let plane = Plane { axis, at };
            let error = error(points, &plane);
            if error < best.0 {
                best = (error, plane);
            }
        }
        if best.0 <= GOOD {
            break;
        }
    }
    best.1
}

/// How far most of the points are apart on an axis, the outermost left out.
fn extent(points: &mut [[f32; 3]], axis: usize) -> f64 {
    let mut at = |share: f64| {
        let index = (points.len() as f64 * share) as usize;
        let (_, point, _) = points.select_nth_unstable_by_key(index, |point| order(point[axis]));
        f64::from(point[axis]).clamp(-1e38, 1e38)
    };
    let low = at(0.02);
    at(0.98) - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap::scene::Random;

    fn points(count: usize) -> Vec<[f32; 3]> {
        let mut random = Random::new(3, 1);
        (0..count).map(|_| [0.0; 3].map(|_: f32| random.between(-9.0, 9.0))).collect()
    }

    #[test]
    fn integers_are_in_the_order_of_numbers() {
        let numbers = [f32::NEG_INFINITY, -1.0, -1e-40, 0.0, 1e-40, 1.0, f32::MAX, f32::INFINITY];
        assert!(numbers.is_sorted_by(|a, b| order(*a) < order(*b)));
        assert_eq!(order(-0.0), order(0.0));
    }

    #[test]
    fn cells_divide_space_and_counts() {
        for ranks in 1..=9 {
            let mut points = points(3000);
            let split = Split::first_has_all(ranks).moved(&mut points);
            for point in &points {
                let holders: Vec<_> = (0..ranks).filter(|&rank| split.cell(rank).holds(*point)).collect();
                assert_eq!(holders, [split.rank_of(*point)]);
            }
            assert!(split.fullest(&points) as f64 <= 1.12 * 3000.0 / ranks as f64, "{ranks} ranks");
            assert_eq!(split.moved(&mut points), split, "planes that divide well stay");
        }
    }

    #[test]
    fn a_box_reaches_the_cells_that_it_meets() {
        let mut random = Random::new(5, 1);
        let split = Split::first_has_all(7).moved(&mut points(1000));
        let mut reached = Vec::new();
        for point in points(1000) {
            let edge = random.unit() * 6.0;
            let aabb = Aabb::new(point, point.map(|x| x + edge));
            split.reach(&aabb, &mut reached);
            let meets = |rank: &usize| {
                let cell = split.cell(*rank);
                (0..3).all(|k| order(aabb.min[k]) < cell.high[k] && order(aabb.max[k]) >= cell.low[k])
            };
            assert_eq!(reached, (0..7).filter(meets).collect::<Vec<_>>());
            assert!(reached.contains(&split.rank_of(point)));
            let alone = reached.len() == 1;
            assert_eq!(split.cell(split.rank_of(point)).encloses(&aabb), alone);
        }
        split.reach(&Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]), &mut reached);
        assert_eq!(reached.len(), 7);
    }

    #[test]
    fn points_in_one_place_stay_together() {
        let mut same = vec![[1.0; 3]; 100];
        let split = Split::first_has_all(4).moved(&mut same);
        assert_eq!(split.fullest(&same), 100);
        // Two places are two ranks.
        let mut two: Vec<_> = (0..100).map(|i| [0.0, (i % 2) as f32, 0.0]).collect();
        assert_eq!(Split::first_has_all(2).moved(&mut two).fullest(&two), 50);
    }
}
