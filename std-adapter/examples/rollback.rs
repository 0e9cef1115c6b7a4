//! Rollback: a game plays on with guessed inputs, and goes back by up to 8 frames when the true ones come. The broad phase is
//! saved before each frame, and goes back with the game; also from more room than it had when it was saved, as players come all the
//! time and it grows with them.

use trisap::{Aabb, BroadPhase, Error, Snapshot};

/// Frames that can be taken back.
const KEPT: usize = 8;
/// Players at first, and how many come every fifth frame.
const PLAYERS: usize = 300;
const JOINING: usize = 20;

/// What a frame found: all pairs, new ones, lost ones. In ascending order, as a step in more room may tell them in another one.
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

#[derive(Default)]
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
        let step = self.broad_phase.step()?;
        let mut seen = [step.pairs().collect(), step.found().collect(), step.lost().collect()];
        seen.iter_mut().for_each(|pairs: &mut Vec<_>| pairs.sort_unstable());
        Ok(seen)
    }

    fn save(&self) -> Saved {
        Saved { players: self.players.clone(), broad_phase: self.broad_phase.save() }
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), Error> {
        self.players.clone_from(&saved.players);
        self.broad_phase.restore(&saved.broad_phase)
    }
}

/// The game before a frame.
struct Saved {
    players: Vec<[f32; 3]>,
    broad_phase: Snapshot<usize>,
}

/// Plays frames; the inputs of half of the players come late by up to `KEPT` frames. Returns what each frame found in the end, how
/// many guesses were wrong, and how often the game went back to where its world had less room.
fn play_with_rollback(frames: usize) -> Result<(Vec<Seen>, [usize; 2]), Error> {
    let mut game = Game::default();
    let room = |game: &Game| game.broad_phase.config().capacity.objects;
    let (mut seen, mut wrong, mut across_growth) = (Vec::new(), 0, 0);
    let mut history = Vec::new();
    for frame in 0..frames {
        history.push((game.save(), room(&game)));
        seen.push(game.play(frame, false)?);
        // The inputs of the last frames have come.
        if history.len() == KEPT {
            let guess = seen[frame].clone();
            let first = frame + 1 - KEPT;
            let (saved, room_then) = &history[0];
            across_growth += usize::from(*room_then < room(&game));
            game.restore(saved)?;
            for again in first..=frame {
                seen[again] = game.play(again, true)?;
            }
            wrong += usize::from(guess != seen[frame]);
            history.clear();
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
