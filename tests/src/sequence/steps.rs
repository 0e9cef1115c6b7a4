//! Steps, of the world and of its twin.

use super::format::Operation;
use super::life::Life;
use crate::checked::{Outcome, slots};
use crate::doing::On as _;
use crate::jobs::Jobs;
use crate::worlds::Setup;
use trisap_core::{Aabb, Boxes, Error, Index, Kernels};

impl<I: Index> Life<'_, '_, I> {
    /// What the twin runs on. Threads are seldom started, as that takes its time.
    pub(super) fn setup(&self, op: &Operation) -> Setup {
        const CALLS: [Jobs; 4] = [Jobs::Never, Jobs::Twice, Jobs::Often, Jobs::Serial];
        const THREADS: [Jobs; 4] = [Jobs::Threads(2), Jobs::Crowd, Jobs::Few, Jobs::Late];
        let kernels = self.past.kernels[op.argument % self.past.kernels.len()];
        let jobs = if op.argument < 4 { THREADS[op.argument] } else { CALLS[op.argument / 8 % 4] };
        Setup { kernels, jobs }
    }

    pub(super) fn step(&mut self, op: &Operation) {
        let said = self.checked.try_step(Setup::REFERENCE);
        self.follow(op, None, &said);
    }

    /// The trees are brought up to date, with what the twin steps on.
    pub(super) fn refresh(&mut self, op: &Operation) {
        let Setup { kernels, jobs } = self.setup(op);
        assert_eq!(self.checked.world_mut().set_kernels(Kernels::SCALAR).refresh(), Ok(()));
        assert_eq!(self.twin.set_kernels(kernels).on(&jobs).refresh(), Ok(()));
        self.twin.validate().expect("a valid twin");
        self.checked.check();
        self.past.tally.refreshed += 1;
    }

    /// Over an array as long as there are slots, or shorter, or longer. Where nobody is stands what is no box.
    pub(super) fn step_over(&mut self, op: &mut Operation) {
        let objects = self.objects();
        let length = [objects, objects, objects, objects / 2, objects + 2][op.argument % 5];
        let movers = [1, 4, 12, 32][op.argument / 64];
        let some_are_bad = op.argument & 4 != 0;
        let none = Aabb::new([f32::NAN; 3], [f32::NAN; 3]);
        let boxes: Vec<Aabb> = (0..length)
            .map(|slot| {
                let Some(id) = self.checked.world().id_at(slot) else { return none };
                match op.rng.below(32) {
                    0 if some_are_bad => none,
                    k if k < movers => self.moved(id, op),
                    _ => self.checked.world().aabb(id).expect("alive"),
                }
            })
            .collect();
        let said = self.checked.try_step_over(&boxes, Setup::REFERENCE);
        self.follow(op, Some(&boxes), &said);
    }

    /// The twin does the same step and says the same.
    fn follow(&mut self, op: &Operation, boxes: Option<&[Aabb]>, said: &Result<Outcome, Error>) {
        let told = self.twin_step(op, boxes);
        assert_eq!(told.is_ok(), said.is_ok(), "the twin");
        assert!(told == *said, "the twin says {told:?}, not {said:?}");
        let world = self.checked.world();
        assert_eq!(world.stats(), self.twin.stats());
        assert_eq!(world.pairs(), self.twin.pairs());
        self.twin.validate().expect("a valid twin");
        self.past.tally.step(said, &slots(world.pairs()));
    }

    pub(super) fn twin_step(&mut self, op: &Operation, boxes: Option<&[Aabb]>) -> Result<Outcome, Error> {
        let setup = self.setup(op);
        let model = self.checked.model();
        let rule = |a, b| model.agree(a, b);
        let mut stepper = self.twin.under(&setup);
        if model.has_rule() {
            stepper = stepper.with_rule(&rule);
        }
        let step = match boxes.map(Boxes::new) {
            Some(boxes) => stepper.step_over(boxes),
            None => stepper.step(),
        };
        step.map(|step| Outcome::of(&step))
    }
}
