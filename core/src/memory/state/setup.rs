//! Stores a configuration as plain bytes.

use crate::config::{Capacity, Config, Forced, LISTS, Margin, Mode, TREE};
use crate::error::Field;
use bytemuck::{Pod, Zeroable};

/// The version, and a bit for each feature that changes the layout of the slab.
const MAGIC: u32 = 0x7452_000f | (TREE as u32) << 15 | (LISTS as u32) << 14;

/// A [`Config`] as plain bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Setup {
    magic: u32,
    objects: u32,
    leaf_refs: u32,
    pairs: u32,
    margin: [f32; 3],
    workers: u8,
    index_bytes: u8,
    pub(crate) forced: Forced,
    /// Fat, margin, events, filters, values; then what can change while there are objects.
    choices: [u8; 8],
}

impl Setup {
    pub(crate) fn new(config: &Config, index_bytes: usize) -> Self {
        let Config { mode, margin, events, filters, values, lean, fixed_margins, predicted, .. } = *config;
        let fat = mode == Mode::Fat;
        let choices =
            [fat, margin.is_some(), events, filters, values, lean, fixed_margins, predicted].map(u8::from);
        let Margin { per_extent, min, max } = margin.unwrap_or(Margin::length(0.0));
        Self {
            magic: MAGIC,
            objects: config.capacity.objects,
            leaf_refs: config.capacity.leaf_refs,
            pairs: config.capacity.pairs,
            margin: [per_extent, min, max],
            workers: config.workers as u8,
            index_bytes: index_bytes as u8,
            forced: config.forced,
            choices,
        }
    }

    /// The configuration; `None` if this is not a world of this version and index width.
    pub(crate) fn config(&self, index_bytes: usize) -> Option<Config> {
        let Self { objects, leaf_refs, pairs, margin: [per_extent, min, max], workers, forced, .. } = *self;
        let [fat, has_margin, events, filters, values, lean, fixed_margins, predicted] =
            self.choices.map(|choice| choice != 0);
        let is_right = self.magic == MAGIC && usize::from(self.index_bytes) == index_bytes;
        is_right.then_some(Config {
            capacity: Capacity { objects, leaf_refs, pairs },
            mode: if fat { Mode::Fat } else { Mode::Exact },
            margin: has_margin.then_some(Margin { per_extent, min, max }),
            events,
            lean,
            filters,
            values,
            workers: u32::from(workers),
            fixed_margins,
            predicted,
            forced,
        })
    }

    /// The first difference that cannot change while there are objects.
    pub(crate) fn difference(&self, to: &Self) -> Option<Field> {
        const FIELDS: [Field; 5] = [Field::Mode, Field::Margin, Field::Events, Field::Filters, Field::Values];
        let mut choices = self.choices.iter().zip(&to.choices).zip(FIELDS);
        let field = choices.find(|((own, other), _)| own != other).map(|(_, field)| field);
        field.or((self.index_bytes != to.index_bytes).then_some(Field::Index))
    }

    /// See [`State::portable`](super::State::portable).
    pub(super) const fn portable(&self) -> Self {
        Self { workers: 1, magic: 0, forced: self.forced.of_sizes(), ..*self }
    }

    /// The configuration of a portable state.
    pub(crate) fn portable_config(&self, index_bytes: usize) -> Option<Config> {
        Self { magic: MAGIC, ..*self }.config(index_bytes)
    }
}
