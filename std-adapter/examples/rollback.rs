//! Rollback: a game plays on with guessed inputs, and goes back by up to 8 frames when the true ones come. The broad phase is
//! copied before each frame, and goes back with the game; also from more room than it had then, as players come all the time and
//! it grows with them. Results are sorted, so that they do not depend on the room.

use trisap::{Aabb, BroadPhase, Error};

/// Frames that can be taken back.
const KEPT: usize = 8;
/// Players at first, and how many come every fifth frame.
const PLAYERS: usize = 300;
const JOINING: usize = 20;

/// What a frame found: all pairs, new ones, lost ones, in their order.
type Seen = [Vec<[usize; 2]>; 3];

/// What a player wants in a frame: a step to the side.
fn input(frame: usize, player: usize) -> f32 {
    let bits = (frame / 4).wrapping_mul(2_654_435_761) ^ player.wrapping_mul(40_503);
    (bits % 200) as f32 / 1000.0 - 0.1
}

/// Where a player begins.
fn place(player: usize) -> [f32; 3] {
    [(player % 25) as f32 * 1.15, 0.0, (player / 25) as f32 * 1.15]
}

#[derive(Clone, Default)]
struct Game {
    players: Vec<[f32; 3]>,
    broad_phase: BroadPhase<usize>,
}

impl Game {
    /// Plays a frame; every second player is guessed to stand still until all inputs are known.
    fn play(&mut self, frame: usize, all_known: bool) -> Result<Seen, Error> {
        let count = self.players.len();
        let joining = if count == 0 { PLAYERS } else { JOINING * usize::from(frame % 5 == 4) };
        self.players.extend((count..count + joining).map(place));
        for (player, place) in self.players.iter_mut().enumerate() {
            if all_known || player.is_multiple_of(2) {
                place[0] += input(frame, player);
            }
            self.broad_phase.insert(player, Aabb::from_center(*place, [0.5; 3]))?;
        }
        self.broad_phase.step()?;
        self.broad_phase.sort_results();
        let step = &self.broad_phase;
        Ok([step.pairs().collect(), step.found().collect(), step.lost().collect()])
    }

    /// Becomes a copy of the game as it was or will be, in the memory that there is.
    fn copy_from(&mut self, other: &Self) {
        self.players.clone_from(&other.players);
        self.broad_phase.clone_from(&other.broad_phase);
    }
}

/// Plays frames; the inputs of half of the players come late by up to `KEPT` frames. Returns what each frame found in the end, how
/// many guesses were wrong, and how often the game went back to where its world had less room.
fn play_with_rollback(frames: usize) -> Result<(Vec<Seen>, [usize; 2]), Error> {
    let mut game = Game::default();
    let room = |game: &Game| game.broad_phase.config().capacity.objects;
    let (mut seen, mut wrong, mut across_growth) = (Vec::new(), 0, 0);
    // As often as frames can be taken back: memory that is used again.
    let mut history = vec![Game::default(); KEPT];
    for frame in 0..frames {
        history[frame % KEPT].copy_from(&game);
        seen.push(game.play(frame, false)?);
        // The inputs of the last frames have come.
        if frame % KEPT == KEPT - 1 {
            let guess = seen[frame].clone();
            let first = frame + 1 - KEPT;
            across_growth += usize::from(room(&history[0]) < room(&game));
            game.copy_from(&history[0]);
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
    let mut game = Game::default();
    (0..frames).map(|frame| game.play(frame, true)).collect()
}

fn main() -> Result<(), Error> {
    let frames = 120;
    let (seen, [wrong, across_growth]) = play_with_rollback(frames)?;
    assert!(seen == play_in_time(frames)?, "a world that went back is another one");
    println!("{frames} frames, gone back by {KEPT} every {KEPT}: the same pairs, found and lost, as in time");
    println!("{wrong} guesses were wrong; {across_growth} times the world had grown since it was copied");
    Ok(())
}

#[test]
fn going_back_and_on_is_as_if_nothing_had_been() {
    let (seen, [wrong, across_growth]) = play_with_rollback(40).unwrap();
    assert!(wrong > 0 && across_growth > 0, "{wrong} {across_growth}");
    assert!(seen.iter().any(|[_, found, lost]| !found.is_empty() && !lost.is_empty()));
    assert_eq!(seen, play_in_time(40).unwrap());
}
