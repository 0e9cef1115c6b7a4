//! The line of a cast, and where it meets boxes: exactly in `f64`, and sooner or equal in `f32` for nodes and
//! records.

use super::aabb::{Aabb, widened};
use super::key::{KeyBox, value};
use super::record::{Frame, Record};

/// A prepared cast. It meets a box where the point `t * direction` is inside the box's difference from the
/// start. A fourth axis of NaN fills the vectors and excludes nothing.
pub(crate) struct Line {
    direction: [f64; 4],
    pub(crate) distance: f64,
    /// All ones on an axis where the line runs backwards: it meets the high side first.
    back: [i32; 4],
    /// What is subtracted from the side that is met first, and from the side that is met last.
    first: [f64; 4],
    last: [f64; 4],
    /// One over the direction; infinite where it is zero.
    inverse: [f64; 4],
}

/// The bit of a float that holds its sign.
const SIGN: u32 = 1 << 31;
/// The steps of the grid. The highest one ends here.
const GRID_END: f32 = 65_536.0;
/// Sides are moved outwards by this many steps of the grid: more than all roundings that do not grow with the
/// distance.
const OUTWARDS: f32 = 8.0;
/// The longest time that a cast takes for a step of the grid, on an axis where it hardly moves: `f32` must
/// hold this times the number of steps.
const SLOWEST: f32 = (1u128 << 102) as f32;

/// The numbers that tell which records of a leaf a cast may touch. When the cast passes the sides of their
/// boxes, in the time of [`Walk`], is a linear function of their lanes.
///
/// It excludes nothing that [`Line::span`] meets. Sides are moved outwards by more than all roundings
/// together. A lane of zero excludes nothing, since its side may be anywhere outside the grid.
pub(crate) struct Crossing {
    /// The bytes of a record's lanes in this order: sides that are met first, then sides that are met last.
    pub(crate) order: [u8; 16],
    /// For each lane in that order, when the cast passes its side: `scale * (BASE + lane) + offset`.
    pub(crate) scale: [f32; 8],
    pub(crate) offset: [f32; 8],
    /// How far to look.
    pub(crate) until: f32,
}

impl Crossing {
    /// Added to each lane. Floats are whole numbers from here on, so a lane becomes the low bits of a float.
    pub(crate) const BASE: f32 = (1u32 << 23) as f32;
    /// A later time counts as this one. It is less than `OUTWARDS * SLOWEST`, the least time at which that
    /// bound could make a cast leave a box too early.
    pub(crate) const LATEST: f32 = (1u128 << 100) as f32;

    /// As [`Simd::met`](crate::simd::Simd::met), for one record.
    #[inline(always)]
    pub(crate) fn met(&self, record: &Record) -> f32 {
        let (mut from, mut to) = (0.0, self.until);
        for k in 0..3 {
            // The first byte in the order tells whether the minimum or the maximum comes first. Looking up
            // both lanes by the order would take twice the instructions of a cast.
            let (low, high) = (record.lanes[k], record.lanes[3 + k]);
            let (first, last) = if self.order[2 * k] < 6 { (low, high) } else { (high, low) };
            let time = |k: usize, lane: u16| self.scale[k] * (Self::BASE + f32::from(lane)) + self.offset[k];
            let (come, leave) = (time(k, first), time(3 + k, last));
            // A side that may be anywhere, and NaN, exclude nothing.
            from = if first != 0 && come > from { come } else { from };
            to = if last != 0 && leave < to { leave } else { to };
        }
        let from = from.min(Self::LATEST);
        if from <= to { from } else { f32::NAN }
    }
}

/// A cast on its way through the tree, in `f32`. Its time is its distance on the axis where it moves most.
///
/// It enters nodes no later, and leaves them no earlier, than [`Line::span`] says: the factors include more
/// than all roundings.
pub(crate) struct Walk {
    /// As in [`Line`].
    pub(crate) back: [i32; 4],
    pub(crate) first: [f32; 4],
    pub(crate) last: [f32; 4],
    /// What distances are multiplied with, to enter and to leave.
    pub(crate) come: [f32; 4],
    pub(crate) leave: [f32; 4],
    /// Time in one unit of distance, and a little more than all roundings.
    speed: f64,
    /// As in [`Crossing`]. What follows is of the sides in this order, the same for all leaves.
    order: [u8; 16],
    /// What is subtracted from them.
    start: [f32; 8],
    /// What distances are multiplied with; below zero for sides that are met last: the higher the lane, the
    /// earlier the time.
    factors: [f32; 8],
    /// The sign bit for a maximum, as its lane is the complement of its place.
    complement: [u32; 8],
    /// What is subtracted from a place, in steps, so that its lane can be added to [`Crossing::BASE`].
    shift: [f32; 8],
}

impl Walk {
    /// More than a few roundings in `f32` together.
    const SLACK: f64 = 1.0 / (1u32 << 20) as f64;
    /// Added to the time of leaving, for numbers so small that the factors do not change them.
    pub(crate) const LEAST: f32 = f32::from_bits(27 << 23);

