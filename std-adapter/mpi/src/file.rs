//! Saving what a rank owns, and loading it on any number of ranks.

use crate::exchange::Exchange;
use crate::fault::Fault;
use crate::message::{Change, VERSION};
use crate::settings::Settings;
use crate::table::Object;
use crate::world::SplitWorld;
use bytemuck::{Pod, Zeroable};
use mpi::topology::SimpleCommunicator;
use std::io::{Read, Write};
use trisap::{Executor, Kernels};

const MAGIC: u32 = u32::from_le_bytes(*b"TSMF");

/// The start of a file.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Header {
    magic: u32,
    version: u32,
    rank: u32,
    /// How many files there are.
    ranks: u32,
    step: u64,
    /// Objects in this file.
    count: u64,
    /// Of the bytes after the header.
    checksum: u64,
}

impl SplitWorld {
    /// Writes the objects that this rank owns with their boxes of the last step. Each rank has to write a file of its own, all
    /// after the same step. What has been given, moved or removed since is not in it, except that a removed object is
    /// missing: so save after a step, before anything else.
    ///
    /// # Errors
    /// [`Fault::Io`].
    pub fn save(&self, mut to: impl Write) -> Result<(), Fault> {
        let table = &self.local.table;
        let objects = table.owned_slots().map(|slot| table.get(slot));
        let items: Vec<_> = objects.map(|object| Change { key: object.key, now: object.before }).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&items);
        let header = Header {
            magic: MAGIC,
            version: VERSION,
            rank: self.rank() as u32,
            ranks: self.ranks() as u32,
            step: self.step,
            count: items.len() as u64,
            checksum: checksum(bytes),
        };
        to.write_all(bytemuck::bytes_of(&header))?;
        to.write_all(bytes)?;
        to.flush()?;
        Ok(())
    }

    /// The world that was saved, on any number of ranks: each rank reads any of the files, and all together read each file once.
    /// The objects go to their ranks in a step that finds and loses nothing, so that the next step finds and loses what it would
    /// have without saving.
    ///
    /// # Errors
    /// [`Fault::Io`], [`Fault::BadFile`], [`Fault::OtherRank`] or [`Fault::FilesDiffer`], and the errors of
    /// [`new`](Self::new).
    pub fn load<R: Read>(
        comm: &SimpleCommunicator,
        settings: &Settings,
        files: impl IntoIterator<Item = R>,
        kernels: Kernels,
        executor: &dyn Executor,
    ) -> Result<Self, Fault> {
        let mut world = Self::new(comm, settings)?;
        let read: Result<Vec<_>, Fault> = files.into_iter().map(read).collect();
        let given = read.and_then(|files| {
            let mut headers = Vec::new();
            for (header, objects) in files {
                headers.push(header);
                for object in objects {
                    world.give(object)?;
                }
            }
            Ok(headers)
        });
        let (headers, fault) = match given {
            Ok(headers) => (headers, None),
            Err(fault) => (Vec::new(), Some(fault)),
        };
        if world.exchange.sum(&[u64::from(fault.is_some())])[0] > 0 {
            return Err(fault.unwrap_or(Fault::OtherRank));
        }
        world.step = agree(&headers, &world.exchange).ok_or(Fault::FilesDiffer)?;
        world.step(kernels, executor)?;
        Ok(world)
    }
}

/// The step of all files, if they are those of one saved world.
fn agree(headers: &[Header], exchange: &Exchange) -> Option<u64> {
    let highest = |number: fn(&Header) -> u64| headers.iter().map(number).max().unwrap_or(0);
    let ends = exchange.highest(&[
        highest(|header| header.step),
        highest(|header| u64::MAX - header.step),
        highest(|header| header.ranks.into()),
        highest(|header| u64::MAX - u64::from(header.ranks)),
    ]);
    if ends[0] != u64::MAX - ends[1] || ends[2] != u64::MAX - ends[3] {
        return None;
    }
    let mut times = vec![0; ends[2] as usize];
    for header in headers {
        *times.get_mut(header.rank as usize)? += 1;
    }
    exchange.sum(&times).iter().all(|&times| times == 1).then_some(ends[0])
}

/// What a file holds.
fn read(mut from: impl Read) -> Result<(Header, Vec<Object>), Fault> {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes)?;
    let short = Fault::BadFile("the file is shorter than its header");
    let (header, rest) = bytes.split_at_checked(size_of::<Header>()).ok_or(short)?;
    let header: Header = bytemuck::pod_read_unaligned(header);
    if header.magic != MAGIC {
        return Err(Fault::BadFile("the file is none that a rank has saved"));
    }
    if header.version != VERSION {
        return Err(Fault::BadFile("the file is of another version"));
    }
    if header.rank >= header.ranks
        || header.count.checked_mul(size_of::<Change>() as u64) != Some(rest.len() as u64)
        || header.checksum != checksum(rest)
    {
        return Err(Fault::BadFile("the file has changed since it was saved"));
    }
    let items = rest.chunks_exact(size_of::<Change>()).map(bytemuck::pod_read_unaligned);
    let objects = items.map(|Change { key, now }| Object { key, now, before: now }).collect();
    Ok((header, objects))
}

/// Any changed byte changes it.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.chunks(8).fold(bytes.len() as u64, |sum, part| {
        let mut word = [0; 8];
        word[..part.len()].copy_from_slice(part);
        (sum ^ u64::from_ne_bytes(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap::Aabb;

    #[test]
    fn changed_files_are_refused() {
        let items = [3, 4].map(|key| Change { key, now: Aabb::new([0.0; 3], [1.0; 3]) });
        let bytes: &[u8] = bytemuck::cast_slice(&items);
        let header = Header {
            magic: MAGIC,
            version: VERSION,
            rank: 0,
            ranks: 1,
            step: 5,
            count: 2,
            checksum: checksum(bytes),
        };
        let file = [bytemuck::bytes_of(&header), bytes].concat();
        assert_eq!(read(file.as_slice()).expect("good").1.len(), 2);
        for length in 0..file.len() {
            assert!(read(&file[..length]).is_err());
        }
        for at in (0..12).chain(size_of::<Header>() - 8..file.len()) {
            let mut other = file.clone();
            other[at] ^= 0x80;
            assert!(read(other.as_slice()).is_err(), "byte {at}");
        }
    }
}
