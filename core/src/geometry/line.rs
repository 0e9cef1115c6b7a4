//! The line that a box moves along, and where it meets a box.

use super::aabb::{Aabb, widened};
use super::key::{KeyBox, value};
use super::record::{Frame, Record};

/// A cast, prepared: a box is met where the point `t * direction` is inside the box's difference from the start. A fourth
/// axis, which nothing moves along, fills the vectors.
pub(crate) struct Line {
    direction: [f64; 4],
    pub(crate) distance: f64,
    pub(crate) slabs: Slabs,
}

/// What it takes to find where a line passes the sides of a box.
pub(crate) struct Slabs {
    /// All ones where the line runs backwards, so that the high side of a box comes first.
    pub(crate) back: [i32; 4],
    /// What is taken from the side that is met first, and from the one that is met last.
    pub(crate) first: [f64; 4],
    pub(crate) last: [f64; 4],
    /// One over the direction; infinite where it is zero.
    pub(crate) inverse: [f64; 4],
}

/// The bit of a float that holds its sign.
const SIGN: u32 = 1 << 31;
/// The grid's steps, in one more than which the highest ends.
const GRID_END: f32 = 65_536.0;
/// By how many steps of the grid sides are moved outwards: more than all roundings come to that do not grow with the distance.
const OUTWARDS: f32 = 8.0;
/// Bounds the time that a cast takes for a step of the grid on an axis that it hardly moves along, as `f32` must hold the product
/// with a number of steps.
const SLOWEST: f32 = (1u128 << 102) as f32;

/// What it takes to find which records of a leaf a cast may touch: when it passes the sides of their boxes, in the time of
/// [`Walk`], is a linear function of their lanes.
///
/// It lets through whatever [`Line::span`] does: sides are moved outwards by more than all roundings together, and a lane of
/// zero, where a side may be anywhere outside the grid, excludes nothing.
pub(crate) struct Crossing {
    /// The bytes of a record's lanes in the order: sides that are met first, sides that are met last.
    pub(crate) order: [u8; 16],
    /// For each lane in that order, when the cast is there: `scale * (BASE + lane) + offset`.
    pub(crate) scale: [f32; 8],
    pub(crate) offset: [f32; 8],
    /// How far to look.
    pub(crate) until: f32,
}

impl Crossing {
    /// Added to each lane: the least number whose floats are whole numbers, which so have the lane as their low bits.
    pub(crate) const BASE: f32 = (1u32 << 23) as f32;
    /// What is met later counts as met then: less than `OUTWARDS` times `SLOWEST`, the least time at which a cast leaves a box on an
    /// axis where that bound makes it leave too early.
    pub(crate) const LATEST: f32 = (1u128 << 100) as f32;

    /// As [`Simd::met`](crate::simd::Simd::met), for one record.
    #[inline(always)]
    pub(crate) fn met(&self, record: &Record) -> f32 {
        let (mut from, mut to) = (0.0, self.until);
        for k in 0..3 {
            // By the first byte in the order, which has the lane of the minimum or that of the maximum: a look-up of both lanes
            // takes twice the instructions of a cast.
            let (low, high) = (record.lanes[k], record.lanes[3 + k]);
            let (first, last) = if self.order[2 * k] < 6 { (low, high) } else { (high, low) };
            let time = |k: usize, lane: u16| self.scale[k] * (Self::BASE + f32::from(lane)) + self.offset[k];
            let (come, leave) = (time(k, first), time(3 + k, last));
            // A side that is anywhere, and NaN, exclude nothing.
            from = if first != 0 && come > from { come } else { from };
            to = if last != 0 && leave < to { leave } else { to };
        }
        let from = from.min(Self::LATEST);
        if from <= to { from } else { f32::NAN }
    }
}

/// The sides of the boxes of a leaf, those that are met first and then those that are met last, three each.
struct SidesMet {
    /// The bytes of their lanes.
    order: [u8; 16],
    /// What is taken from them.
    start: [f32; 8],
    /// What distances are multiplied with, without a sign.
    factor: [f32; 8],
    /// The bit of the sign for a maximum, which has the complement of its place as its lane.
    complement: [u32; 8],
    /// What is taken from a place, in steps, for its lane to be added to [`Crossing::BASE`].
    shift: [f32; 8],
    /// The bit of the sign for those that are met last: the higher their lanes, the earlier.
    falling: [u32; 8],
}

/// A cast on its way through the tree, in `f32`: its time is its distance on the axis where it moves most.
///
/// It comes to nodes no later, and leaves them no earlier, than [`Line::span`] says, as the factors take in more than all
/// roundings.
pub(crate) struct Walk {
    /// As in [`Slabs`].
    pub(crate) back: [i32; 4],
    pub(crate) first: [f32; 4],
    pub(crate) last: [f32; 4],
    /// What distances from the sides are multiplied with.
    pub(crate) come: [f32; 4],
    pub(crate) leave: [f32; 4],
    /// Time in one unit of distance, and a little more than all roundings.
    speed: f64,
    sides: SidesMet,
}

