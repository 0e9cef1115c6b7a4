//! Rollback: a game plays on with guessed inputs, and goes back by up to 8 frames when the true ones come. The world is
//! saved before each frame, and goes back with the game.

use trisap::{Aabb, Boxes, Capacity, Config, Error, OwnedWorld, Pair, World};

/// Frames that can be taken back.
const KEPT: usize = 8;
const PLAYERS: usize = 600;

/// What a frame found: all pairs, new ones, lost ones.
type Seen = [Vec<Pair>; 3];

/// What a player wants in a frame: a step to the side.
fn input(frame: usize, player: usize) -> f32 {
    let bits = (frame / 4).wrapping_mul(2_654_435_761) ^ player.wrapping_mul(40_503);
    (bits % 200) as f32 / 1000.0 - 0.1
}

fn crowd() -> Vec<Aabb> {
    let corner = |i: usize| [(i % 25) as f32 * 1.15, 0.0, (i / 25) as f32 * 1.15];
    (0..PLAYERS).map(|i| Aabb::new(corner(i), corner(i).map(|low| low + 1.0))).collect()
}

/// Plays a frame; players whose inputs are not known are guessed to stand still.
fn play(world: &mut World<'_>, bodies: &mut [Aabb], frame: usize, known: usize) -> Result<Seen, Error> {
    for (player, body) in bodies.iter_mut().enumerate().take(known) {
        let step = input(frame, player);
        body.min[0] += step;
        body.max[0] += step;
    }
    let step = world.step_over(Boxes::new(bodies))?;
    Ok([step.pairs().to_vec(), step.found().to_vec(), step.lost().to_vec()])
}

/// Plays frames; the inputs of half of the players come late by up to `KEPT` frames. Returns what each frame found in the end, and how many
/// guesses were wrong.
fn play_with_rollback(frames: usize) -> Result<(Vec<Seen>, usize), Error> {
    let config = Config::new(Capacity::for_objects(PLAYERS as u32)).with_events();
    let mut owned = OwnedWorld::<u32>::new(&config)?;
    let mut world = owned.world();
    let mut bodies = crowd();
    world.insert_many(Boxes::new(&bodies))?;

    let mut history: Vec<(Vec<u8>, Vec<Aabb>)> = vec![Default::default(); KEPT];
    let (mut seen, mut wrong) = (vec![Seen::default(); frames], 0);
    for frame in 0..frames {
        let (snapshot, saved) = &mut history[frame % KEPT];
        snapshot.resize(world.snapshot_size(), 0);
        world.save(snapshot)?;
        saved.clone_from(&bodies);
        seen[frame] = play(&mut world, &mut bodies, frame, PLAYERS / 2)?;
        // The inputs of the last frames have come.
        if frame % KEPT == KEPT - 1 {
            let guess = seen[frame].clone();
            let first = frame + 1 - KEPT;
            let (snapshot, saved) = &history[first % KEPT];
            world.load(snapshot)?;
            bodies.clone_from(saved);
            for again in first..=frame {
                seen[again] = play(&mut world, &mut bodies, again, PLAYERS)?;
            }
            wrong += usize::from(guess != seen[frame]);
        }
    }
    Ok((seen, wrong))
}

/// Plays frames whose inputs come in time.
fn play_in_time(frames: usize) -> Result<Vec<Seen>, Error> {
    let config = Config::new(Capacity::for_objects(PLAYERS as u32)).with_events();
    let mut owned = OwnedWorld::<u32>::new(&config)?;
    let mut world = owned.world();
    let mut bodies = crowd();
    world.insert_many(Boxes::new(&bodies))?;
    (0..frames).map(|frame| play(&mut world, &mut bodies, frame, PLAYERS)).collect()
}

fn main() -> Result<(), Error> {
    let frames = 120;
    let (seen, wrong) = play_with_rollback(frames)?;
    assert!(seen == play_in_time(frames)?, "a world that went back is another one");
    println!("{frames} frames, gone back by {KEPT} every {KEPT}: the same pairs, found and lost, as in time");
    println!("{wrong} guesses were wrong");
    Ok(())
}

#[test]
fn going_back_and_on_is_as_if_nothing_had_been() {
    let (seen, wrong) = play_with_rollback(40).unwrap();
    assert!(wrong > 0 && seen.iter().any(|[_, found, lost]| !found.is_empty() && !lost.is_empty()));
    assert_eq!(seen, play_in_time(40).unwrap());
}
