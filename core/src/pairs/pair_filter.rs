//! Asks filters and the caller's rule before a pair is written, so unwanted pairs take no room.

use crate::access::Access;
use crate::config::FILTERS;
use crate::filter::{Filter, Rule, all_meet, demand, may_meet, meet, offer};
use crate::id::{Index, Pair};
use crate::memory::slab::FilterParts;
use crate::memory::state::slot;
use crate::parallel::context::StepContext;
use crate::simd::kernels::run;

/// Decides which overlaps are pairs.
#[derive(Clone, Copy)]
pub(crate) struct PairFilter<'g> {
    /// By slot; none if all meet.
    pub(crate) filters: &'g [Filter],
    classes: &'g [u32],
    rule: Option<&'g Rule<'g>>,
}

impl<'g> PairFilter<'g> {
    /// The filters of a world, if it has any.
    pub(crate) fn new(parts: &'g FilterParts<'_>, rule: Option<&'g Rule<'g>>) -> Option<Self> {
        (FILTERS && !parts.of.is_empty()).then_some(Self { filters: parts.of, classes: parts.classes, rule })
    }

    /// As [`new`](Self::new), for a step that looks at all objects: `None` if every pair would pass. To look
    /// at each object once costs less than to look at two for each pair. The filters of living objects are
    /// among the first `slots`. O(slots).
    pub(crate) fn if_needed(
        parts: &'g FilterParts<'_>,
        slots: u32,
        context: &StepContext<'g>,
    ) -> Option<Self> {
        let filter = Self::new(parts, context.rule)?;
        let filters = parts.of.span(0, slots as usize);
        let all_meet = run!(context.kernels, |_simd| all_meet(filters, |class| parts.classes.at(class)));
        let filters = if all_meet { &[] } else { filter.filters };
        (!all_meet || filter.rule.is_some()).then_some(Self { filters, ..filter })
    }

    /// Whether there are filters that do not meet.
    pub(crate) const fn tells_apart(&self) -> bool {
        !self.filters.is_empty()
    }

    /// What the filter of an object looks for; `None` if all.
    pub(crate) fn demand(&self, slot: usize) -> Option<u32> {
        let filter = self.filters.at(slot);
        demand(&filter, self.classes.at(filter.class as usize))
    }

    /// Brings those of a list that may meet another one of it to the front, in order. Returns how many.
    pub(crate) fn leave_out(&self, list: &mut [i32]) -> usize {
        let offers = list.iter().fold(0, |all, word| all | offer(self.filters, slot(*word)));
        let mut count = 0;
        for at in 0..list.len() {
            if self.demand(slot(list.at(at))).is_none_or(|demand| may_meet(demand, offers)) {
                list.swap_at(at, count);
                count += 1;
            }
        }
        count
    }

    pub(crate) fn meet(&self, a: &Filter, b: &Filter) -> bool {
        meet(a, b, |class| self.classes.at(class))
    }

    /// Whether two objects make a pair.
    #[inline]
    pub(crate) fn lets_through<I: Index>(&self, pair: Pair<I>) -> bool {
        let filters = self.filters.get(pair[0].at()).zip(self.filters.get(pair[1].at()));
        !FILTERS
            || filters.is_none_or(|(a, b)| self.meet(a, b))
                && self.rule.is_none_or(|rule| rule(pair[0].slot(), pair[1].slot()))
    }
}
