//! The method of the paper that trisap started from, as it is printed.

use super::{Crowd, Entry, Output, Peer};
use crate::recording::Padded;
use trisap_paper::{Aabb, Settings, World};

pub(crate) fn entry() -> Entry {
    Entry {
        name: "Cao and Wang, as printed",
        setup: "tests/paper: three linked lists, insertion sort, KD-tree, leaves of 64, sweep by axes; scalar; errata corrected",
        events: false,
        fat: false,
        parallel: false,
        crowd: Crowd::Unsuited,
        start: Ok(|setting| {
            let boxes: Vec<Aabb> = setting.boxes.iter().map(aabb).collect();
            Box::new(Paper { world: World::new(boxes.len(), Settings::default()), boxes })
        }),
    }
}

struct Paper {
    world: World,
    boxes: Vec<Aabb>,
}

fn aabb(b: &Padded) -> Aabb {
    Aabb::new([b[0], b[1], b[2]], [b[4], b[5], b[6]])
}

impl Peer for Paper {
    fn prepare(&mut self, boxes: &[Padded]) {
        self.boxes.iter_mut().zip(boxes).for_each(|(to, from)| *to = aabb(from));
    }

    fn frame(&mut self) {
        self.world.step(&self.boxes);
    }

    fn output(&mut self) -> Output<'_> {
        Output::Pairs(self.world.pairs())
    }
}
