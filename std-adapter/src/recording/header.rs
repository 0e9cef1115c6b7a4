//! The first 304 bytes of a recording.

use super::{Error, PaddedBox};
use crate::Aabb;

/// What a recording says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The name of the scene, such as `FreeFall`; at most 127 bytes.
    pub scene: String,
    /// The name of the kind of objects, such as `Cubes`; at most 127 bytes.
    pub objects: String,
    /// The number of objects; at least 1.
    pub count: u32,
    /// The number of frames; at least 1. (The file stores one less.)
    pub frames: u32,
    /// The box that the objects move in.
    pub world: Aabb,
}

pub(super) const BYTES: usize = 304;
pub(super) const BOX_BYTES: usize = size_of::<PaddedBox>();
const NAME_BYTES: usize = 128;

impl Header {
    /// The length of a whole file. Beyond what 64 bits can say, the largest number that they can.
    pub(super) fn file_bytes(&self) -> u64 {
        self.frame_bytes().saturating_mul(u64::from(self.frames)).saturating_add(BYTES as u64)
    }

    /// The length of a frame.
    pub(super) fn frame_bytes(&self) -> u64 {
        u64::from(self.count) * BOX_BYTES as u64
    }

    pub(super) fn decode(bytes: &[u8; BYTES]) -> Result<Self, Error> {
        let (names, numbers) = bytes.split_at(2 * NAME_BYTES);
        let mut words = numbers.chunks_exact(4).map(|word| [word[0], word[1], word[2], word[3]]);
        let mut word = || words.next().unwrap_or_default();
        let [objects, frames, _, _] = [(); 4].map(|()| i32::from_le_bytes(word()));
        let corners: PaddedBox = [(); 8].map(|()| f32::from_le_bytes(word()));
        match (u32::try_from(objects), u32::try_from(frames)) {
            (Ok(count @ 1..), Ok(frames)) => Ok(Self {
                scene: name(&names[..NAME_BYTES]),
                objects: name(&names[NAME_BYTES..]),
                count,
                frames: frames + 1,
                world: unpad(&corners),
            }),
            _ => Err(Error::BadCounts { objects, frames }),
        }
    }

    pub(super) fn encode(&self) -> Result<[u8; BYTES], Error> {
        let good_name = |name: &str| name.len() < NAME_BYTES && !name.contains('\0');
        let count = i32::try_from(self.count).ok().filter(|&count| count > 0);
        let frames = self.frames.checked_sub(1).and_then(|frames| i32::try_from(frames).ok());
        let (Some(count), Some(frames), true, true) =
            (count, frames, good_name(&self.scene), good_name(&self.objects))
        else {
            return Err(Error::BadHeader);
        };
        let mut bytes = [0; BYTES];
        bytes[..self.scene.len()].copy_from_slice(self.scene.as_bytes());
        bytes[NAME_BYTES..][..self.objects.len()].copy_from_slice(self.objects.as_bytes());
        let counts = [count, frames, 0, 0].into_iter().map(i32::to_le_bytes);
        let corners = pad(&self.world).into_iter().map(f32::to_le_bytes);
        for (place, word) in bytes[2 * NAME_BYTES..].chunks_exact_mut(4).zip(counts.chain(corners)) {
            place.copy_from_slice(&word);
        }
        Ok(bytes)
    }
}

fn name(field: &[u8]) -> String {
    let end = field.iter().position(|&byte| byte == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).into_owned()
}

pub(super) fn pad(aabb: &Aabb) -> PaddedBox {
    let ([a, b, c], [d, e, f]) = (aabb.min, aabb.max);
    [a, b, c, 0.0, d, e, f, 0.0]
}

fn unpad(&[a, b, c, _, d, e, f, _]: &PaddedBox) -> Aabb {
    Aabb::new([a, b, c], [d, e, f])
}
