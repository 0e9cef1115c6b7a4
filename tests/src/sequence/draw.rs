//! Boxes, filters and numbers of an operation: only integers and single operations on floats, so that C++ draws the same.

use super::format::Header;
use crate::scenes::Rng;
use trisap_core::{Aabb, Cast, Filter, Region};

/// A quarter is a step of the lattice.
fn on_lattice(steps: usize) -> f32 {
    (steps as i32 - 8) as f32 * 0.25
}

/// A box on the lattice, so that boxes touch: now and then a point, large, or without end.
pub(super) fn aabb(header: &Header, rng: &mut Rng) -> Aabb {
    let (steps, flat) = header.lattice();
    let kind = rng.below(40);
    let mut aabb = Aabb::default();
    for axis in 0..3 {
        let low = if axis == flat { 0 } else { rng.below(steps) };
        let edge = match kind {
            0..3 => rng.below(steps),
            3 => 0,
            _ => rng.below(5),
        };
        aabb.min[axis] = on_lattice(low);
        aabb.max[axis] = on_lattice(low + edge);
    }
    match header.style() {
        // Between the steps of the lattice.
        2 => {
            let by = [(); 3].map(|()| rng.below(4096) as f32 * (0.25 / 4096.0));
            aabb = crate::scenes::shifted(&aabb, by);
        }
        // Of sizes that are far apart, the large ones far from each other.
        3 => {
            let scale = (1 << rng.below(12)) as f32 / 64.0;
            aabb = Aabb::new(aabb.min.map(|x| x * scale), aabb.max.map(|x| x * scale));
        }
        _ => {}
    }
    if kind == 4 {
        let axis = rng.below(3);
        let ends = [f32::NEG_INFINITY, f32::MIN, -0.0, 0.0, f32::from_bits(1), f32::MAX, f32::INFINITY];
        let low = rng.below(ends.len());
        aabb.min[axis] = ends[low];
        aabb.max[axis] = ends[low + rng.below(ends.len() - low)];
    }
    aabb
}

/// A box in `f64`, seen from an origin: its corners are rounded outward.
pub(super) fn from_f64(header: &Header, rng: &mut Rng) -> Aabb {
    let aabb = aabb(header, rng);
    let origin = [(); 3].map(|()| f64::from(rng.below(2001) as i32 - 1000) * 0.1);
    let corner = |corner: [f32; 3]| [0, 1, 2].map(|k| f64::from(corner[k]) + origin[k]);
    Aabb::from_f64(corner(aabb.min), corner(aabb.max), origin)
}

/// A box in fixed point: on the lattice, or with more bits than a float has.
pub(super) fn from_fixed(header: &Header, rng: &mut Rng) -> Aabb {
    let bits = [2, 10, 26][rng.below(3)];
    let unit = 1 << (bits - 2);
    let (mut min, mut max) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let low = (rng.below(header.lattice().0) as i32 - 8) * unit;
        min[axis] = low + rng.below(unit as usize) as i32;
        max[axis] = min[axis] + rng.below(5) as i32 * unit;
    }
    Aabb::from_fixed(min, max, bits)
}

/// Where a box goes: a little way, about its size, anywhere, or nowhere but to another size.
pub(super) fn moved(aabb: Aabb, header: &Header, argument: usize, rng: &mut Rng) -> Aabb {
    let (reach, step) = match argument / 8 % 4 {
        0 => (3, 0.015625),
        1 => (13, 0.25),
        2 => return self::aabb(header, rng),
        _ => {
            let max = aabb.max.map(|x| x + rng.below(3) as f32 * 0.25);
            return Aabb::new(aabb.min, max);
        }
    };
    let by = [(); 3].map(|()| (rng.below(reach) as i32 - reach as i32 / 2) as f32 * step);
    crate::scenes::shifted(&aabb, by)
}

/// A box that is none.
pub(super) fn bad_box(rng: &mut Rng) -> Aabb {
    let axis = rng.below(3);
    let mut bad = Aabb::new([0.0; 3], [1.0; 3]);
    if rng.once_in(2) {
        bad.min[axis] = 2.0;
    } else {
        bad.max[axis] = f32::NAN;
    }
    bad
}

/// Whom an object meets.
pub(super) fn filter(rng: &mut Rng) -> Filter {
    let group = if rng.once_in(2) { u32::MAX } else { 1 << rng.below(3) };
    let mask = if rng.once_in(2) { u32::MAX } else { 1 << rng.below(3) };
    // One in 32 is of a class that there is not.
    Filter { group, mask, class: if rng.once_in(32) { 32 } else { rng.below(3) as u32 } }
}

/// A point of the lattice.
pub(super) fn point(header: &Header, rng: &mut Rng) -> [f32; 3] {
    let (steps, _) = header.lattice();
    [(); 3].map(|()| on_lattice(rng.below(steps)))
}

/// A region; one in 32 is none.
pub(super) fn region(header: &Header, rng: &mut Rng) -> Region {
    match rng.below(4) {
        0 => Region::Point(point(header, rng)),
        1 => Region::Sphere { center: point(header, rng), radius: rng.below(9) as f32 * 0.25 },
        _ if rng.once_in(16) => Region::Aabb(bad_box(rng)),
        _ => Region::Aabb(aabb(header, rng)),
    }
}

/// A ray or a moving box; one in 32 is none.
pub(super) fn cast(header: &Header, rng: &mut Rng) -> Cast {
    let point = point(header, rng);
    let edge = if rng.once_in(2) { rng.below(5) as f32 * 0.25 } else { 0.0 };
    let direction = [(); 3].map(|()| (rng.below(7) as i32 - 3) as f32 * 0.5);
    let distance = match rng.below(32) {
        0 => -1.0,
        1..8 => f32::INFINITY,
        _ => rng.below(33) as f32 * 0.25,
    };
    Cast { start: Aabb::new(point, point.map(|x| x + edge)), direction, distance }
}
