//! Filters, classes and the rule.

use super::draw;
use super::format::Operation;
use super::life::Life;
use trisap_core::{Error, Filter, Index};

pub(super) fn good(filter: Filter) -> Result<(), Error> {
    if filter.class < 32 { Ok(()) } else { Err(Error::BadClass { class: filter.class }) }
}

impl<I: Index> Life<'_, '_, I> {
    pub(super) fn has_filters(&self) -> Result<(), Error> {
        if self.past.config.filters { Ok(()) } else { Err(Error::NoFilters) }
    }

    pub(super) fn set_filter(&mut self, op: &mut Operation) {
        let Some(id) = self.any(op) else { return };
        let filter = draw::filter(&mut op.rng);
        let expected = self.stale(id).and(self.has_filters()).and(good(filter));
        assert_eq!(self.both(|world| world.set_filter(id, filter)), expected);
        if expected.is_ok() {
            self.model().set_filter(id, filter);
        }
    }

    /// One call in C. All get the same filter, or each its own; the core has a call for one.
    pub(super) fn set_filter_many(&mut self, op: &mut Operation) {
        let ids = self.some(op);
        let same = op.argument & 4 == 0;
        let mut filter = draw::filter(&mut op.rng);
        let mut filters = Vec::new();
        for _ in &ids {
            filters.push(filter);
            if !same {
                filter = draw::filter(&mut op.rng);
            }
        }
        let one = |at: usize| self.stale(ids[at]).and(good(filters[at]));
        let named = (0..ids.len()).try_for_each(one);
        let expected = named.and(if ids.is_empty() { Ok(()) } else { self.has_filters() });
        let said = self.both(|world| {
            named?;
            ids.iter().zip(&filters).try_for_each(|(id, filter)| world.set_filter(*id, *filter))
        });
        assert_eq!(said, expected);
        if expected.is_ok() {
            ids.iter().zip(filters).for_each(|(id, filter)| self.model().set_filter(*id, filter));
        }
    }

    pub(super) fn set_classes(&mut self, op: &mut Operation) {
        let mut meets = [u32::MAX; 32];
        meets[op.rng.below(3)] = op.rng.bits() as u32;
        let expected = self.has_filters();
        assert_eq!(self.both(|world| world.set_classes(&meets)), expected);
        if expected.is_ok() {
            self.model().set_classes(&meets);
        }
    }

    pub(super) fn refilter(&mut self, op: &mut Operation) {
        let Some(id) = self.any(op) else { return };
        let expected = self.stale(id).and(self.has_filters());
        assert_eq!(self.both(|world| world.refilter(id)), expected);
        if expected.is_ok() {
            let opinion = op.argument as u32 % 3;
            self.model().set_opinion(id, opinion);
        }
    }
}
