//! Small builds against brute force, for each set of features that `run.sh` names: pairs, events and filters while objects come,
//! move, rest in the same place and go; and what a build lacks is refused.

use std::collections::BTreeSet;
use trisap_core::{Aabb, Capacity, Config, Error, Filter, Id, InlineWorld, Margin, layout};

const OBJECTS: usize = 48;
const PLAIN: Config = Config::new(Capacity::for_objects(OBJECTS as u32).with_pairs(2000));
const BYTES: usize = 64 * 1024;

/// Numbers below a limit, by a linear congruence.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) % limit
    }

    fn aabb(&mut self) -> Aabb {
        let min = [30, 8, 30].map(|side| self.below(side) as f32);
        Aabb::new(min, min.map(|low| low + self.below(6) as f32))
    }
}

/// All combinations of what this build has.
fn configs() -> Vec<Config> {
    let mut all = vec![PLAIN];
    let mut add = |has: bool, with: fn(Config) -> Config| {
        if has {
            all.extend(all.clone().into_iter().map(with));
        } else {
            // A constant configuration of a program would not compile.
            assert_eq!(layout::<u16>(&with(PLAIN)), None);
        }
    };
    add(cfg!(feature = "events"), Config::with_events);
    add(cfg!(feature = "margins"), |config| config.with_margin(Margin::length(0.5)));
    add(cfg!(feature = "filters"), Config::with_filters);
    add(cfg!(feature = "values"), Config::with_values);
    all
}

/// Fat boxes spare work on a tree, which these builds do not have. They took 24 bytes an object, and twice the instructions.
#[test]
fn exact_worlds_have_no_fat_boxes() {
    if cfg!(feature = "margins") {
        let [with, without] = [PLAIN.with_margin(Margin::length(0.5)), PLAIN]
            .map(|config| layout::<u16>(&config).unwrap().bytes);
        assert!(with <= without + OBJECTS * size_of::<f32>(), "{with} bytes instead of {without}");
    }
}

#[test]
fn small_builds_find_what_brute_force_finds() -> Result<(), Error> {
    for config in configs() {
        let mut memory = Box::new(InlineWorld::<BYTES>::EMPTY);
        let mut world = memory.init::<u16>(&config)?;
        let mut random = Random(7);
        let mut objects: Vec<Option<(Id, Aabb, u32)>> = vec![None; OBJECTS];
        let mut before = BTreeSet::new();
        for step in 0..300 {
            let changes = if step % 5 == 0 { random.below(40) } else { random.below(6) };
            for _ in 0..changes {
                let at = random.below(OBJECTS as u64) as usize;
                match &mut objects[at] {
                    Some((id, aabb, _)) if random.below(4) > 0 => {
                        *aabb = random.aabb();
                        world.set_aabb(*id, *aabb)?;
                    }
                    Some((id, ..)) => {
                        world.remove(*id)?;
                        objects[at] = None;
                    }
                    None => {
                        let (aabb, group) = (random.aabb(), 1 + random.below(3) as u32);
                        let id = world.insert(aabb)?;
                        if config.filters {
                            world.set_filter(id, Filter::groups(group, group))?;
                        }
                        objects[at] = Some((id, aabb, if config.filters { group } else { 1 }));
                    }
                }
            }
            let living: Vec<_> = objects.iter().flatten().collect();
            let mut expected = BTreeSet::new();
            for (index, (a, of_a, group_a)) in living.iter().enumerate() {
                for (b, of_b, group_b) in &living[index + 1..] {
                    if of_a.overlaps(of_b) && group_a & group_b != 0 {
                        expected.insert(BTreeSet::from([a.to_bits(), b.to_bits()]));
                    }
                }
            }
            let set = |pairs: &mut dyn Iterator<Item = [Id; 2]>| -> BTreeSet<_> {
                let mut count = 0;
                let set: BTreeSet<BTreeSet<_>> =
                    pairs.inspect(|_| count += 1).map(|pair| BTreeSet::from(pair.map(Id::to_bits))).collect();
                assert_eq!(set.len(), count, "a pair comes twice");
                set
            };
            let found = world.step()?;
            assert_eq!(set(&mut found.pair_ids()), expected, "step {step} of {config:?}");
            if config.events {
                let told = [set(&mut found.found_ids()), set(&mut found.lost_ids())];
                assert_eq!(told, [&expected - &before, &before - &expected], "step {step} of {config:?}");
            }
            #[cfg(feature = "validate")]
            world.validate().expect("a world as it should be");
            before = expected;
        }
    }
    Ok(())
}
