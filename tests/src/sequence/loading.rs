//! Snapshots: kept, loaded, damaged, forged.

use super::format::Operation;
use super::life::Life;
use crate::checked::Outcome;
use crate::doing::On as _;
use crate::forging::{forge, go_on};
use crate::lives::saved;
use crate::worlds::Setup;
use trisap_core::{Error, Index};

impl<I: Index> Life<'_, '_, I> {
    /// The twin's snapshot is the same.
    fn snapshot(&mut self) -> Vec<u8> {
        let bytes = saved(self.checked.world());
        assert!(bytes == saved(&self.twin), "the twin's snapshot");
        bytes
    }

    pub(super) fn save(&mut self, op: &Operation) {
        let save = self.checked.save();
        assert!(save.0 == self.snapshot(), "the same once more");
        self.past.tally.say(save.0.len() as u64);
        self.past.tally.say(u64::from_le_bytes(save.0[16..24].try_into().expect("the checksum")));
        self.past.saves[op.argument % 4] = Some(save);
    }

    pub(super) fn load(&mut self, op: &Operation) {
        let Some(save) = self.past.saves[op.argument % 4].take() else { return };
        let before = self.snapshot();
        match self.both(|world| world.load(&save.0)) {
            Ok(()) => {
                *self.checked.model_mut() = save.1.clone();
                self.past.tally.loaded += 1;
            }
            // It is of a world with more room.
            Err(Error::NoRoom { needed, room, .. }) => {
                assert!(needed > room);
                assert!(self.snapshot() == before, "a snapshot was refused and has changed the world");
            }
            Err(error) => panic!("a good snapshot: {error}"),
        }
        self.past.saves[op.argument % 4] = Some(save);
    }

    /// One bit is another, or the end is missing.
    pub(super) fn load_damaged(&mut self, op: &mut Operation) {
        let before = self.snapshot();
        let mut bytes = before.clone();
        let at = op.rng.below(bytes.len());
        if op.argument < 64 {
            bytes.truncate(at);
        } else {
            bytes[at] ^= 1 << (op.argument % 8);
        }
        assert_eq!(self.both(|world| world.load(&bytes)), Err(Error::BadSnapshot));
        assert!(self.snapshot() == before, "a snapshot was refused and has changed the world");
    }

    /// Refused with the world as it was, or as right as any world from then on.
    pub(super) fn load_forged(&mut self, op: &mut Operation) {
        let before = self.snapshot();
        let mut bytes = before.clone();
        forge(&mut bytes, &mut op.rng);
        if self.both(|world| world.load(&bytes)).is_err() {
            self.past.tally.forged_refused += 1;
            assert!(self.snapshot() == before, "a snapshot was refused and has changed the world");
            return;
        }
        self.past.tally.forged_loaded += 1;
        if !self.header.rule() {
            go_on(self.checked.world_mut(), &mut op.rng, Setup::REFERENCE, "forged");
            self.checked.world_mut().load(&bytes).expect("it was loaded before");
        }
        let setup = Setup::REFERENCE;
        let (world, model) = self.checked.parts_mut();
        let rule = |a, b| model.agree(a, b);
        let stepper = world.under(&setup);
        let step = if model.has_rule() { stepper.with_rule(&rule).step() } else { stepper.step() };
        let said = step.map(|step| Outcome::of(&step));
        let told = self.twin_step(op, None);
        assert!(told == said, "the twin says {told:?}, not {said:?}");
        self.past.tally.say_status(&said);
        if let Ok(outcome) = said {
            self.past.tally.say_pairs(&outcome.pairs);
            self.past.tally.say_pairs(&outcome.found);
            self.past.tally.say_pairs(&outcome.lost);
        }
        self.checked.world().validate().expect("a valid world");
        self.both(|world| world.load(&before)).expect("a good snapshot");
    }
}
