//! Random numbers that are the same on every platform.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// A generator of random numbers whose sequence depends on its seed alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Random(Pcg32);

impl Random {
    /// A generator; other streams of the same seed are independent of it.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(Pcg32::new(seed, stream))
    }

    /// At least 0 and below 1, in steps of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// At least `low` and at most `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        // Rounding may put the sum a step above.
        (low + (high - low) * self.unit()).min(high)
    }

    /// An integer below `limit`; 0 where that is 0.
    pub fn below(&mut self, limit: u32) -> u32 {
        ((u64::from(self.0.next_u32()) * u64::from(limit)) >> 32) as u32
    }

    /// A point in the ball of this radius about the origin.
    pub fn in_ball(&mut self, radius: f32) -> [f32; 3] {
        self.in_unit_ball().map(|x| x * radius)
    }

    /// A unit quaternion: a rotation, all being equally likely.
    pub fn rotation(&mut self) -> [f32; 4] {
        loop {
            let point: [f32; 4] = self.in_unit_ball();
            let length = point.iter().map(|x| x * x).sum::<f32>().sqrt();
            // Too short a vector has lost its direction to rounding.
            if length > 0.01 {
                return point.map(|x| x / length);
            }
        }
    }

    fn in_unit_ball<const N: usize>(&mut self) -> [f32; N] {
        loop {
            let point = [(); N].map(|()| 2.0 * self.unit() - 1.0);
            if point.iter().map(|x| x * x).sum::<f32>() <= 1.0 {
                return point;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_fixed() {
        // The first numbers of the reference implementation's demo (pcg32, seed 42, stream 54).
        let mut random = Pcg32::new(42, 54);
        let first = [(); 3].map(|()| random.next_u32());
        assert_eq!(first, [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330]);
    }

    #[test]
    fn ranges_hold() {
        let mut random = Random::new(7, 0);
        for _ in 0..10_000 {
            assert!((0.0..1.0).contains(&random.unit()));
            assert!(random.below(3) < 3);
            assert!((-0.3..=0.7).contains(&random.between(-0.3, 0.7)));
            assert!(random.in_ball(2.0).iter().map(|x| x * x).sum::<f32>() <= 4.0);
            assert!((random.rotation().iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        assert_eq!(random.below(0), 0);
    }
}
