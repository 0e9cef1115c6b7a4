//! Asks filters and the caller's rule before a pair is written, so unwanted pairs take no room.

use crate::access::Access;
use crate::filter::{FILTERS, Filter, Rule, all_meet, meet};
use crate::id::{Index, Pair};
use crate::memory::slab::FilterParts;
use crate::parallel::context::StepContext;
use crate::simd::{Phase, Simd};

/// Takes pairs.
pub(crate) trait Sink<I> {
    /// Appends pairs.
    fn take(&mut self, pairs: &mut [Pair<I>]);

    /// Whether more pairs are of no use.
    fn is_full(&self) -> bool {
        false
    }
}

/// Decides which overlaps are pairs.
#[derive(Clone, Copy)]
pub(crate) struct PairFilter<'g> {
    filters: &'g [Filter],
    classes: &'g [u32],
    rule: Option<&'g Rule<'g>>,
}

impl<'g> PairFilter<'g> {
    /// The filters of a world, if it has any.
    pub(crate) fn new(parts: &'g FilterParts<'_>, rule: Option<&'g Rule<'g>>) -> Option<Self> {
        (FILTERS && !parts.of.is_empty()).then_some(Self { filters: parts.of, classes: parts.classes, rule })
    }

    /// As [`new`](Self::new), for a step that looks at all objects: `None` if every pair would pass. To look at each
    /// object once costs less than to look at two for each pair. The filters of living objects are among the first
    /// `slots`. O(slots).
    pub(crate) fn if_needed(
        parts: &'g FilterParts<'_>,
        slots: u32,
        context: &StepContext<'g>,
    ) -> Option<Self> {
        let all_meet = || {
            let filters = parts.of.span(0, slots as usize);
            context.kernels.run(AllMeet { filters, classes: parts.classes })
        };
        Self::new(parts, context.rule).filter(|_| context.rule.is_some() || !all_meet())
    }

    /// Whether two objects make a pair.
    #[inline]
    pub(crate) fn lets_through<I: Index>(&self, pair: &Pair<I>) -> bool {
        if !FILTERS {
            return true;
        }
        let (Some(a), Some(b)) = (self.filters.get(pair[0].at()), self.filters.get(pair[1].at())) else {
            return true;
        };
        meet(a, b, |class| self.classes.at(class))
            && self.rule.is_none_or(|rule| rule(pair[0].slot(), pair[1].slot()))
    }
}

/// Whether every pair passes the filters.
struct AllMeet<'f> {
    filters: &'f [Filter],
    classes: &'f [u32],
}

impl Phase for AllMeet<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> bool {
        all_meet(self.filters, |class| self.classes.at(class))
    }
}

/// Passes on the pairs that the filter lets through.
pub(crate) struct Filtered<'s, 'g, I> {
    pub(crate) pair_filter: &'s PairFilter<'g>,
    pub(crate) sink: &'s mut dyn Sink<I>,
}

impl<I: Index> Sink<I> for Filtered<'_, '_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut kept = 0;
        for index in 0..pairs.len() {
            let pair = pairs.at(index);
            pairs.put(kept, pair);
            kept += usize::from(self.pair_filter.lets_through(&pair));
        }
        self.sink.take(pairs.span_mut(0, kept));
    }

    fn is_full(&self) -> bool {
        self.sink.is_full()
    }
}
