//! Continuous collision detection of cloth, its broad phase: vertices, edges and faces of a mesh that moves from one position to
//! another. Each has a box around both positions, rounded outward from `f64`. Whatever meets on the way is among the pairs: a vertex
//! with a face, or two edges, that share no vertex. One world finds both kinds: classes say who meets whom, and owners drop neighbours.

use trisap::{Aabb, Boxes, Capacity, Config, Error, Filter, Id, OwnedWorld, Owners, Serial};

type Point = [f64; 3];

const VERTEX: u32 = 0;
const EDGE: u32 = 1;
const FACE: u32 = 2;

/// Vertices, edges and faces, in this order, each by the vertices that it has: a sheet of `side` by `side` vertices.
fn sheet(side: u32) -> Vec<Vec<u32>> {
    let of = |x: u32, y: u32| if x < side && y < side { Some(y * side + x) } else { None };
    let places = || (0..side * side).map(|k| (k % side, k / side));
    let all = |shapes: &[&[(u32, u32)]]| {
        let mut found = Vec::new();
        for (x, y) in places() {
            let corners = |shape: &&[(u32, u32)]| {
                shape.iter().map(|(u, v)| of(x + u, y + v)).collect::<Option<Vec<u32>>>()
            };
            found.extend(shapes.iter().filter_map(corners));
        }
        found
    };
    let mut elements = all(&[&[(0, 0)]]);
    elements.extend(all(&[&[(0, 0), (1, 0)], &[(0, 0), (0, 1)], &[(0, 0), (1, 1)]]));
    elements.extend(all(&[&[(0, 0), (1, 0), (1, 1)], &[(0, 0), (1, 1), (0, 1)]]));
    elements
}

/// The sheet rolled up, more tightly with each frame, so that its layers come near each other.
fn rolled(side: u32, frame: u32) -> Vec<Point> {
    let place = |k: u32| {
        let (u, v) = (f64::from(k % side) / f64::from(side), f64::from(k / side) / f64::from(side));
        let (angle, radius) = (14.0 * u, 0.3 + 0.25 * u * 0.8f64.powi(frame as i32) + 0.01 * (9.0 * v).sin());
        [radius * angle.cos(), radius * angle.sin(), v]
    };
    (0..side * side).map(place).collect()
}

/// The box around an element on its way from one position to the other.
fn swept(element: &[u32], from: &[Point], to: &[Point]) -> Aabb {
    let corners = || element.iter().flat_map(|&vertex| [from[vertex as usize], to[vertex as usize]]);
    let all = |pick: fn(f64, f64) -> f64| {
        corners().reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default()
    };
    Aabb::from_f64(all(f64::min), all(f64::max), [0.0; 3])
}

fn class(element: &[u32]) -> u32 {
    [VERTEX, EDGE, FACE][element.len() - 1]
}

/// A cloth and the world of its elements, whose slots are their numbers.
struct Cloth {
    elements: Vec<Vec<u32>>,
    owners: Owners,
    world: OwnedWorld,
}

impl Cloth {
    fn new(elements: Vec<Vec<u32>>, from: &[Point], to: &[Point]) -> Result<Self, Error> {
        let owners = elements.iter().map(Vec::as_slice).collect();
        let boxes: Vec<Aabb> = elements.iter().map(|element| swept(element, from, to)).collect();
        let capacity = Capacity::for_objects(elements.len() as u32);
        let mut owned = OwnedWorld::new(&Config::new(capacity).with_filters())?;
        let mut world = owned.world();
        let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes))?.collect();
        for (id, element) in ids.into_iter().zip(&elements) {
            world.set_filter(id, Filter::class(class(element)))?;
        }
        let mut meets = [0; 32];
        (meets[VERTEX as usize], meets[EDGE as usize], meets[FACE as usize]) =
            (1 << FACE, 1 << EDGE, 1 << VERTEX);
        world.set_classes(&meets)?;
        Ok(Self { elements, owners, world: owned })
    }

    /// The pairs that may meet on the way.
    fn near(&mut self, from: &[Point], to: &[Point]) -> Result<Vec<[u32; 2]>, Error> {
        let boxes: Vec<Aabb> = self.elements.iter().map(|element| swept(element, from, to)).collect();
        let rule = self.owners.rule();
        let mut world = self.world.world();
        Ok(world.on(&Serial).with_rule(&rule).step_over(Boxes::new(&boxes))?.pairs().to_vec())
    }
}

fn main() -> Result<(), Error> {
    let side = std::env::args().nth(1).and_then(|side| side.parse().ok()).unwrap_or(200);
    let (elements, mut from) = (sheet(side), rolled(side, 0));
    let mut cloth = Cloth::new(elements, &from, &from)?;
    for frame in 1..=5 {
        let to = rolled(side, frame);
        let start = std::time::Instant::now();
        let pairs = cloth.near(&from, &to)?;
        let edges = pairs.iter().filter(|[a, _]| class(&cloth.elements[*a as usize]) == EDGE).count();
        println!(
            "frame {frame}: {edges} pairs of edges, {} of a vertex and a face, of {} elements in {:?}; {} candidates",
            pairs.len() - edges,
            cloth.elements.len(),
            start.elapsed(),
            cloth.world.as_world().stats().candidates
        );
        from = to;
    }
    Ok(())
}

#[test]
fn pairs_are_those_of_brute_force() -> Result<(), Error> {
    const SIDE: u32 = 24;
    let (elements, mut from) = (sheet(SIDE), rolled(SIDE, 0));
    assert_eq!(elements.len(), 24 * 24 + (2 * 24 * 23 + 23 * 23) + 2 * 23 * 23);
    let mut cloth = Cloth::new(elements.clone(), &from, &from)?;
    let mut told = 0;
    for frame in 1..=4 {
        let to = rolled(SIDE, frame);
        let boxes: Vec<Aabb> = elements.iter().map(|element| swept(element, &from, &to)).collect();
        let mut expected = Vec::new();
        for b in 0..elements.len() {
            for a in 0..b {
                let kinds = [class(&elements[a]), class(&elements[b])];
                let apart = elements[a].iter().all(|vertex| !elements[b].contains(vertex));
                if (kinds == [EDGE; 2] || kinds == [VERTEX, FACE]) && apart && boxes[a].overlaps(&boxes[b]) {
                    expected.push([a as u32, b as u32]);
                }
            }
        }
        let mut pairs = cloth.near(&from, &to)?;
        pairs.sort_unstable();
        expected.sort_unstable();
        assert_eq!(pairs, expected, "frame {frame}");
        told += pairs.len();
        from = to;
    }
    assert!(told > 1000, "layers come near each other: {told}");
    Ok(())
}
