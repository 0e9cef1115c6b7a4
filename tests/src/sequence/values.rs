//! Values of objects.

use super::format::Operation;
use super::life::Life;
use trisap_core::{Error, Id, Index};

impl<I: Index> Life<'_, '_, I> {
    pub(super) fn has_values(&self) -> Result<(), Error> {
        if self.past.config.values { Ok(()) } else { Err(Error::NoValues) }
    }

    /// Gives a new object a value that no other one has; one in four keeps that of a new one.
    pub(super) fn name(&mut self, id: Id) {
        if self.past.config.values && id.slot() % 4 != 3 {
            let value = !id.to_bits();
            self.both(|world| world.set_value(id, value)).expect("a living object in a world with values");
            self.model().set_value(id, value);
        }
    }

    pub(super) fn set_value(&mut self, op: &mut Operation) {
        let Some(id) = self.any(op) else { return };
        let value = op.rng.bits();
        let expected = self.stale(id).and(self.has_values());
        assert_eq!(self.both(|world| world.set_value(id, value)), expected);
        if expected.is_ok() {
            self.model().set_value(id, value);
        }
    }

    /// One call in C. All get the same value, or each its own; the core has a call for one.
    pub(super) fn set_value_many(&mut self, op: &mut Operation) {
        let ids = self.some(op);
        let mut value = op.rng.bits();
        let mut values = Vec::new();
        for _ in &ids {
            values.push(value);
            if op.argument & 8 != 0 {
                value = op.rng.bits();
            }
        }
        let expected = ids.iter().try_for_each(|id| self.stale(*id).and(self.has_values()));
        let said = self.both(|world| {
            expected?;
            ids.iter().zip(&values).try_for_each(|(id, value)| world.set_value(*id, *value))
        });
        assert_eq!(said, expected);
        if expected.is_ok() {
            ids.iter().zip(values).for_each(|(id, value)| self.model().set_value(*id, value));
        }
    }
}
