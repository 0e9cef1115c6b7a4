//! One world with all boxes, to compare with.

use crate::source::Frame;
use std::collections::HashMap;
use std::error::Error;
use trisap::{Capacity, Config, Id, OwnedWorld};
use trisap_mpi::{KeyPair, SplitWorld};

/// The pairs of all objects in one world.
pub(crate) struct Reference {
    world: OwnedWorld<u32>,
    ids: HashMap<u64, Id>,
    /// Keys by slot, as they are and as they were in the last step.
    keys: Vec<u64>,
    keys_before: Vec<u64>,
}

/// Sorted pairs, found and lost.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Answer {
    pairs: Vec<KeyPair>,
    found: Vec<KeyPair>,
    lost: Vec<KeyPair>,
}

impl Reference {
    pub(crate) fn new(objects: u32) -> Result<Self, Box<dyn Error>> {
        let all = u64::from(objects) * u64::from(objects.max(1) - 1) / 2;
        let pairs = all.min((u64::from(objects) * 32).max(5_000_000)) as u32;
        let config = Config::new(Capacity::for_objects(objects).with_pairs(pairs)).with_events();
        Ok(Self {
            world: OwnedWorld::new(&config)?,
            ids: HashMap::new(),
            keys: vec![0; objects as usize],
            keys_before: Vec::new(),
        })
    }

    pub(crate) fn step(&mut self, frame: &Frame) -> Result<Answer, Box<dyn Error>> {
        let mut world = self.world.world();
        self.keys_before.clone_from(&self.keys);
        for key in &frame.gone {
            world.remove(self.ids.remove(key).ok_or("the scene removes what is not there")?)?;
        }
        for (key, id) in &self.ids {
            world.set_aabb(*id, frame.boxes[*key as usize])?;
        }
        for key in &frame.come {
            let id = world.insert(frame.boxes[*key as usize])?;
            self.keys[id.slot() as usize] = *key;
            self.ids.insert(*key, id);
        }
        let step = world.step()?;
        Ok(Answer {
            pairs: sorted(step.pairs(), &self.keys),
            found: sorted(step.found(), &self.keys),
            lost: sorted(step.lost(), &self.keys_before),
        })
    }
}

fn sorted(pairs: &[[u32; 2]], keys: &[u64]) -> Vec<KeyPair> {
    let by_key = |[a, b]: &[u32; 2]| {
        let [a, b] = [a, b].map(|slot| keys[*slot as usize]);
        [a.min(b), a.max(b)]
    };
    let mut pairs: Vec<_> = pairs.iter().map(by_key).collect();
    pairs.sort_unstable();
    pairs
}

/// What all ranks say, on the first one.
pub(crate) fn answer(world: &mut SplitWorld) -> Result<Answer, String> {
    let mut pairs = Vec::new();
    world.visit_pairs(|pair| pairs.push(pair));
    let at_owners = world.send_to_owners(&pairs);
    if let Some(pair) = at_owners.iter().find(|pair| !world.owns(pair[0])) {
        return Err(format!("rank {} does not own {} of {pair:?}", world.rank(), pair[0]));
    }
    if let Some((key, aabb)) = world.owned().find(|(_, aabb)| world.rank_of(aabb.min) != world.rank()) {
        return Err(format!("rank {} owns {key} with {aabb:?}", world.rank()));
    }
    let mut answer = Answer {
        pairs: world.gather(&pairs, 0),
        found: world.gather(world.found(), 0),
        lost: world.gather(world.lost(), 0),
    };
    let mut again = world.gather(&at_owners, 0);
    for list in [&mut answer.pairs, &mut answer.found, &mut answer.lost, &mut again] {
        list.sort_unstable();
    }
    if again == answer.pairs { Ok(answer) } else { Err("pairs at the owners are others".to_owned()) }
}

impl Answer {
    /// Where another answer is not the same.
    pub(crate) fn difference(&self, other: &Self) -> Option<String> {
        let lists = [
            ("pairs", &self.pairs, &other.pairs),
            ("found", &self.found, &other.found),
            ("lost", &self.lost, &other.lost),
        ];
        lists.into_iter().find_map(|(name, a, b)| {
            let at = (0..a.len().max(b.len())).find(|&at| a.get(at) != b.get(at))?;
            Some(format!("{name}: {} and not {}; {:?} and not {:?}", a.len(), b.len(), a.get(at), b.get(at)))
        })
    }

    /// Pairs, found and lost.
    pub(crate) fn counts(&self) -> [u64; 3] {
        [&self.pairs, &self.found, &self.lost].map(|list| list.len() as u64)
    }
}
