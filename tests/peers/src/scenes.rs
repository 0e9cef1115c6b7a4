//! The synthetic scenes of trisap's generator, and the scenes of the table.

use crate::recording::Padded;
use std::{fs, io, path::Path};
use trisap::{
    Aabb,
    scene::{Kind, Objects, Random, Setup, Synthetic, real},
};

/// Frames before the first one used.
const SETTLE: usize = 40;

/// Frames used: no more than fit into memory, and enough that few frames go backwards, where boxes come back into the margins
/// that some peers have.
fn frames_used(count: u32) -> usize {
    (2_000_000 / count as usize).clamp(12, 150)
}

/// The boxes of synthetic scenes in the table, where a scene can have any number.
const OBJECTS: u32 = 8000;

/// All that the table has, by name: the recordings of the repository, and a synthetic scene of each kind.
pub(crate) fn all() -> io::Result<Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut scenes = Vec::new();
    for folder in ["tests/peers/recordings", "tests/recordings", "std-adapter/program/recordings"] {
        for entry in fs::read_dir(root.join(folder))? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "aabbs") {
                scenes.push(path.display().to_string());
            }
        }
    }
    scenes.sort();
    scenes.extend(synthetic());
    Ok(scenes)
}

/// A scene of each kind that the generator has, by name.
fn synthetic() -> impl Iterator<Item = String> {
    let of_kind =
        |kind: Kind| Objects::ALL.map(|objects| format!("{}:{}:{OBJECTS}", kind.name(), objects.name()));
    let of_games = real::Kind::ALL.into_iter().map(|kind| {
        let counts = kind.counts();
        format!("{}:{}", kind.name(), OBJECTS.clamp(*counts.start(), *counts.end()))
    });
    Kind::ALL.into_iter().flat_map(of_kind).chain(of_games).map(|name| name.to_lowercase())
}

/// The frames of a synthetic scene named `kind:objects:count`, as in `brownian:cubes:32000`, or `kind:count` where it is one of
/// those of games, as in `ground:1e4:8000`, or `speed:edges:count`, as in `speed:0.01:8000`.
pub(crate) fn frames(scene: &str) -> Option<Vec<Vec<Padded>>> {
    let (scene, count) = scene.rsplit_once(':')?;
    let count = count.parse().ok().filter(|&count| count > 0)?;
    if let Some(speed) = scene.strip_prefix("speed:") {
        return Some(going(count, speed.parse().ok()?));
    }
    if let Some(kind) = real::Kind::by_name(scene) {
        let mut scene = real::Scene::new(real::Setup { kind, count, seed: 1 }).ok()?;
        return Some(settled(count, || {
            scene.advance();
            padded(scene.boxes())
        }));
    }
    let (kind, objects) = scene.split_once(':')?;
    let kind = Kind::ALL.into_iter().find(|k| k.name().eq_ignore_ascii_case(kind))?;
    let objects = Objects::ALL.into_iter().find(|o| o.name().eq_ignore_ascii_case(objects))?;
    let mut scene = Synthetic::new(Setup { kind, objects, count, seed: 1 });
    Some(settled(count, || {
        scene.advance();
        padded(scene.boxes())
    }))
}

/// Cubes, each of which goes on in a direction of its own by so many of its edges a frame.
fn going(count: u32, speed: f32) -> Vec<Vec<Padded>> {
    let mut scene = Synthetic::new(Setup { kind: Kind::Brownian, objects: Objects::Cubes, count, seed: 1 });
    scene.advance();
    let mut random = Random::new(11, 0);
    let ways: Vec<_> = (scene.boxes().iter())
        .map(|aabb| {
            let way = random.in_ball(1.0);
            let length = way.iter().map(|along| along * along).sum::<f32>().sqrt().max(1e-3);
            way.map(|along| speed * (aabb.max[0] - aabb.min[0]) * along / length)
        })
        .collect();
    let at = |frame: usize| {
        let moved = |(aabb, way): (&Aabb, &[f32; 3])| {
            let by = |side: [f32; 3]| std::array::from_fn(|k| side[k] + frame as f32 * way[k]);
            Aabb::new(by(aabb.min), by(aabb.max))
        };
        padded(&scene.boxes().iter().zip(&ways).map(moved).collect::<Vec<_>>())
    };
    (0..frames_used(count)).map(at).collect()
}

/// The frames that are used of a synthetic scene: falling boxes need some time to meet, and what is sudden in a scene of
/// games is over.
fn settled(count: u32, mut next: impl FnMut() -> Vec<Padded>) -> Vec<Vec<Padded>> {
    (0..SETTLE).for_each(|_| drop(next()));
    (0..frames_used(count)).map(|_| next()).collect()
}

/// What a synthetic scene is called in a table.
pub(crate) fn name(scene: &str) -> String {
    let kind = scene.rsplit_once(':').map_or(scene, |(kind, _)| kind);
    format!("synthetic {}", kind.replace(':', " ")).to_lowercase()
}

fn padded(boxes: &[Aabb]) -> Vec<Padded> {
    boxes.iter().map(|b| [b.min[0], b.min[1], b.min[2], 0.0, b.max[0], b.max[1], b.max[2], 0.0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;

    #[test]
    fn every_scene_of_the_table_can_be_opened() {
        let scenes = all().expect("the folders of the recordings");
        assert!(scenes.len() >= 7 + Kind::ALL.len() + real::Kind::ALL.len());
        for scene in scenes.into_iter().chain(["speed:0.01:800".into()]) {
            let recording = Recording::open(&scene).unwrap_or_else(|error| panic!("{scene}: {error}"));
            assert!(recording.objects > 0 && recording.len() > 1, "{scene}");
        }
    }
}
