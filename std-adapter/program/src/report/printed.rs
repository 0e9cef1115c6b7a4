//! The times that the paper prints for its own method, in milliseconds a frame.

use trisap::scene::{Kind, Objects};

/// By the number of objects: 1,000, 2,000, 4,000 and so on.
pub(super) const fn times(kind: Kind, objects: Objects) -> &'static [f64] {
    match (objects, kind) {
        // Table 1.
        (Objects::Cubes, Kind::Brownian) => {
            &[0.13, 0.21, 0.46, 1.01, 2.14, 4.34, 9.01, 19.06, 39.97, 84.18, 190.24]
        }
        (Objects::Cubes, Kind::FreeFall) => {
            &[0.09, 0.18, 0.37, 0.75, 1.41, 2.76, 5.73, 11.78, 23.19, 50.01, 119.45]
        }
        (Objects::Cubes, Kind::Gravity) => {
            &[0.14, 0.29, 0.59, 1.24, 2.56, 5.39, 8.31, 17.11, 39.97, 107.14, 371.59]
        }
        // Table 2.
        (Objects::Assorted, Kind::Brownian) => &[0.15, 0.32, 0.73, 1.57, 3.74, 11.10, 29.67, 68.38, 156.67],
        (Objects::Assorted, Kind::FreeFall) => &[0.14, 0.31, 0.76, 1.91, 4.87, 14.61, 39.29, 95.64, 220.73],
        (Objects::Assorted, Kind::Gravity) => &[0.51, 1.11, 2.37, 5.84, 13.85, 37.81, 107.67, 296.81, 756.28],
    }
}

/// The time for a number of objects, where the paper prints one.
pub(super) fn time(kind: Kind, objects: Objects, count: u32) -> Option<f64> {
    let place = times(kind, objects).iter().enumerate().find(|(place, _)| count == 1000 << place);
    place.map(|(_, time)| *time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_stand_at_the_sizes_that_are_printed() {
        assert_eq!(time(Kind::Gravity, Objects::Cubes, 1_024_000), Some(371.59));
        assert_eq!(time(Kind::FreeFall, Objects::Assorted, 4000), Some(0.76));
        assert_eq!(time(Kind::FreeFall, Objects::Assorted, 512_000), None);
        assert_eq!(time(Kind::Brownian, Objects::Cubes, 1500), None);
    }
}
