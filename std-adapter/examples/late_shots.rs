//! Late shots: a shot reaches the server some ticks after it was fired, and has to hit what its player saw. A ring of copies answers
//! rays of earlier ticks, also about who has gone since. The world of now is not touched: nobody wakes or moves, and no event is
//! lost.

use trisap::{Aabb, BroadPhase, Cast, Error};

/// How many ticks late a shot may come.
const KEPT: usize = 8;
const RUNNERS: u32 = 200;
/// Someone who sits still, behind a wall that the world has too.
const SITTER: u32 = 1000;
const WALL: u32 = 1001;

/// Where a runner is.
fn runner(key: u32, tick: usize) -> Aabb {
    let (row, speed) = ((key / 20) as f32, 0.1 + (key % 7) as f32 * 0.02);
    Aabb::from_center([(key % 20) as f32 * 2.0 + speed * tick as f32, row * 3.0, 1.0], [0.4, 0.4, 1.0])
}

#[derive(Default)]
struct Server {
    world: BroadPhase<u32>,
    /// The worlds of the last ticks, each in the place of its tick.
    past: [BroadPhase<u32>; KEPT],
    tick: usize,
}

impl Server {
    fn new() -> Result<Self, Error> {
        let mut server = Self::default();
        server.world.insert(SITTER, Aabb::from_center([-3.0, 0.0, 1.0], [0.5; 3]))?;
        server.world.insert(WALL, Aabb::new([-4.0, -5.0, 0.0], [-3.25, 50.0, 3.0]))?;
        server.world.set_resting(&SITTER);
        server.world.set_resting(&WALL);
        Ok(server)
    }

    /// All run; one goes in each tick.
    fn play(&mut self) -> Result<(), Error> {
        self.tick += 1;
        self.world.remove(&(self.tick as u32 - 1));
        let tick = self.tick;
        self.world.extend((tick as u32..RUNNERS).map(|key| (key, runner(key, tick))));
        self.world.step()?;
        self.past[tick % KEPT].clone_from(&self.world); // in memory that is used again
        Ok(())
    }

    /// Whom a shot hits that was fired at an earlier tick. `None` if nobody, or if it comes too late.
    fn shot(&self, ray: &Cast, fired: usize) -> Option<u32> {
        let is_kept = fired <= self.tick && fired + KEPT > self.tick && fired > 0;
        let past = is_kept.then(|| &self.past[fired % KEPT])?;
        past.first_hit(ray).ok()?.map(|(key, _)| key)
    }
}

/// Plays ticks with a shot at each of the last ones in each; returns how many hit, and how many of these hit another one than now.
fn play(ticks: usize, check: impl Fn(&Server, &Cast, usize, Option<u32>)) -> Result<[usize; 2], Error> {
    let mut server = Server::new()?;
    let [mut hits, mut others] = [0; 2];
    for tick in 1..=ticks {
        server.play()?;
        for fired in tick.saturating_sub(KEPT - 1).max(1)..=tick {
            let y = (tick * 7 % 30) as f32;
            let ray = Cast::ray([(tick * 5 % 40) as f32, y - 2.0, 1.0], [0.0, 1.0, 0.0], 30.0);
            let hit = server.shot(&ray, fired);
            check(&server, &ray, fired, hit);
            hits += usize::from(hit.is_some());
            others += usize::from(hit != server.shot(&ray, tick));
        }
    }
    assert!(server.world.is_resting(&SITTER) && server.world.is_resting(&WALL));
    Ok([hits, others])
}

fn main() -> Result<(), Error> {
    let [hits, others] = play(60, |_, _, _, _| ())?;
    println!("{hits} late shots hit, {others} of them or of the others not what they would hit now");
    Ok(())
}

#[test]
fn late_shots_hit_what_was_there() {
    let nearest = |server: &Server, ray: &Cast, fired: usize, hit: Option<u32>| {
        // By going over all boxes of that tick: straight along y.
        let [x, y, z] = ray.start.min;
        let there = (fired as u32..RUNNERS).map(|key| (key, runner(key, fired)));
        let inside = there.filter(|(_, b)| b.contains_point([x, b.min[1], z]) && b.max[1] >= y);
        let reached = inside.filter(|(_, b)| b.min[1] <= y + ray.distance);
        let first = reached.map(|(key, b)| (b.min[1].max(y), key)).min_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(hit, first.map(|(_, key)| key), "tick {}, fired at {fired}", server.tick);
    };
    let [hits, others] = play(60, nearest).unwrap();
    assert!(hits > 100 && others > 10, "{hits} {others}");
    let server = Server::new().unwrap();
    assert_eq!(server.shot(&Cast::ray([0.0; 3], [1.0; 3], 1.0), 0), None);
}

/// The world of now goes on as it would have without a shot.
#[test]
fn shots_disturb_nothing() {
    let [mut with, mut without] = [Server::new().unwrap(), Server::new().unwrap()];
    for _ in 0..20 {
        with.play().unwrap();
        without.play().unwrap();
        for fired in 0..=with.tick {
            with.shot(&Cast::ray([0.0, -2.0, 1.0], [0.0, 1.0, 0.0], 50.0), fired);
        }
        let seen = |server: &Server| {
            let (world, stats) = (&server.world, server.world.stats());
            [world.pairs().collect::<Vec<_>>(), world.found().collect(), world.lost().collect()]
                .map(|all| (all, stats))
        };
        assert_eq!(seen(&with), seen(&without));
        assert!(with.world.is_resting(&SITTER));
    }
}