    #[inline(always)]
    pub(crate) fn new(line: &Line) -> Self {
        let Line { direction, back, first, last, inverse, .. } = *line;
        let most = direction.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        let speed = if most > 0.0 { most } else { 1.0 };
        let factor = inverse.map(|inverse| inverse * speed);
        let greatest = f64::from(f32::MAX);
        let [first, last] = [first, last].map(|sides| sides.map(|side| side as f32));
        let come = factor.map(|factor| (factor * (1.0 - Self::SLACK)).clamp(-greatest, greatest) as f32);
        // Infinite if it is too large: the node is never left.
        let leave = factor.map(|factor| (factor * (1.0 + Self::SLACK)) as f32);
        let six = |[a, b, c, _]: [f32; 4], [d, e, f, _]: [f32; 4]| [a, b, c, d, e, f, 0.0, 0.0];
        let [x, y, z, _] = back;
        // All ones for a maximum.
        let maximum = [x, y, z, !x, !y, !z, 0, 0].map(|side| side as u32);
        let mut order = [0; 8];
        for (k, lane) in [0, 1, 2, 0, 1, 2].into_iter().enumerate() {
            order[k] = 0x0100 + 0x0202 * (lane + (3 & maximum[k] as u16));
        }
        Self {
            back,
            first,
            last,
            come,
            leave,
            speed: speed * (1.0 + Self::SLACK),
            order: bytemuck::cast(order.map(u16::to_le_bytes)),
            start: six(first, last),
            factors: six(come.map(f32::abs), leave.map(|factor| -factor.abs())),
            complement: maximum.map(|side| side & SIGN),
            shift: maximum.map(|side| Crossing::BASE + OUTWARDS + f32::from_bits(side & GRID_END.to_bits())),
        }
    }

    /// The [`Crossing`] of a leaf, up to a time.
    #[inline(always)]
    pub(crate) fn crossing(&self, frame: &Frame, until: f32) -> Crossing {
        let mut crossing = Crossing { order: self.order, scale: [0.0; 8], offset: [0.0; 8], until };
        for k in 0..8 {
            // How far ahead the low end of the grid is, in steps.
            let ahead = (frame.origin[k] - self.start[k]) * frame.scale[k];
            let signed = f32::from_bits(ahead.to_bits() ^ self.complement[k]);
            // Outwards also by more than the roundings that grow with the distance.
            let place = signed - ahead.abs() * Self::SLACK as f32 - self.shift[k];
            // The time for a step.
            crossing.scale[k] = (self.factors[k] / frame.scale[k]).clamp(-SLOWEST, SLOWEST);
            crossing.offset[k] = place * crossing.scale[k];
        }
        crossing
    }

    /// A time that is not before a distance.
    pub(crate) fn time(&self, distance: f64) -> f32 {
        (distance * self.speed) as f32 + Self::LEAST
    }

    /// As [`Simd::enter`](crate::simd::Simd::enter).
    #[inline(always)]
    pub(crate) fn enter(&self, nodes: [&KeyBox; 2], until: f32) -> [f32; 2] {
        nodes.map(|node| {
            let (mut from, mut to) = (0.0, until);
            for k in 0..3 {
                let (low, high) = (value(node.min[k]), value(node.max[k]));
                let (entry, exit) = if self.back[k] != 0 { (high, low) } else { (low, high) };
                let come = (entry - self.first[k]) * self.come[k];
                let leave = (exit - self.last[k]) * self.leave[k];
                from = if come > from { come } else { from };
                to = if leave < to { leave } else { to };
            }
            if from <= to + Self::LEAST { from } else { f32::NAN }
        })
    }
}

impl Line {
    #[inline(always)]
    pub(crate) fn new(start: &Aabb, direction: [f32; 3], distance: f32) -> Self {
        let four = |[x, y, z]: [f32; 3]| [x, y, z, f32::NAN].map(widened);
        let (low, high, direction) = (four(start.min), four(start.max), four(direction));
        let inverse = direction.map(|d| if d == 0.0 { f64::INFINITY } else { 1.0 / d });
        let (mut first, mut last) = (high, low);
        for k in 0..4 {
            if direction[k] < 0.0 {
                (first[k], last[k]) = (low[k], high[k]);
            }
        }
        let back = direction.map(|d| -i32::from(d < 0.0));
        // Finite: at infinity a line without movement on an axis would meet the boxes beside it.
        let distance = widened(distance).min(f64::MAX);
        Self { direction, distance, back, first, last, inverse }
    }

    /// From where to where the line is inside a box, between zero and `far`. It is outside if the first number
    /// is above the second. A larger box is met no later and left no earlier.
    #[inline(always)]
    pub(crate) fn span(&self, bounds: &KeyBox, far: f64) -> (f64, f64) {
        // Its sides, and any number for the fourth axis.
        let four = |[x, y, z]: [i32; 3]| [x, y, z, 0].map(|side| widened(value(side)));
        let (low, high) = (four(bounds.min), four(bounds.max));
        let (mut come, mut leave) = ([0.0; 4], [far; 4]);
        // All axes at once.
        for k in 0..4 {
            let (entry, exit) = if self.back[k] != 0 { (high[k], low[k]) } else { (low[k], high[k]) };
            let first = (entry - self.first[k]) * self.inverse[k];
            let last = (exit - self.last[k]) * self.inverse[k];
            // A side that the line runs along gives NaN, which these ignore.
            come[k] = if first > 0.0 { first } else { 0.0 };
            leave[k] = if last < far { last } else { far };
        }
        let later = |a: f64, b: f64| if a > b { a } else { b };
        let sooner = |a: f64, b: f64| if a < b { a } else { b };
        let of = |x: [f64; 4], two: fn(f64, f64) -> f64| two(two(x[0], x[2]), two(x[1], x[3]));
        (of(come, later), of(leave, sooner))
    }
}
