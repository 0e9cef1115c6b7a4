//! A town on a map of terrain.

use super::body::Body;
use super::{Random, Start};

/// The edge of the map.
const MAP: f32 = 4000.0;

/// Quarters, in which most of what there is stands.
const QUARTERS: usize = 12;

/// The radius of a quarter in a town of this many boxes. It grows with the square root of their number, so that a quarter is as
/// dense in any town, up to the greatest radius.
const RADIUS: f32 = 120.0;
const RADIUS_COUNT: f32 = 28_450.0;
const MOST_RADIUS: f32 = 700.0;

/// Of a hundred boxes so many are tiles of terrain at most, triggers and houses; all others are actors.
const TILES: u32 = 2;
const TRIGGERS: u32 = 2;
const HOUSES: u32 = 26;

/// How many tiles there are along an edge of the map at most: smaller ones nobody makes.
const MOST_TILES: u32 = 64;

/// Where things stand.
struct Map {
    /// The centres of the quarters, on x and z.
    quarters: [[f32; 2]; QUARTERS],
    radius: f32,
    /// Tiles along an edge, and how high each one is.
    across: u32,
    heights: Vec<f32>,
}

impl Map {
    fn new(count: u32, random: &mut Random) -> Self {
        let radius = (RADIUS * (count as f32 / RADIUS_COUNT).sqrt()).min(MOST_RADIUS);
        let reach = MAP / 2.0 - radius;
        let quarters = [(); QUARTERS].map(|()| [(); 2].map(|()| random.between(-reach, reach)));
        let across = f64::from(count * TILES / 100).sqrt() as u32;
        let across = across.clamp(1, MOST_TILES);
        let heights = (0..across * across).map(|_| random.between(5.0, 40.0)).collect();
        Self { quarters, radius, across, heights }
    }

    /// A place on the map: in a quarter with this probability, otherwise anywhere.
    fn place(&self, share: f32, random: &mut Random) -> [f32; 2] {
        if random.unit() < share {
            let [x, z] = self.quarters[random.below(QUARTERS as u32) as usize];
            // More at the middle than at the rim.
            let [dx, _, dz] = random.in_ball(self.radius);
            [x + dx, z + dz]
        } else {
            [(); 2].map(|()| random.between(-MAP / 2.0, MAP / 2.0))
        }
    }

    fn tile(&self, at: u32) -> Body {
        let edge = MAP / self.across as f32;
        let middle = |step: u32| (step as f32 + 0.5) * edge - MAP / 2.0;
        let height = self.heights[at as usize];
        // From below, as a height field.
        Body::resting(
            [edge, height, edge],
            [middle(at % self.across), height / 2.0, middle(at / self.across)],
        )
    }

    /// The height of the ground at a place: somewhere in the box of the tile there.
    fn ground(&self, [x, z]: [f32; 2], random: &mut Random) -> f32 {
        let step = |at: f32| (((at / MAP + 0.5) * self.across as f32) as u32).min(self.across - 1);
        self.heights[(step(z) * self.across + step(x)) as usize] * random.unit()
    }
}

pub(super) fn start(count: u32, random: &mut Random) -> Start {
    let map = Map::new(count, random);
    let tiles = map.across * map.across;
    let part = |of: u32| (u64::from(count) * u64::from(of) / 100) as u32;
    let mut bodies: Vec<Body> = Vec::with_capacity(count as usize);
    bodies.extend((0..tiles).map(|at| map.tile(at)));
    bodies.extend((0..part(TRIGGERS)).map(|_| {
        let [x, z] = map.place(0.6, random);
        let edges = [random.between(10.0, 30.0), random.between(5.0, 20.0), random.between(10.0, 30.0)];
        Body::resting(edges, [x, map.ground([x, z], random), z])
    }));
    bodies.extend((0..part(HOUSES)).map(|_| {
        let [x, z] = map.place(0.7, random);
        let edges = [random.between(6.0, 20.0), random.between(4.0, 20.0), random.between(6.0, 20.0)];
        Body::resting(edges, [x, map.ground([x, z], random) + edges[1] / 2.0, z])
    }));
    while bodies.len() < count as usize {
        let [x, z] = map.place(0.9, random);
        let is_vehicle = random.below(5) == 0;
        let edges = if is_vehicle { [2.0, 1.6, 4.5] } else { [0.6, 1.8, 0.6] };
        let home = [x, map.ground([x, z], random) + edges[1] / 2.0, z];
        bodies.push(if bodies.len().is_multiple_of(2) {
            Body::resting(edges, home)
        } else {
            // A person walks, a vehicle drives: at 30 frames a second, up to 1.5 and 15 m/s.
            let [dx, _, dz] = random.in_ball(if is_vehicle { 0.5 } else { 0.05 });
            let reach = if is_vehicle { 100.0 } else { 10.0 };
            Body::near_home(edges, home, [dx, 0.0, dz], [reach, 0.0, reach])
        });
    }
    Start::steady(bodies)
}

#[cfg(test)]
mod tests {
    use super::super::{Aabb, BadCount, Kind, Scene, Setup};

    #[test]
    fn the_map_is_4_km_and_most_of_it_is_in_twelve_places() -> Result<(), BadCount> {
        let scene = Scene::new(Setup { kind: Kind::Town, count: 10_000, seed: 2 })?;
        let (actors, built): (Vec<&Aabb>, Vec<&Aabb>) =
            scene.boxes().iter().partition(|aabb| aabb.max[0] - aabb.min[0] <= 2.01);
        assert!((6500..7500).contains(&actors.len()), "{} actors", actors.len());
        let (low, high) = built
            .iter()
            .fold((0.0_f32, 0.0_f32), |(low, high), aabb| (low.min(aabb.min[0]), high.max(aabb.max[0])));
        assert!((-2020.0..=-2000.0).contains(&low) && (2000.0..=2020.0).contains(&high), "{low} to {high}");
        // Of cells of 100 m, those that hold most of the actors are few.
        let mut cells = std::collections::BTreeMap::<_, u32>::new();
        for aabb in &actors {
            *cells.entry([0, 2].map(|k| (aabb.min[k] / 100.0) as i32)).or_default() += 1;
        }
        let mut held: Vec<u32> = cells.into_values().collect();
        held.sort_unstable_by(|a, b| b.cmp(a));
        let most: u32 = held.iter().take(100).sum();
        assert!(f64::from(most) > 0.85 * actors.len() as f64, "{most} in the fullest cells");
        Ok(())
    }
}
