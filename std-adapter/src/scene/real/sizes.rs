//! Cubes whose sizes are log-normal.

use super::super::cube_root;
use super::body::{Body, point, room};
use super::{Random, Start};

/// The standard deviation of the decimal logarithm of an edge, and how far it is from 0 at most: three decades in all.
const DEVIATION: f32 = 0.5;
const MOST: f32 = 1.5;

/// The volume of the room, in cubic metres a box.
const SPACE: f64 = 60.0;

/// How far a cube moves in a frame at most.
const PACE: f32 = 0.1;

pub(super) fn start(count: u32, random: &mut Random) -> Start {
    let room = room(cube_root(SPACE * f64::from(count)) as f32);
    let bodies = (0..count).map(|_| {
        let edge = power_of_ten(f64::from(exponent(random))) as f32;
        Body::walking([edge; 3], point(room, random), random.in_ball(PACE), room)
    });
    Start::steady(bodies.collect())
}

/// Normally distributed as well as twelve random numbers can make it, and cut off.
fn exponent(random: &mut Random) -> f32 {
    loop {
        let normal: f32 = (0..12).map(|_| random.unit()).sum::<f32>() - 6.0;
        if (normal * DEVIATION).abs() <= MOST {
            return normal * DEVIATION;
        }
    }
}

/// By a power series: unlike the maths library, it gives the same bits on every platform.
fn power_of_ten(x: f64) -> f64 {
    const HALVINGS: u32 = 6;
    let y = x * std::f64::consts::LN_10 / f64::from(1 << HALVINGS);
    let mut sum = 1.0;
    for k in (1..12).rev() {
        sum = 1.0 + y / f64::from(k) * sum;
    }
    (0..HALVINGS).fold(sum, |power, _| power * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten() {
        for (x, power) in
            [(0.0, 1.0), (1.0, 10.0), (-1.5, 0.031_622_776_601_683_79), (1.25, 17.782_794_100_389_23)]
        {
            let share = power_of_ten(x) / power;
            assert!((share - 1.0).abs() < 1e-14, "10^{x} is {}", power_of_ten(x));
        }
    }

    #[test]
    fn exponents_are_normal() {
        let mut random = Random::new(1, 0);
        let all: Vec<f32> = (0..20_000).map(|_| exponent(&mut random)).collect();
        let mean = all.iter().sum::<f32>() / all.len() as f32;
        let within = all.iter().filter(|x| x.abs() <= DEVIATION).count() as f32 / all.len() as f32;
        assert!(
            mean.abs() < 0.02 && (0.66..0.71).contains(&within),
            "mean {mean}, {within} within one deviation"
        );
    }
}
