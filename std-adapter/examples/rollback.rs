//! Rollback: a game plays on with guessed inputs, and goes back by up to 8 frames when the true ones come. The world is
//! saved before each frame, and goes back with the game; also from more room than it had when it was saved, as players come all the
//! time and the world grows with them.

use trisap::{Aabb, Boxes, Capacity, Config, Error, OwnedWorld, Pair};

/// Frames that can be taken back.
const KEPT: usize = 8;
/// Players at first, and how many come every fifth frame.
const PLAYERS: usize = 300;
const JOINING: usize = 20;

/// What a frame found: all pairs, new ones, lost ones. In ascending order, as a step in more room may tell them in another one.
type Seen = [Vec<Pair>; 3];

/// What a player wants in a frame: a step to the side.
fn input(frame: usize, player: usize) -> f32 {
    let bits = (frame / 4).wrapping_mul(2_654_435_761) ^ player.wrapping_mul(40_503);
    (bits % 200) as f32 / 1000.0 - 0.1
}

/// Where a player begins.
fn place(player: usize) -> Aabb {
    let corner = [(player % 25) as f32 * 1.15, 0.0, (player / 25) as f32 * 1.15];
    Aabb::new(corner, corner.map(|low| low + 1.0))
}

struct Game {
    owned: OwnedWorld,
    bodies: Vec<Aabb>,
}

impl Game {
    fn new() -> Result<Self, Error> {
        let config = Config::new(Capacity::for_objects(PLAYERS as u32)).with_events();
        let mut game = Self { owned: OwnedWorld::new(&config)?, bodies: Vec::new() };
        game.join(PLAYERS)?;
        Ok(game)
    }

    fn room(&self) -> u32 {
        self.owned.as_world().capacity().objects
    }

    /// Players come; where there is no room for them, the world moves to twice as much.
    fn join(&mut self, players: usize) -> Result<(), Error> {
        for _ in 0..players {
            let body = place(self.bodies.len());
            if self.owned.as_world().len() == self.room() {
                let config = self.owned.as_world().config();
                self.owned.move_to(&config.with_capacity(Capacity::for_objects(2 * self.room())))?;
            }
            self.owned.world().insert(body)?;
            self.bodies.push(body);
        }
        Ok(())
    }

    /// Plays a frame; every second player is guessed to stand still until all inputs are known.
    fn play(&mut self, frame: usize, all_known: bool) -> Result<Seen, Error> {
        if frame % 5 == 4 {
            self.join(JOINING)?;
        }
        let known = |player: &usize| all_known || player.is_multiple_of(2);
        for player in (0..self.bodies.len()).filter(known) {
            let step = input(frame, player);
            self.bodies[player].min[0] += step;
            self.bodies[player].max[0] += step;
        }
        let mut world = self.owned.world();
        let step = world.step_over(Boxes::new(&self.bodies))?;
        Ok([step.pairs(), step.found(), step.lost()].map(|pairs| {
            let mut pairs = pairs.to_vec();
            pairs.sort_unstable();
            pairs
        }))
    }
}

/// The game before a frame.
#[derive(Clone, Default)]
struct Saved {
    world: Vec<u8>,
    bodies: Vec<Aabb>,
    room: u32,
}

impl Saved {
    fn of(game: &Game) -> Result<Self, Error> {
        let world = game.owned.as_world();
        let mut bytes = vec![0; world.snapshot_size()];
        world.save(&mut bytes)?;
        Ok(Self { world: bytes, bodies: game.bodies.clone(), room: game.room() })
    }

    fn restore(&self, game: &mut Game) -> Result<(), Error> {
        game.owned.world().load(&self.world)?;
        game.bodies.clone_from(&self.bodies);
        Ok(())
    }
}

/// Plays frames; the inputs of half of the players come late by up to `KEPT` frames. Returns what each frame found in the end, how
/// many guesses were wrong, and how often the game went back to where its world had less room.
fn play_with_rollback(frames: usize) -> Result<(Vec<Seen>, [usize; 2]), Error> {
    let mut game = Game::new()?;
    let mut history = vec![Saved::default(); KEPT];
    let (mut seen, mut wrong, mut across_growth) = (vec![Seen::default(); frames], 0, 0);
    for frame in 0..frames {
        history[frame % KEPT] = Saved::of(&game)?;
        seen[frame] = game.play(frame, false)?;
        // The inputs of the last frames have come.
        if frame % KEPT == KEPT - 1 {
            let guess = seen[frame].clone();
            let first = frame + 1 - KEPT;
            let saved = &history[first % KEPT];
            across_growth += usize::from(saved.room < game.room());
            saved.restore(&mut game)?;
            for again in first..=frame {
                seen[again] = game.play(again, true)?;
            }
            wrong += usize::from(guess != seen[frame]);
        }
    }
    Ok((seen, [wrong, across_growth]))
}

/// Plays frames whose inputs come in time.
fn play_in_time(frames: usize) -> Result<Vec<Seen>, Error> {
    let mut game = Game::new()?;
    (0..frames).map(|frame| game.play(frame, true)).collect()
}

fn main() -> Result<(), Error> {
    let frames = 120;
    let (seen, [wrong, across_growth]) = play_with_rollback(frames)?;
    assert!(seen == play_in_time(frames)?, "a world that went back is another one");
    println!("{frames} frames, gone back by {KEPT} every {KEPT}: the same pairs, found and lost, as in time");
    println!("{wrong} guesses were wrong; {across_growth} times the world had grown since it was saved");
    Ok(())
}

#[test]
fn going_back_and_on_is_as_if_nothing_had_been() {
    let (seen, [wrong, across_growth]) = play_with_rollback(40).unwrap();
    assert!(wrong > 0 && across_growth > 0, "{wrong} {across_growth}");
    assert!(seen.iter().any(|[_, found, lost]| !found.is_empty() && !lost.is_empty()));
    assert_eq!(seen, play_in_time(40).unwrap());
}
