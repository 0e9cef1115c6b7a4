//! Entities, components and systems, as Bevy has them: the broad phase is a resource, its events are read by other systems.

use trisap::{Aabb, BroadPhase, Error};

/// A number and how often it has been used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Entity {
    index: usize,
    generation: u32,
}

#[derive(Default)]
struct Ecs {
    generations: Vec<u32>,
    /// The components, by index.
    places: Vec<Option<[f32; 3]>>,
    health: Vec<Option<u32>>,
    // Resources.
    broad_phase: BroadPhase<Entity>,
    hits: Vec<[Entity; 2]>,
}

impl Ecs {
    fn spawn(&mut self, place: [f32; 3], health: u32) -> Entity {
        let free = self.places.iter().position(Option::is_none);
        let index = free.unwrap_or(self.places.len());
        if free.is_none() {
            self.generations.push(0);
            self.places.push(None);
            self.health.push(None);
        }
        self.generations[index] += 1;
        (self.places[index], self.health[index]) = (Some(place), Some(health));
        Entity { index, generation: self.generations[index] }
    }

    fn entities(&self) -> impl Iterator<Item = (Entity, [f32; 3])> {
        (0..).zip(&self.places).zip(&self.generations).filter_map(|((index, place), generation)| {
            Some((Entity { index, generation: *generation }, (*place)?))
        })
    }

    /// The system that moves.
    fn drift(&mut self) {
        for (index, place) in self.places.iter_mut().enumerate() {
            let Some(place) = place else { continue };
            place[index % 3] += if index % 2 == 0 { 0.2 } else { -0.2 };
        }
    }

    /// The system that finds who meets: the glue.
    fn meet(&mut self) -> Result<(), Error> {
        let boxes: Vec<_> = self.entities().collect();
        for (entity, place) in boxes {
            self.broad_phase.insert(entity, Aabb::from_center(place, [0.5; 3]))?;
        }
        self.hits.clear();
        self.hits.extend(self.broad_phase.step()?.found());
        Ok(())
    }

    /// The system that reads the events.
    fn hurt(&mut self) {
        for entity in self.hits.iter().flatten() {
            if let Some(health) = &mut self.health[entity.index] {
                *health = health.saturating_sub(1);
            }
        }
    }

    /// The system that removes the dead.
    fn bury(&mut self) {
        let dead: Vec<_> =
            self.entities().filter(|(entity, _)| self.health[entity.index] == Some(0)).collect();
        for (entity, _) in dead {
            (self.places[entity.index], self.health[entity.index]) = (None, None);
            self.broad_phase.remove(&entity);
        }
    }
}

/// How many have met, and how many are left.
fn run(frames: usize) -> Result<[usize; 2], Error> {
    let mut ecs = Ecs::default();
    let mut met = 0;
    for frame in 0..frames {
        for k in 0..10 {
            ecs.spawn([(frame % 9) as f32 * 2.0, k as f32 * 2.0, (k * frame % 7) as f32], 3);
        }
        ecs.drift();
        ecs.meet()?;
        ecs.hurt();
        met += ecs.hits.len();
        ecs.bury();
        assert_eq!(ecs.broad_phase.len(), ecs.entities().count());
    }
    Ok([met, ecs.entities().count()])
}

fn main() -> Result<(), Error> {
    let [met, left] = run(200)?;
    println!("{met} times two have met, {left} entities are left");
    Ok(())
}

#[test]
fn some_meet_and_some_die() {
    let [met, left] = run(60).unwrap();
    assert!(met > 100 && left < 600, "{met} {left}");
}
