//! Gravity that turns.

/// The gravity of a [`Setup`](super::Setup), one frame after another, without end: units a second squared.
#[derive(Clone, Debug)]
pub struct Gravity {
    pub(super) strength: f32,
    pub(super) turns: bool,
    pub(super) down: [f32; 3],
    pub(super) axis: [f32; 3],
}

impl Iterator for Gravity {
    type Item = [f32; 3];

    fn next(&mut self) -> Option<[f32; 3]> {
        let now = self.down.map(|x| x * self.strength);
        if self.turns {
            // About an axis that itself turns about z, so that every wall has its time as the floor.
            self.axis = turned(self.axis, [0.0, 0.0, 1.0]);
            self.down = turned(self.down, self.axis);
        }
        Some(now)
    }
}

/// `vector` after one frame of a turn about the unit vector `axis`, a turn taking 6.2 s: Rodrigues' formula, scaled
/// back to length one.
fn turned(vector: [f32; 3], axis: [f32; 3]) -> [f32; 3] {
    // Of 2 pi / (6.2 * 30). Literals, because the maths library differs between platforms.
    const SIN: f32 = 0.033_774_14;
    const COS: f32 = 0.999_429_5;
    let [x, y, z] = vector;
    let [a, b, c] = axis;
    let cross = [b * z - c * y, c * x - a * z, a * y - b * x];
    let along = (a * x + b * y + c * z) * (1.0 - COS);
    let turned = [0, 1, 2].map(|k| vector[k] * COS + cross[k] * SIN + axis[k] * along);
    let length = turned.iter().map(|x| x * x).sum::<f32>().sqrt();
    turned.map(|x| x / length)
}
