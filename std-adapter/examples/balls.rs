//! 2,000 balls in a box, drawn live in the terminal; those that touch are bright. `cargo run --release --example balls`

use crossterm::cursor::{Hide, MoveTo, Show};
use crossterm::style::Print;
use crossterm::{QueueableCommand, terminal};
use std::io::{self, Write};
use std::time::Duration;
use trisap::{Aabb, BroadPhase};

const BALLS: usize = 2000;
const RADIUS: f32 = 0.4;

struct Ball {
    place: [f32; 2],
    speed: [f32; 2],
}

/// As wide and as high as the picture.
fn balls([wide, high]: [f32; 2]) -> Vec<Ball> {
    let spread = |k: usize, by: usize| (k * by % 1009) as f32 / 1009.0;
    (0..BALLS)
        .map(|k| Ball {
            place: [spread(k, 613) * wide, spread(k, 257) * high],
            speed: [spread(k, 71) - 0.5, spread(k, 37) - 0.5],
        })
        .collect()
}

/// Moves all balls and draws them; returns how many touch another one.
fn frame(
    balls: &mut [Ball],
    broad_phase: &mut BroadPhase<usize>,
    size: [u16; 2],
    out: &mut impl Write,
) -> Result<usize, Box<dyn std::error::Error>> {
    for (key, ball) in balls.iter_mut().enumerate() {
        for k in 0..2 {
            let high = f32::from(size[k]);
            let next = ball.place[k] + ball.speed[k];
            ball.speed[k] *= if (0.0..high).contains(&next) { 1.0 } else { -1.0 };
            ball.place[k] = next.clamp(0.0, high - 0.01);
        }
        let [x, y] = ball.place;
        broad_phase.insert(key, Aabb::from_center([x, y, 0.0], [RADIUS; 3]))?;
    }
    let mut touches = vec![false; balls.len()];
    for [a, b] in broad_phase.step()?.pairs() {
        let apart = [0, 1].map(|k| balls[a].place[k] - balls[b].place[k]);
        if apart[0] * apart[0] + apart[1] * apart[1] <= 4.0 * RADIUS * RADIUS {
            (touches[a], touches[b]) = (true, true);
        }
    }
    let mut rows = vec![vec![' '; usize::from(size[0])]; usize::from(size[1])];
    for (ball, touches) in balls.iter().zip(&touches) {
        let place = &mut rows[ball.place[1] as usize][ball.place[0] as usize];
        *place = if *touches || *place == 'O' { 'O' } else { '.' };
    }
    for (row, letters) in (0..).zip(rows) {
        out.queue(MoveTo(0, row))?.queue(Print(String::from_iter(letters)))?;
    }
    out.flush()?;
    Ok(touches.into_iter().filter(|touches| *touches).count())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let size = terminal::size().map_or([120, 40], |(wide, high)| [wide.max(20), high.max(10)]);
    let mut balls = balls(size.map(f32::from));
    let mut broad_phase = BroadPhase::new();
    let mut out = io::stdout().lock();
    out.queue(Hide)?;
    for _ in 0..600 {
        frame(&mut balls, &mut broad_phase, size, &mut out)?;
        std::thread::sleep(Duration::from_millis(16));
    }
    out.queue(Show)?.queue(Print("\n"))?.flush()?;
    Ok(())
}

#[test]
fn frames_are_drawn_without_a_terminal() {
    let (size, mut broad_phase, mut out) = ([120, 40], BroadPhase::new(), Vec::new());
    let mut balls = balls(size.map(f32::from));
    for _ in 0..20 {
        let touching = frame(&mut balls, &mut broad_phase, size, &mut out).unwrap();
        let touches = |a: &Ball, b: &Ball| {
            let apart = [0, 1].map(|k| a.place[k] - b.place[k]);
            apart[0] * apart[0] + apart[1] * apart[1] <= 4.0 * RADIUS * RADIUS
        };
        let expected = |k: usize| (0..BALLS).any(|other| other != k && touches(&balls[k], &balls[other]));
        assert_eq!(touching, (0..BALLS).filter(|k| expected(*k)).count());
    }
    let drawn = String::from_utf8(out).unwrap();
    assert!(drawn.contains('O') && drawn.contains('.'));
}
