//! A game loop: balls fall to the ground, fall asleep, come and go, and what the game keeps for each contact stands in a vector.

use std::collections::HashMap;
use trisap::{Aabb, BroadPhase, Error};

/// The ground is an entity, too.
const GROUND: u64 = 0;

/// What a game keeps for two that touch: a manifold, a sound, or only this.
#[derive(Clone, Copy, Default)]
struct Contact {
    since: usize,
}

struct Ball {
    place: [f32; 3],
    speed: f32,
    asleep: bool,
}

#[derive(Default)]
struct Game {
    broad_phase: BroadPhase<u64>,
    balls: HashMap<u64, Ball>,
    /// By the number that a pair has from the step that finds it to the step that loses it.
    contacts: Vec<Contact>,
    born: u64,
}

impl Game {
    /// Some come, the oldest go, and all fall.
    fn play(&mut self, frame: usize) -> Result<(), Error> {
        for _ in 0..20 {
            self.born += 1;
            let place = [(self.born * 7 % 40) as f32, (self.born * 11 % 40) as f32, 12.0];
            self.balls.insert(self.born, Ball { place, speed: 0.0, asleep: false });
        }
        for entity in self.born.saturating_sub(2020)..self.born.saturating_sub(2000) {
            if self.balls.remove(&entity).is_some() {
                self.broad_phase.remove(&entity);
            }
        }
        for (entity, ball) in self.balls.iter_mut().filter(|(_, ball)| !ball.asleep) {
            ball.speed += 0.01;
            ball.place[2] = (ball.place[2] - ball.speed).max(0.5);
            self.broad_phase.insert(*entity, Aabb::from_center(ball.place, [0.5; 3]))?;
            if ball.place[2] == 0.5 {
                ball.asleep = true;
                // Its pairs stay, and steps set them aside until its box is given anew.
                self.broad_phase.set_resting(entity);
            }
        }
        let step = self.broad_phase.step()?;
        for (_pair, contact) in step.found_contacts() {
            self.contacts.resize(self.contacts.len().max(contact + 1), Contact::default());
            self.contacts[contact] = Contact { since: frame };
        }
        Ok(())
    }
}

fn run(frames: usize) -> Result<Game, Error> {
    let mut game = Game::default();
    game.broad_phase.keep_contacts()?;
    let ground = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY, f32::INFINITY, 0.0]);
    game.broad_phase.insert(GROUND, ground)?;
    for frame in 0..frames {
        game.play(frame)?;
    }
    Ok(game)
}

fn main() -> Result<(), Error> {
    let game = run(300)?;
    let live = || game.broad_phase.pairs().filter_map(|[a, b]| game.broad_phase.contact(&a, &b));
    let oldest = live().map(|contact| game.contacts[contact].since).min();
    println!("{} balls, {} contacts, the oldest since frame {oldest:?}", game.balls.len(), live().count());
    Ok(())
}

#[test]
fn all_that_lie_touch_the_ground() {
    let game = run(200).unwrap();
    let lying = game.balls.iter().filter(|(_, ball)| ball.asleep).count();
    let grounded = game.broad_phase.contacts_of(&GROUND).count();
    assert!(lying > 1000 && grounded == lying);
}
