//! The inside of a building.

use super::body::Body;
use super::{Random, Start};

/// The edge of a room, as nearly as whole rooms allow, and the height of a storey.
const ROOM: f32 = 5.0;
const STOREY: f32 = 4.0;
const STOREYS: u32 = 2;

/// Boxes in a room of that size, on average.
const IN_A_ROOM: f32 = 8.5;

/// How thick walls and floors are.
const THICKNESS: f32 = 0.3;

/// How far a walker goes in a frame at most: 1.5 m/s.
const PACE: f32 = 0.05;

/// The rooms of the building.
#[derive(Clone, Copy)]
struct Rooms {
    /// Along each edge of a storey.
    across: u32,
    /// Of a room.
    edge: f32,
}

impl Rooms {
    fn new(count: u32) -> Self {
        let exact = (count as f32 / IN_A_ROOM / STOREYS as f32).sqrt();
        let across = (exact as u32).max(1);
        Self { across, edge: ROOM * exact / across as f32 }
    }

    /// Anywhere on a floor.
    fn place(self, random: &mut Random) -> [f32; 3] {
        let [x, z] = [(); 2].map(|()| random.between(0.0, self.across as f32 * self.edge));
        [x, storey(random), z]
    }

    /// Where some neighbouring rooms start on an axis, and how long they are: one room, or twice as many each time a coin says
    /// so, up to four.
    fn row(self, random: &mut Random) -> [f32; 2] {
        let mut rooms = 1;
        while rooms < self.across.min(4) && random.below(2) == 0 {
            rooms = (2 * rooms).min(self.across);
        }
        [random.below(self.across - rooms + 1), rooms].map(|x| x as f32 * self.edge)
    }

    /// Where a room starts on an axis.
    fn line(self, random: &mut Random) -> f32 {
        random.below(self.across + 1) as f32 * self.edge
    }
}

/// The height of a floor.
fn storey(random: &mut Random) -> f32 {
    random.below(STOREYS) as f32 * STOREY
}

/// A resting box from its lowest corner.
fn from_corner(corner: [f32; 3], edges: [f32; 3]) -> Body {
    Body::resting(edges, [0, 1, 2].map(|k| corner[k] + edges[k] / 2.0))
}

pub(super) fn start(count: u32, random: &mut Random) -> Start {
    let rooms = Rooms::new(count);
    let bodies = (0..count).map(|_| match random.below(100) {
        0..8 => floor(rooms, random),
        8..33 => wall(rooms, random),
        33..38 => beam(rooms, random),
        38..70 => furniture(rooms, random),
        _ => walker(rooms, random),
    });
    Start::steady(bodies.collect())
}

fn floor(rooms: Rooms, random: &mut Random) -> Body {
    let ([x, long], [z, wide]) = (rooms.row(random), rooms.row(random));
    from_corner([x, storey(random) - THICKNESS, z], [long, THICKNESS, wide])
}

/// From floor to ceiling, along x or z.
fn wall(rooms: Rooms, random: &mut Random) -> Body {
    let ([along, length], across) = (rooms.row(random), rooms.line(random) - THICKNESS / 2.0);
    let (floor, height) = (storey(random), STOREY - THICKNESS);
    if random.below(2) == 0 {
        from_corner([along, floor, across], [length, height, THICKNESS])
    } else {
        from_corner([across, floor, along], [THICKNESS, height, length])
    }
}

/// Thin and long, along any axis: a pipe, a rail, a shaft.
fn beam(rooms: Rooms, random: &mut Random) -> Body {
    let mut edges = [random.between(0.1, 0.4); 3];
    edges[random.below(3) as usize] = random.between(4.0, 24.0);
    from_corner(rooms.place(random), edges)
}

/// From a cup to a cupboard.
fn furniture(rooms: Rooms, random: &mut Random) -> Body {
    let edges = [(); 3].map(|()| {
        let share = random.unit();
        0.1 + 2.4 * share * share
    });
    from_corner(rooms.place(random), edges)
}

fn walker(rooms: Rooms, random: &mut Random) -> Body {
    const EDGES: [f32; 3] = [0.6, 1.8, 0.6];
    let [x, y, z] = rooms.place(random);
    let [dx, _, dz] = random.in_ball(PACE);
    Body::near_home(EDGES, [x, y + EDGES[1] / 2.0, z], [dx, 0.0, dz], [ROOM, 0.0, ROOM])
}

#[cfg(test)]
mod tests {
    use super::super::{Aabb, BadCount, Kind, Scene, Setup};

    #[test]
    fn shapes_differ() -> Result<(), BadCount> {
        let scene = Scene::new(Setup { kind: Kind::Level, count: 2000, seed: 2 })?;
        let ratio = |aabb: &Aabb| {
            let edges = [0, 1, 2].map(|k| aabb.max[k] - aabb.min[k]);
            edges.iter().fold(0.0_f32, |a, &b| a.max(b)) / edges.iter().fold(f32::MAX, |a, &b| a.min(b))
        };
        let ratios: Vec<f32> = scene.boxes().iter().map(ratio).collect();
        let share = |least: f32| ratios.iter().filter(|&&ratio| ratio > least).count() as f64 / 2000.0;
        assert!(
            share(10.0) > 0.3 && share(50.0) > 0.05 && share(2.9) < 0.95,
            "{} {}",
            share(10.0),
            share(50.0)
        );
        Ok(())
    }
}
