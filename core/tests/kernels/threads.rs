//! Blocks that are claimed once, and slices that several workers fill.

use super::block_queue::{BlockQueue, Chunks};
use super::shared::Shared;

#[test]
fn every_part_is_claimed_once() {
    let (mut a, mut b) = ([0u8; 10], [0u16; 4]);
    let queue = BlockQueue::new((Chunks::new(&mut a, 3), Chunks::new(&mut b, 1)), 1);
    while let Some((index, (a, b))) = queue.claim_from(&mut 0) {
        a.fill(index as u8 + 1);
        b.fill(index as u16 + 1);
    }
    assert!(queue.claim_from(&mut 0).is_none());
    assert_eq!(a, [1, 1, 1, 2, 2, 2, 3, 3, 3, 4]);
    assert_eq!(b, [1, 2, 3, 4]);
}

#[test]
fn every_part_of_all_shares_is_claimed_once() {
    for (workers, len) in [(0, 7), (1, 7), (2, 7), (3, 2), (3, 10), (9, 20), (2, 0)] {
        let mut items = [0u8; 20];
        let queue = BlockQueue::new(Chunks::new(&mut items[..len], 1), workers);
        let mut shares = [(); 3].map(|()| queue.arrive());
        let mut order = std::vec::Vec::new();
        'all: loop {
            for share in &mut shares {
                let Some((index, item)) = queue.claim_from(share) else { break 'all };
                item.iter_mut().for_each(|item| *item += 1);
                order.push(index);
            }
        }
        assert_eq!(order.len(), len);
        assert!(items[..len].iter().all(|item| *item == 1));
        match (workers, len) {
            (2, 7) => assert_eq!(order, [0, 3, 1, 2, 4, 5, 6]),
            (1, _) => assert!(order.is_sorted()),
            _ => {}
        }
    }
}

/// Small enough for Miri with many seeds. `tests/loom` tries all interleavings.
#[test]
fn threads_share_blocks_and_scratch() {
    let (mut items, mut sums) = ([0u32; 23], [0u32; 2]);
    let queue = BlockQueue::new(Chunks::new(&mut items, 4), 1);
    let areas = BlockQueue::new(Chunks::new(&mut sums, 1), 1);
    let job = || {
        // More calls than areas: some leave the work to others.
        let Some((_, area)) = areas.claim_from(&mut 0) else { return };
        while let Some((block, items)) = queue.claim_from(&mut 0) {
            items.iter_mut().for_each(|item| *item += block as u32 + 1);
            area[0] += 1;
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(job);
        }
        job();
    });
    job();
    assert!(queue.claim_from(&mut 0).is_none());
    assert!(items.iter().enumerate().all(|(at, &item)| item as usize == at / 4 + 1));
    assert_eq!(sums.iter().sum::<u32>(), 6);
}

#[test]
fn stores_land_where_they_should() {
    let mut items = [[0u64; 2]; 3];
    let shared = Shared::new(&mut items);
    shared.store(2, &[5, 6]);
    shared.store(0, &[1, 2]);
    assert_eq!(items, [[1, 2], [0, 0], [5, 6]]);
}

/// Small enough for Miri with many seeds.
#[test]
fn threads_fill_one_slice() {
    let mut items = [[0u64; 2]; 12];
    let shared = &Shared::new(&mut items);
    std::thread::scope(|scope| {
        for worker in 0..3 {
            let slots = (worker..12).step_by(3);
            scope.spawn(move || slots.for_each(|slot| shared.store(slot, &[slot as u64, worker as u64])));
        }
    });
    assert!(items.iter().enumerate().all(|(slot, item)| *item == [slot as u64, slot as u64 % 3]));
}
