//! The names of synthetic scenes on the command line.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use trisap::scene::{Kind, real};

/// A scene of Broadmark, from which a physics engine can start too.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum BroadmarkName {
    /// No gravity; one box in a hundred gets a new speed in each frame.
    Brownian,
    /// Boxes fall and come to rest.
    Freefall,
    /// Strong gravity whose direction turns.
    Gravity,
}

impl From<BroadmarkName> for Kind {
    fn from(name: BroadmarkName) -> Self {
        match name {
            BroadmarkName::Brownian => Self::Brownian,
            BroadmarkName::Freefall => Self::FreeFall,
            BroadmarkName::Gravity => Self::Gravity,
        }
    }
}

/// Any synthetic scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SceneName {
    Broadmark(BroadmarkName),
    /// One as games and simulations have them.
    Real(real::Kind),
}

/// How many scenes of Broadmark there are.
const BROADMARK: usize = 3;

const ALL: [SceneName; BROADMARK + real::Kind::ALL.len()] = {
    let mut all = [SceneName::Broadmark(BroadmarkName::Brownian); BROADMARK + real::Kind::ALL.len()];
    all[1] = SceneName::Broadmark(BroadmarkName::Freefall);
    all[2] = SceneName::Broadmark(BroadmarkName::Gravity);
    let mut at = 0;
    while at < real::Kind::ALL.len() {
        all[BROADMARK + at] = SceneName::Real(real::Kind::ALL[at]);
        at += 1;
    }
    all
};

impl ValueEnum for SceneName {
    fn value_variants<'a>() -> &'a [Self] {
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Broadmark(name) => name.to_possible_value(),
            Self::Real(kind) => {
                let value = PossibleValue::new(kind.name()).help(kind.text());
                let is_usual = real::Kind::by_name("ground") == Some(*kind);
                Some(if is_usual { value.alias("ground") } else { value })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_its_name() {
        for name in BroadmarkName::value_variants() {
            assert!(ALL.contains(&SceneName::Broadmark(*name)));
        }
        for kind in real::Kind::ALL {
            assert_eq!(SceneName::from_str(kind.name(), false), Ok(SceneName::Real(kind)));
        }
        let ground = SceneName::from_str("ground", false);
        assert_eq!(ground, Ok(SceneName::Real(real::Kind::Ground(real::Ground::Pile))));
    }
}
