//! Splits bodies into 8 boxes each, so that a scene may have more boxes than an engine can simulate.
//!
//! Positions are doubled, and the 8 boxes keep the edges of the body and sit at plus or minus half an edge along its own
//! axes: together they are the body at twice its size, in a world of twice the side.

use anyhow::{Result, bail};
use trisap::Aabb;

/// The most bodies that `trisap record` simulates.
pub(crate) const MOST_BODIES: u32 = 32_000;

/// A box as an engine moves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub(crate) centre: [f32; 3],
    /// Half the edges.
    pub(crate) half: [f32; 3],
    /// The directions of the edges: unit vectors.
    pub(crate) axes: [[f32; 3]; 3],
}

/// How many bodies to simulate for `count` boxes, at most `most`, and how often to split them.
pub(crate) fn bodies(count: u32, most: u32) -> Result<(u32, u32)> {
    let (mut bodies, mut splits) = (count, 0);
    while bodies > most {
        if !bodies.is_multiple_of(8) {
            let unit = 8_u32.pow(splits + 1);
            bail!(
                "{count} boxes cannot come from splitting at most {most} bodies into 8 boxes each; \
                 take a multiple of {unit}, such as {}",
                count / unit * unit
            );
        }
        bodies /= 8;
        splits += 1;
    }
    Ok((bodies, splits))
}

/// How much larger the world is after so many splits.
pub(crate) fn scale(splits: u32) -> f32 {
    (1_u32 << splits) as f32
}

/// Appends the bounding boxes of the boxes that a body is split into.
pub(crate) fn boxes(body: Pose, splits: u32, boxes: &mut Vec<Aabb>) {
    let Some(left) = splits.checked_sub(1) else {
        boxes.push(aabb(&body));
        return;
    };
    for corner in 0..8 {
        let mut part = body;
        for k in 0..3 {
            part.centre[k] = 2.0 * body.centre[k];
            for (axis, bit) in body.axes.iter().zip(0..) {
                let side = if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                part.centre[k] += side * body.half[bit] * axis[k];
            }
        }
        self::boxes(part, left, boxes);
    }
}

fn aabb(body: &Pose) -> Aabb {
    let reach =
        [0, 1, 2].map(|k| (0..3).map(|edge| (body.axes[edge][k] * body.half[edge]).abs()).sum::<f32>());
    Aabb::new([0, 1, 2].map(|k| body.centre[k] - reach[k]), [0, 1, 2].map(|k| body.centre[k] + reach[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_few_splits_as_possible() {
        let good = |count| bodies(count, MOST_BODIES).expect("can be split");
        assert_eq!(
            [1, 32_000, 128_000, 256_000, 1_024_000].map(good),
            [(1, 0), (32_000, 0), (16_000, 1), (32_000, 1), (16_000, 2)]
        );
        for (count, advice) in
            [(32_001, "a multiple of 8, such as 32000"), (256_008, "a multiple of 64, such as 256000")]
        {
            let message = bodies(count, MOST_BODIES).expect_err("no multiple").to_string();
            assert!(message.contains(advice), "{message}");
        }
    }

    #[test]
    fn parts_make_up_the_body() {
        // A quarter turn about z and some.
        let body = Pose {
            centre: [1.0, -2.0, 0.5],
            half: [0.5, 1.0, 0.25],
            axes: [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
        };
        for splits in 0..3 {
            let mut parts = Vec::new();
            boxes(body, splits, &mut parts);
            assert_eq!(parts.len(), 8_usize.pow(splits));
            let mut whole = body;
            whole.centre = whole.centre.map(|x| x * scale(splits));
            whole.half = whole.half.map(|x| x * scale(splits));
            let whole = aabb(&whole);
            for k in 0..3 {
                let low = parts.iter().map(|part| part.min[k]).fold(f32::MAX, f32::min);
                let high = parts.iter().map(|part| part.max[k]).fold(f32::MIN, f32::max);
                assert!(
                    (low - whole.min[k]).abs() < 1e-5 && (high - whole.max[k]).abs() < 1e-5,
                    "{splits} {k}"
                );
                // Each part is as large as the body was.
                let extent = aabb(&body).max[k] - aabb(&body).min[k];
                assert!(parts.iter().all(|part| (part.max[k] - part.min[k] - extent).abs() < 1e-5));
            }
        }
    }
}
