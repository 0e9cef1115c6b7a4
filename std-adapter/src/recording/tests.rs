use super::*;
use crate::{Aabb, Boxes};
use std::io::{Cursor, Seek, SeekFrom};

fn header(count: u32, frames: u32) -> Header {
    let world = Aabb::new([-1.5, -2.5, -3.5], [1.5, 2.5, 3.5]);
    Header { scene: "Brownian".into(), objects: "Cubes".into(), count, frames, world }
}

fn box_at(frame: u32, object: u32) -> Aabb {
    let low = [frame as f32, object as f32, -0.25];
    Aabb::new(low, low.map(|x| x + 1.0))
}

fn written(count: u32, frames: u32) -> Vec<u8> {
    let mut writer = Writer::new(Vec::new(), header(count, frames)).expect("a good header");
    for frame in 0..frames {
        let boxes: Vec<_> = (0..count).map(|object| box_at(frame, object)).collect();
        writer.write_frame(Boxes::new(&boxes)).expect("a good frame");
    }
    writer.finish().expect("all frames")
}

/// A header with these counts in front of `rest` bytes.
fn with_counts(count: i32, frames: i32, rest: usize) -> Vec<u8> {
    let mut bytes = written(1, 1);
    bytes[256..260].copy_from_slice(&count.to_le_bytes());
    bytes[260..264].copy_from_slice(&frames.to_le_bytes());
    bytes.resize(304 + rest, 0);
    bytes
}

#[test]
fn what_is_written_is_read() {
    let bytes = written(3, 4);
    assert_eq!(bytes.len(), 304 + 3 * 4 * 32);
    let recording = Recording::parse(&bytes).expect("a good recording");
    assert_eq!(*recording.header(), header(3, 4));
    assert_eq!(recording.frames().len(), 4);
    for (k, frame) in (0..).zip(recording.frames()) {
        let boxes = Boxes::padded(frame);
        assert!((0..3).all(|object| boxes.get(object as usize) == Some(box_at(k, object))));
    }
    assert_eq!(recording.frame(2), recording.frames().nth(2));
    assert_eq!(recording.frame(4), None);
}

#[test]
fn bytes_are_where_broadmark_has_them() {
    let bytes = written(2, 3);
    assert_eq!(&bytes[..9], b"Brownian\0");
    assert_eq!(&bytes[128..134], b"Cubes\0");
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    assert_eq!([256, 260, 264, 268].map(|at| i32::from_le_bytes(word(at))), [2, 2, 0, 0]);
    let floats = |at: usize| [0, 4, 8, 12].map(|k| f32::from_le_bytes(word(at + k)));
    assert_eq!((floats(272), floats(288)), ([-1.5, -2.5, -3.5, 0.0], [1.5, 2.5, 3.5, 0.0]));
    // The second box of the second frame.
    let second = 304 + 2 * 32 + 32;
    assert_eq!((floats(second), floats(second + 16)), ([1.0, 1.0, -0.25, 0.0], [2.0, 2.0, 0.75, 0.0]));
}

#[test]
fn frame_by_frame_and_again() {
    let bytes = written(3, 4);
    let whole = Recording::parse(&bytes).expect("a good recording");
    // A recording may stand behind something else.
    let mut file = Cursor::new([b"something else".as_slice(), &bytes].concat());
    file.seek(SeekFrom::Start(14)).expect("in memory");
    let mut reader = Reader::new(file).expect("a good recording");
    for _ in 0..2 {
        for frame in whole.frames() {
            assert_eq!(reader.next_frame().expect("a frame"), Some(frame));
        }
        assert_eq!(reader.next_frame().expect("the end"), None);
        assert_eq!(reader.next_frame().expect("the end"), None);
        reader.rewind().expect("in memory");
    }
}

#[test]
fn every_cut_is_an_error() {
    let bytes = written(2, 2);
    for length in 0..bytes.len() {
        let found = length as u64;
        match Recording::parse(&bytes[..length]).unwrap_err() {
            Error::NoHeader { found: told } => assert!(length < 304 && told == found),
            Error::Truncated { needed, found: told } => {
                assert!(length >= 304 && told == found && needed == bytes.len() as u64);
            }
            other => panic!("{length}: {other}"),
        }
    }
}

#[test]
fn bytes_behind_the_end_are_an_error() {
    let mut bytes = written(2, 2);
    bytes.push(0);
    let error = Recording::parse(&bytes).unwrap_err();
    assert!(matches!(error, Error::TrailingBytes { needed: 432, found: 433 }), "{error}");
}

#[test]
fn counts_that_make_no_sense_are_an_error() {
    for (count, frames) in [(0, 0), (-1, 3), (i32::MIN, 0), (1, -1), (1, i32::MIN), (0, -7)] {
        let error = Recording::parse(&with_counts(count, frames, 32)).unwrap_err();
        assert!(
            matches!(error, Error::BadCounts { objects, frames: f } if objects == count && f == frames),
            "{error}"
        );
    }
}

#[test]
fn absurd_counts_allocate_nothing() {
    // The last one is more than 64 bits can count.
    for (count, frames) in [(i32::MAX, 0), (1, i32::MAX), (1 << 20, 1 << 20), (i32::MAX, i32::MAX)] {
        let error = Recording::parse(&with_counts(count, frames, 4096)).unwrap_err();
        assert!(matches!(error, Error::Truncated { found: 4400, .. }), "{error}");
    }
}

#[test]
fn what_is_no_recording_is_told_so() {
    let text = "Dear reader, this is a letter. ".repeat(100);
    let error = Recording::parse(text.as_bytes()).unwrap_err();
    assert!(error.to_string().contains("not a recording"), "{error}");
    assert!(matches!(Recording::open("no such file").unwrap_err(), Error::Io(_)));
}

#[test]
fn names_may_be_any_bytes() {
    let mut bytes = written(1, 1);
    bytes[..128].fill(0xff);
    let scene = Recording::parse(&bytes).expect("a good recording").header().scene.clone();
    assert_eq!(scene, "\u{fffd}".repeat(128));
}

#[test]
fn headers_that_do_not_fit_are_not_written() {
    let long = Header { scene: "x".repeat(128), ..header(1, 1) };
    let zero = Header { objects: "a\0b".into(), ..header(1, 1) };
    for bad in [long, zero, header(0, 1), header(1, 0), header(u32::MAX, 1), header(1, u32::MAX)] {
        assert!(matches!(Writer::new(Vec::new(), bad).unwrap_err(), Error::BadHeader));
    }
    assert!(Writer::new(Vec::new(), Header { scene: "x".repeat(127), ..header(1, 1 << 31) }).is_ok());
}

#[test]
fn the_writer_counts() {
    let boxes = [box_at(0, 0); 3];
    let mut writer = Writer::new(Vec::new(), header(2, 1)).expect("a good header");
    let error = writer.write_frame(Boxes::new(&boxes)).unwrap_err();
    assert!(matches!(error, Error::WrongBoxCount { needed: 2, found: 3 }), "{error}");
    writer.write_frame(Boxes::new(&boxes[..2])).expect("the first frame");
    let error = writer.write_frame(Boxes::new(&boxes[..2])).unwrap_err();
    assert!(matches!(error, Error::WrongFrameCount { needed: 1, found: 2 }), "{error}");
    writer.finish().expect("all frames");

    let error = Writer::new(Vec::new(), header(2, 1)).expect("a good header").finish().unwrap_err();
    assert!(matches!(error, Error::WrongFrameCount { needed: 1, found: 0 }), "{error}");
}
