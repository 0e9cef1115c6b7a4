//! How much is measured.

use std::time::Duration;

/// The sizes of all experiments.
pub(super) struct Plan {
    pub(super) name: &'static str,
    /// Numbers of objects, and those of the assorted scenes, as far as the paper goes.
    pub(super) sizes: Vec<u32>,
    pub(super) assorted_sizes: Vec<u32>,
    /// The number of objects where it is not varied.
    pub(super) objects: u32,
    /// Numbers of objects for two threads.
    pub(super) shared_sizes: Vec<u32>,
    /// Margins in edges.
    pub(super) margins: Vec<f32>,
    /// Shares of movers.
    pub(super) movers: Vec<f64>,
    /// Edges that each cube goes in a step.
    pub(super) speeds: Vec<f32>,
    /// Distances from the origin, and how many boxes stand there.
    pub(super) distances: Vec<f64>,
    pub(super) distant_boxes: u32,
    /// Frames before the first one that is stepped, and those that are.
    pub(super) skip: u32,
    pub(super) frames: u32,
    /// Whether scenes are recorded simulations, in programs that have an engine.
    pub(super) recorded: bool,
    /// How long a contender is measured.
    pub(super) budget: Duration,
}

const DISTANCES: [f64; 8] = [0.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

impl Plan {
    pub(super) fn full() -> Self {
        Self {
            name: "full",
            sizes: (0..=10).map(|k| 1000 << k).collect(),
            assorted_sizes: (0..=8).map(|k| 1000 << k).collect(),
            objects: 32_000,
            shared_sizes: vec![8000, 32_000, 128_000, 1_024_000],
            margins: vec![0.0, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5],
            movers: vec![
                0.0, 0.001, 0.003, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0,
            ],
            speeds: vec![0.0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0],
            distances: DISTANCES.to_vec(),
            distant_boxes: 2000,
            // Nearly two seconds: the boxes have met the walls and each other.
            skip: 40,
            frames: 12,
            recorded: cfg!(feature = "record"),
            budget: Duration::from_millis(400),
        }
    }

    pub(super) fn quick() -> Self {
        Self {
            name: "quick",
            sizes: vec![1000, 4000, 16_000, 64_000],
            assorted_sizes: vec![1000, 4000, 16_000],
            objects: 8000,
            shared_sizes: vec![8000, 32_000],
            margins: vec![0.0, 0.02, 0.1, 0.2, 0.5],
            movers: vec![0.0, 0.01, 0.03, 0.06, 0.1, 0.3, 1.0],
            speeds: vec![0.0, 0.001, 0.01, 0.1, 1.0],
            distances: DISTANCES.to_vec(),
            distant_boxes: 1000,
            frames: 6,
            recorded: false,
            budget: Duration::from_millis(40),
            ..Self::full()
        }
    }

    /// All experiments at the least size, to see whether they work.
    pub(super) fn least() -> Self {
        Self {
            name: "least",
            sizes: vec![200, 1500],
            assorted_sizes: vec![200, 1500],
            objects: 1500,
            shared_sizes: vec![6000],
            margins: vec![0.0, 0.1, 0.5],
            movers: vec![0.0, 0.03, 1.0],
            speeds: vec![0.0, 0.01, 1.0],
            distant_boxes: 300,
            skip: 20,
            frames: 3,
            budget: Duration::ZERO,
            ..Self::quick()
        }
    }
}
