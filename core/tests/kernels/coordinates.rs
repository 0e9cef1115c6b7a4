//! Every level on all coordinates, or on so many that gaps between them are short.

use crate::geometry::aabb::Aabb;
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, key};
use crate::geometry::record::Frame;
use crate::simd::Simd;
use crate::simd::kernels::{Kernels, run};
use std::vec::Vec;

/// All keys whose lower half is zero, the infinities included.
fn coarse_keys() -> impl Iterator<Item = i32> + Clone {
    (NEGATIVE_INFINITY..=POSITIVE_INFINITY).step_by(1 << 16)
}

/// Finite keys as ends of frames: zero, powers of two, far away on either side.
fn corners() -> Vec<i32> {
    let mut corners: Vec<i32> = (NEGATIVE_INFINITY + 1..POSITIVE_INFINITY).step_by(1 << 27).collect();
    corners.extend([-1, 0, 1, key(-1.0), key(1.0), POSITIVE_INFINITY - 1]);
    corners.sort_unstable();
    corners
}

/// The box of one point on the diagonal.
fn at(x: i32) -> KeyBox {
    KeyBox { min: [x; 3], max: [x; 3] }
}

/// Whether a frame keeps the order of coordinates. Then sweeps lose no pair, wherever its grid lies.
fn is_sound(frame: &Frame) -> bool {
    let whole = |numbers: &[f32; 8]| numbers[..3] == numbers[3..6] && numbers[6..] == [0.0; 2];
    let finite = |x: &f32| x.abs() <= f32::MAX;
    whole(&frame.origin)
        && whole(&frame.scale)
        && frame.origin.iter().all(finite)
        && frame.scale.iter().all(|x| *x >= 0.0 && finite(x))
}

/// In a frame, records of ascending coordinates ascend, and a minimum is never above the maximum at the same place.
/// So boxes that overlap have records that overlap.
#[inline(always)]
fn ascends<S: Simd>(simd: S, frame: Frame, keys: impl Iterator<Item = i32>) -> bool {
    let mut last = [0; 6];
    let mut holds = true;
    for x in keys {
        let lanes = simd.record(&frame, simd.keys(&at(x)), 0).lanes;
        for k in 0..3 {
            let (min, max) = (lanes[k], !lanes[3 + k]);
            holds &= last[k] <= min && last[3 + k] <= max && min <= max;
            (last[k], last[3 + k]) = (min, max);
        }
    }
    holds
}

#[test]
fn records_keep_the_order_of_all_coarse_coordinates() {
    let corners = corners();
    for (at, low) in corners.iter().enumerate() {
        for (to, high) in corners.iter().enumerate().skip(at) {
            // Another side on each axis.
            let between = corners[(at + to) / 2];
            let frame = Frame::over(&KeyBox { min: [*low, *low, between], max: [*high, between, *high] });
            assert!(is_sound(&frame), "from {low} to {high}");
            for kernels in Kernels::all() {
                let holds = run!(kernels, |simd| ascends(simd, frame, coarse_keys()));
                assert!(holds, "{}: from {low} to {high}", kernels.name());
            }
        }
    }
}

#[test]
fn records_keep_the_order_of_coordinates_in_frames_of_all_sizes() {
    for low in corners() {
        for size in (0..25).map(|bits| 1 << bits) {
            let high = low.saturating_add(size).min(POSITIVE_INFINITY - 1);
            let frame = Frame::over(&KeyBox { min: [low; 3], max: [high; 3] });
            let from = low.saturating_sub(size).max(NEGATIVE_INFINITY);
            let until = high.saturating_add(size).min(POSITIVE_INFINITY);
            let keys = (from..=until).step_by((size as usize / 1024).max(1));
            for kernels in Kernels::all() {
                let keys = keys.clone();
                let holds = run!(kernels, |simd| ascends(simd, frame, keys));
                assert!(holds, "{}: from {low}, of {size} keys", kernels.name());
            }
        }
    }
}

/// Boxes get the keys of the definition.
#[inline(always)]
fn encodes<S: Simd>(simd: S) -> Option<f32> {
    (0..=u16::MAX).flat_map(|top| [0, 1, 0x8000, 0xffff].map(|low| u32::from(top) << 16 | low)).find_map(
        |bits| {
            let x = f32::from_bits(bits);
            let expected = if x.is_nan() { None } else { Some(at(key(x))) };
            let mut new = [KeyBox::EMPTY; 4];
            let boxes = [Aabb::new([x; 3], [x; 3]); 4];
            let changed = simd.encode_four(Boxes::new(&boxes), None, &[at(1); 4], &mut new);
            let four_right = match expected {
                Some(keys) if S::ENCODES_FOUR => changed.is_some() && new == [keys; 4],
                _ => changed.is_none(),
            };
            (KeyBox::from_aabb(&boxes[0]) != expected || !four_right).then_some(x)
        },
    )
}

#[test]
fn boxes_of_all_coarse_floats_get_their_keys() {
    for kernels in Kernels::all() {
        assert_eq!(run!(kernels, |simd| encodes(simd)), None, "{}", kernels.name());
    }
}
