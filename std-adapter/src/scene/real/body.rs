//! What a scene is made of: boxes that rest, shiver, walk or fly.

use super::Random;
use crate::Aabb;

/// A box and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Half the edges.
    pub(super) half: [f32; 3],
    pub(super) centre: [f32; 3],
    pub(super) motion: Motion,
}

/// How a body moves. Velocities are in metres a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    /// Not at all: its box is the same in every frame.
    Rest,
    /// Stands somewhere else near its home in each frame, as what lies on a ground in a physics engine.
    Shiver { home: [f32; 3], reach: [f32; 3] },
    /// Goes straight on and turns round where its centre would leave a range of its own.
    Walk { velocity: [f32; 3], low: [f32; 3], high: [f32; 3] },
    /// So fast that its box is all that it passes in a frame; starts again anywhere once it has left the room.
    Fly { velocity: [f32; 3], low: [f32; 3], high: [f32; 3] },
}

impl Body {
    pub(super) fn resting(edges: [f32; 3], centre: [f32; 3]) -> Self {
        Self { half: edges.map(|edge| edge / 2.0), centre, motion: Motion::Rest }
    }

    /// A body that walks in a room, whose walls its box never passes. On an axis where the room is too narrow it stays in
    /// the middle.
    pub(super) fn walking(
        edges: [f32; 3],
        centre: [f32; 3],
        mut velocity: [f32; 3],
        room: ([f32; 3], [f32; 3]),
    ) -> Self {
        let half = edges.map(|edge| edge / 2.0);
        let (mut low, mut high) = room;
        for k in 0..3 {
            (low[k], high[k]) = (low[k] + half[k], high[k] - half[k]);
            if low[k] >= high[k] {
                let middle = (low[k] + high[k]) / 2.0;
                (low[k], high[k], velocity[k]) = (middle, middle, 0.0);
            }
        }
        let centre = [0, 1, 2].map(|k| centre[k].clamp(low[k], high[k]));
        Self { half, centre, motion: Motion::Walk { velocity, low, high } }
    }

    /// A body that walks, by no more than `reach` from where it starts.
    pub(super) fn near_home(edges: [f32; 3], home: [f32; 3], velocity: [f32; 3], reach: [f32; 3]) -> Self {
        let low = [0, 1, 2].map(|k| home[k] - reach[k] - edges[k] / 2.0);
        let high = [0, 1, 2].map(|k| home[k] + reach[k] + edges[k] / 2.0);
        Self::walking(edges, home, velocity, (low, high))
    }

    pub(super) fn aabb(&self) -> Aabb {
        let Self { half, centre, motion } = self;
        let end = match motion {
            Motion::Fly { velocity, .. } => [0, 1, 2].map(|k| centre[k] + velocity[k]),
            _ => *centre,
        };
        Aabb::new(
            [0, 1, 2].map(|k| centre[k].min(end[k]) - half[k]),
            [0, 1, 2].map(|k| centre[k].max(end[k]) + half[k]),
        )
    }

    /// Goes to the next frame. Tells whether the box may have changed.
    pub(super) fn advance(&mut self, random: &mut Random) -> bool {
        let centre = &mut self.centre;
        match &mut self.motion {
            Motion::Rest => return false,
            Motion::Shiver { home, reach } => {
                *centre = [0, 1, 2].map(|k| random.between(home[k] - reach[k], home[k] + reach[k]));
            }
            Motion::Walk { velocity, low, high } => {
                for k in 0..3 {
                    let goal = centre[k] + velocity[k];
                    let wall = goal.clamp(low[k], high[k]);
                    if wall != goal {
                        velocity[k] = -velocity[k];
                    }
                    // As far back as it went through the wall, but not through the other wall.
                    centre[k] = (wall + (wall - goal)).clamp(low[k], high[k]);
                }
            }
            Motion::Fly { velocity, low, high } => {
                *centre = [0, 1, 2].map(|k| centre[k] + velocity[k]);
                if (0..3).any(|k| !(low[k]..=high[k]).contains(&centre[k])) {
                    *centre = [0, 1, 2].map(|k| random.between(low[k], high[k]));
                }
            }
        }
        true
    }

    /// Gives it another velocity, if it walks.
    pub(super) fn kick(&mut self, to: [f32; 3]) {
        if let Motion::Walk { velocity, .. } = &mut self.motion {
            *velocity = to;
        }
    }
}

/// The room of this side about the origin.
pub(super) fn room(side: f32) -> ([f32; 3], [f32; 3]) {
    ([-side / 2.0; 3], [side / 2.0; 3])
}

/// A point of a room.
pub(super) fn point((low, high): ([f32; 3], [f32; 3]), random: &mut Random) -> [f32; 3] {
    [0, 1, 2].map(|k| random.between(low[k], high[k]))
}

/// A vector of this length, of any direction.
pub(super) fn direction(length: f32, random: &mut Random) -> [f32; 3] {
    loop {
        let vector = random.in_ball(1.0);
        let is = vector.iter().map(|x| x * x).sum::<f32>().sqrt();
        // Too short a vector has lost its direction to rounding.
        if is > 0.01 {
            return vector.map(|x| x * length / is);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walkers_stay_in_their_room() {
        let mut random = Random::new(1, 0);
        let mut body = Body::walking([1.0; 3], [9.0; 3], [0.7, -1.3, 40.0], room(6.0));
        for _ in 0..100 {
            assert!(body.advance(&mut random));
            let aabb = body.aabb();
            assert!(aabb.min.iter().chain(&aabb.max).all(|x| (-3.0..=3.0).contains(x)), "{aabb:?}");
        }
        let narrow = Body::walking([4.0, 1.0, 1.0], [1.0; 3], [1.0; 3], room(3.0));
        assert_eq!((narrow.centre[0], narrow.aabb().min[0]), (0.0, -2.0));
    }

    #[test]
    fn flyers_pass_all_of_their_box_and_start_again() {
        let mut random = Random::new(1, 0);
        let (low, high) = room(10.0);
        let motion = Motion::Fly { velocity: [8.0, 0.0, 0.0], low, high };
        let mut body = Body { half: [0.1; 3], centre: [-4.0, 1.0, 2.0], motion };
        assert_eq!(body.aabb(), Aabb::new([-4.1, 0.9, 1.9], [4.1, 1.1, 2.1]));
        body.advance(&mut random);
        assert_eq!(body.centre, [4.0, 1.0, 2.0]);
        body.advance(&mut random);
        assert!(body.centre.iter().all(|x| (-5.0..=5.0).contains(x)) && body.centre[1] != 1.0);
    }

    #[test]
    fn who_rests_cannot_be_kicked() {
        let mut random = Random::new(1, 0);
        let mut body = Body::resting([1.0; 3], [0.0; 3]);
        let before = body;
        body.kick([1.0; 3]);
        assert!(!body.advance(&mut random));
        assert_eq!(body, before);
    }
}
