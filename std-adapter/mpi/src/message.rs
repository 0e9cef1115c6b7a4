//! What one rank tells another in a step.

use bytemuck::{Pod, Zeroable};
use trisap::Aabb;

/// The version of messages and files. Ranks of different versions do not work together.
pub const VERSION: u32 = 1;

const MAGIC: u32 = u32::from_le_bytes(*b"TSMP");

/// The box of an object that is not there. It is not valid, so that it overlaps nothing.
pub(crate) const NOWHERE: Aabb = Aabb::new([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);

/// An object that a rank does not know yet, or that it owns from now on.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Newcomer {
    pub(crate) key: u64,
    pub(crate) now: Aabb,
    /// The box of the last step, or [`NOWHERE`]: tells pairs that are new from those that another rank had.
    pub(crate) before: Aabb,
}

/// An object that a rank knows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Change {
    pub(crate) key: u64,
    pub(crate) now: Aabb,
}

/// All that one rank tells another in a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Batch {
    /// Objects that the receiver owns from now on.
    pub(crate) owned: Vec<Newcomer>,
    /// Objects that reach the receiver's cell from now on.
    pub(crate) entered: Vec<Newcomer>,
    /// Objects that reach it as before and have another box.
    pub(crate) moved: Vec<Change>,
    /// Objects that no longer reach it, with the boxes that they have now, or [`NOWHERE`] where they were removed.
    pub(crate) left: Vec<Change>,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    magic: u32,
    version: u32,
    step: u64,
    /// Items in each part, in the order of the fields of a batch.
    counts: [u32; 4],
}

impl Batch {
    /// The fewest bytes that say the same: the items without a header.
    pub(crate) fn needed(&self) -> u64 {
        let newcomers = self.owned.len() + self.entered.len();
        let changes = self.moved.len() + self.left.len();
        (newcomers * size_of::<Newcomer>() + changes * size_of::<Change>()) as u64
    }

    /// The objects that it tells of.
    pub(crate) fn objects(&self) -> u64 {
        (self.owned.len() + self.entered.len() + self.moved.len() + self.left.len()) as u64
    }

    /// As bytes.
    pub(crate) fn encode(&self, version: u32, step: u64) -> Vec<u8> {
        let counts = [self.owned.len(), self.entered.len(), self.moved.len(), self.left.len()];
        let header = Header { magic: MAGIC, version, step, counts: counts.map(|count| count as u32) };
        let mut bytes = Vec::with_capacity(size_of::<Header>() + self.needed() as usize);
        bytes.extend_from_slice(bytemuck::bytes_of(&header));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.owned));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.entered));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.moved));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.left));
        bytes
    }

    /// From bytes that [`encode`](Self::encode) made for this step; else what is wrong with them.
    pub(crate) fn decode(bytes: &[u8], version: u32, step: u64) -> Result<Self, String> {
        let (header, mut rest) =
            bytes.split_at_checked(size_of::<Header>()).ok_or("a message is shorter than its header")?;
        let header: Header = bytemuck::pod_read_unaligned(header);
        if header.magic != MAGIC {
            return Err("a message is none of this program".to_owned());
        }
        if header.version != version {
            return Err(format!("a message has version {} and not {version}", header.version));
        }
        if header.step != step {
            return Err(format!("a message is of step {} and not of step {step}", header.step));
        }
        let batch = Self {
            owned: take(&mut rest, header.counts[0])?,
            entered: take(&mut rest, header.counts[1])?,
            moved: take(&mut rest, header.counts[2])?,
            left: take(&mut rest, header.counts[3])?,
        };
        if rest.is_empty() { Ok(batch) } else { Err("a message is too long".to_owned()) }
    }
}

/// Takes so many items from the front of the bytes.
fn take<T: Pod>(bytes: &mut &[u8], count: u32) -> Result<Vec<T>, String> {
    let length = count as usize * size_of::<T>();
    let (items, rest) = bytes.split_at_checked(length).ok_or("a message is too short")?;
    *bytes = rest;
    Ok(items.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch() -> Batch {
        let now = Aabb::new([1.0; 3], [2.0; 3]);
        let newcomer = Newcomer { key: 5, now, before: NOWHERE };
        let change = Change { key: u64::MAX, now };
        Batch {
            owned: vec![newcomer; 2],
            entered: vec![newcomer],
            moved: vec![change; 3],
            left: vec![change],
        }
    }

    #[test]
    fn what_is_said_is_heard() {
        let bytes = batch().encode(VERSION, 7);
        assert_eq!(Batch::decode(&bytes, VERSION, 7), Ok(batch()));
        assert_eq!(bytes.len() as u64, batch().needed() + 32);
        // Messages come at any address.
        let mut shifted = vec![0];
        shifted.extend_from_slice(&bytes);
        assert_eq!(Batch::decode(&shifted[1..], VERSION, 7), Ok(batch()));
    }

    #[test]
    fn other_bytes_are_refused() {
        let bytes = batch().encode(VERSION, 7);
        for length in 0..bytes.len() {
            assert!(Batch::decode(&bytes[..length], VERSION, 7).is_err());
        }
        let longer = [bytes.as_slice(), &[0]].concat();
        assert!(Batch::decode(&longer, VERSION, 7).is_err());
        assert!(Batch::decode(&bytes, VERSION + 1, 7).unwrap_err().contains("version"));
        assert!(Batch::decode(&bytes, VERSION, 8).unwrap_err().contains("step"));
    }

    #[test]
    fn an_object_that_is_nowhere_overlaps_nothing() {
        let all = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        assert!(!NOWHERE.is_valid() && !NOWHERE.overlaps(&all) && !NOWHERE.overlaps(&NOWHERE));
    }
}
