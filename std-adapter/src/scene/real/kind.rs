//! The kinds of scenes, and their names.

use super::{from, sudden};
use std::fmt;
use std::ops::RangeInclusive;

/// What there is in a scene and what happens. The numbers of pairs are those of scenes with 700 boxes and more: smaller ones have
/// fewer, as more of their boxes are at the rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Cubes in a layer, about 2 m apart, that shiver on a ground: a level with a floor, before bodies fall asleep. Each cube
    /// touches the ground, which is the first object: about 1 pair a box; 0.05 to 0.2 without ground.
    Ground(Ground),
    /// A heap of cubes, each of which moves by 0.05 m in every frame: rubble that does not come to rest. 2 to 4 pairs a box.
    Pile,
    /// A map of 4 km by 4 km with tiles of terrain, houses, triggers and people and vehicles, of which 90 % are in twelve
    /// quarters and half do not move. 1.5 to 3 pairs a box.
    Town,
    /// A building of floors, walls, beams and furniture of very different shapes, and people that walk in it. 7 to 11 pairs
    /// a box.
    Level,
    /// Cubes with edges from 0.03 to 32 m whose logarithm is normally distributed: debris, or engines and their bolts. 1.5 to 4
    /// pairs a box.
    LogNormal,
    /// Packed balls of three radii that creep: a simulation of sand. 3 to 5 pairs a box.
    Grains,
    /// Cubes that move as in Broadmark's Brownian scene, and 5 % bullets, whose boxes are all that they pass in a frame: 3 to
    /// 10 m long. 0.4 to 0.7 pairs a box.
    Bullets,
    /// All cubes in one place in the first frame, as where a game spawns them, and spread by frame [`SPREAD_FRAMES`]; then
    /// they move as in Broadmark's Brownian scene, with 0.3 to 0.6 pairs a box. In the first frame every box of a place
    /// overlaps every other, so at most 8,192 share a place, and there are no more than eight places.
    ///
    /// [`SPREAD_FRAMES`]: super::SPREAD_FRAMES
    Spawn,
    /// Cubes that move as in Broadmark's Brownian scene, and one frame, [`HITCH_FRAME`], that takes as long as 24 and in which
    /// all boxes are as large as all that they pass, some 7 m, as where a game hangs for a moment. 0.3 to 0.6 pairs
    /// a box, and 60 to 150 in that frame.
    ///
    /// [`HITCH_FRAME`]: super::HITCH_FRAME
    Hitch,
    /// A flat world, whose boxes all have z from 0 to 0: platforms that rest and bodies that move among them. 0.5 to 1 pairs
    /// a box.
    Flat,
    /// A car park: rows of cars that rest, and one in two hundred that drives between the rows. 0.7 to 1.2 pairs a box.
    Parking,
}

/// The ground below a layer of cubes: one box of 1 m whose top all cubes touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ground {
    /// No ground; one cube more.
    None,
    /// As large as the layer.
    Pile,
    /// From -10,000 to 10,000 m on x and z.
    Wide,
    /// From minus to plus infinity on x and z.
    Infinite,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 14] = [
        Self::Ground(Ground::None),
        Self::Ground(Ground::Pile),
        Self::Ground(Ground::Wide),
        Self::Ground(Ground::Infinite),
        Self::Pile,
        Self::Town,
        Self::Level,
        Self::LogNormal,
        Self::Grains,
        Self::Bullets,
        Self::Spawn,
        Self::Hitch,
        Self::Flat,
        Self::Parking,
    ];

    /// The name on command lines.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ground(Ground::None) => "ground:none",
            Self::Ground(Ground::Pile) => "ground:pile",
            Self::Ground(Ground::Wide) => "ground:1e4",
            Self::Ground(Ground::Infinite) => "ground:inf",
            Self::Pile => "pile",
            Self::Town => "town",
            Self::Level => "level",
            Self::LogNormal => "lognormal",
            Self::Grains => "grains",
            Self::Bullets => "bullets",
            Self::Spawn => "spawn",
            Self::Hitch => "hitch",
            Self::Flat => "flat",
            Self::Parking => "parking",
        }
    }

    /// The kind of this name. `ground` alone is the ground that is as large as the layer.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        let name = if name == "ground" { "ground:pile" } else { name };
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// What it is, in a line.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Ground(Ground::None) => "Cubes in a layer that shiver, without a ground",
            Self::Ground(Ground::Pile) => "Cubes in a layer that shiver, on a ground as large as the layer",
            Self::Ground(Ground::Wide) => "Cubes in a layer that shiver, on a ground of 20 km",
            Self::Ground(Ground::Infinite) => "Cubes in a layer that shiver, on a ground without end",
            Self::Pile => "A heap of cubes in slow motion",
            Self::Town => {
                "4 km of terrain, houses and triggers; people crowd in twelve quarters, half of them rest"
            }
            Self::Level => "Floors and walls of very different shapes, and people that walk",
            Self::LogNormal => "Cubes with log-normal sizes over three decades",
            Self::Grains => "Packed balls of three radii",
            Self::Bullets => "Cubes, and 5 % long boxes that bullets sweep",
            Self::Spawn => "All cubes in one place in the first frame, then spread",
            Self::Hitch => "Cubes, all of which are swept over 24 frames in frame 10",
            Self::Flat => "A flat world of platforms and bodies",
            Self::Parking => "Cars that rest but for a few",
        }
    }

    /// How many boxes there can be.
    #[must_use]
    pub const fn counts(self) -> RangeInclusive<u32> {
        match self {
            // The ground, and what stands on it.
            Self::Ground(Ground::Pile | Ground::Wide | Ground::Infinite) => from(2),
            // Some of everything.
            Self::Town | Self::Level => from(100),
            Self::Bullets | Self::Flat => from(20),
            Self::Spawn => 1..=sudden::MOST_SPAWNED,
            _ => from(1),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