impl Walk {
    /// More than what a few roundings in `f32` can come to.
    const SLACK: f64 = 1.0 / (1u32 << 20) as f64;
    /// Added to the time of leaving, for numbers so small that their factors do nothing.
    pub(crate) const LEAST: f32 = f32::from_bits(27 << 23);

    #[inline(always)]
    pub(crate) fn new(line: &Line) -> Self {
        let Slabs { back, first, last, inverse } = line.slabs;
        let most = line.direction.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        let speed = if most > 0.0 { most } else { 1.0 };
        let factor = inverse.map(|inverse| inverse * speed);
        let greatest = f64::from(f32::MAX);
        let [first, last] = [first, last].map(|sides| sides.map(|side| side as f32));
        let come = factor.map(|factor| (factor * (1.0 - Self::SLACK)).clamp(-greatest, greatest) as f32);
        // Infinite where it is too large: what is not left yet is never left.
        let leave = factor.map(|factor| (factor * (1.0 + Self::SLACK)) as f32);
        let sides = SidesMet::new(&back, [&first, &last], [&come, &leave]);
        Self { back, first, last, come, leave, speed: speed * (1.0 + Self::SLACK), sides }
    }

    /// What it takes to find the members of a leaf that the cast may touch until a time.
    #[inline(always)]
    pub(crate) fn crossing(&self, frame: &Frame, until: f32) -> Crossing {
        let SidesMet { order, start, factor, complement, shift, falling } = &self.sides;
        let mut crossing = Crossing { order: *order, scale: [0.0; 8], offset: [0.0; 8], until };
        for k in 0..8 {
            // How far the low end of the grid is ahead, in its steps.
            let ahead = (frame.origin[k] - start[k]) * frame.scale[k];
            let signed = f32::from_bits(ahead.to_bits() ^ complement[k]);
            // Outwards by more than the roundings that grow with the distance, too.
            let place = signed - ahead.abs() * Self::SLACK as f32 - shift[k];
            // The time for a step; not a number is slow, too.
            let step = factor[k] / frame.scale[k];
            let step = if step < SLOWEST { step } else { SLOWEST };
            let step = f32::from_bits(step.to_bits() | falling[k]);
            crossing.scale[k] = step;
            crossing.offset[k] = place * step;
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

impl SidesMet {
    #[inline(always)]
    fn new(back: &[i32; 4], [first, last]: [&[f32; 4]; 2], [come, leave]: [&[f32; 4]; 2]) -> Self {
        let six = |[a, b, c, _]: &[f32; 4], [d, e, f, _]: &[f32; 4]| [*a, *b, *c, *d, *e, *f, 0.0, 0.0];
        let [x, y, z, _] = *back;
        // All ones for a maximum.
        let maximum = [x, y, z, !x, !y, !z, 0, 0].map(|side| side as u32);
        let mut order = [0; 8];
        for (k, lane) in [0, 1, 2, 0, 1, 2].into_iter().enumerate() {
            order[k] = 0x0100 + 0x0202 * (lane + (3 & maximum[k] as u16));
        }
        Self {
            order: bytemuck::cast(order.map(u16::to_le_bytes)),
            start: six(first, last),
            factor: six(come, leave).map(f32::abs),
            complement: maximum.map(|side| side & SIGN),
            shift: maximum.map(|side| Crossing::BASE + OUTWARDS + f32::from_bits(side & GRID_END.to_bits())),
            falling: [0, 0, 0, SIGN, SIGN, SIGN, 0, 0],
        }
    }
}

impl Slabs {
    /// As [`Simd::span`](crate::simd::Simd::span).
    #[inline(always)]
    pub(crate) fn span(&self, min: [i32; 4], max: [i32; 4], far: f64) -> (f64, f64) {
        let (mut from, mut to) = (0.0, far);
        for k in 0..3 {
            let (low, high) = (widened(value(min[k])), widened(value(max[k])));
            let (low, high) = if self.back[k] != 0 { (high, low) } else { (low, high) };
            let (first, last) =
                ((low - self.first[k]) * self.inverse[k], (high - self.last[k]) * self.inverse[k]);
            // A side that the line runs along gives NaN, which these pass over.
            from = if first > from { first } else { from };
            to = if last < to { last } else { to };
        }
        (from, to)
    }
}

impl Line {
    #[inline(always)]
    pub(crate) fn new(start: &Aabb, direction: [f32; 3], distance: f32) -> Self {
        let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0].map(widened);
        let (low, high, direction) = (four(start.min), four(start.max), four(direction));
        let inverse = direction.map(|d| if d == 0.0 { f64::INFINITY } else { 1.0 / d });
        let (mut first, mut last) = (high, low);
        for k in 0..4 {
            let back = direction[k] < 0.0;
            first[k] = if back { low[k] } else { high[k] };
            last[k] = if back { high[k] } else { low[k] };
        }
        let back = direction.map(|d| -i32::from(d < 0.0));
        let slabs = Slabs { back, first, last, inverse };
        // Finite: beyond it is where a line along which nothing moves would meet the boxes beside it.
        let distance = widened(distance).min(f64::MAX);
        Self { direction, distance, slabs }
    }
}
