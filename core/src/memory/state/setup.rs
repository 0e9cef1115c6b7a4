//! Stores a configuration as plain bytes.

use crate::config::{Capacity, Choice, Config, Hooks, Margin, Mode};
use crate::error::Field;
use bytemuck::{Pod, Zeroable};

/// The version, and a bit for the feature that changes the layout of the slab.
const MAGIC: u32 = 0x7452_0009 | if cfg!(feature = "large") { 1 << 15 } else { 0 };

// The bits of `Setup::flags`.
const EVENTS: u32 = 1;
const LEAN: u32 = 1 << 1;
const FILTERS: u32 = 1 << 2;
const MARGIN: u32 = 1 << 3;
const FAT: u32 = 1 << 4;
const FIXED_MARGINS: u32 = 1 << 5;
const VALUES: u32 = 1 << 6;
const PREDICTED: u32 = 1 << 7;
/// The first bit of the hooks, which are not in a snapshot.
const HOOKS: u32 = 8;
const PORTABLE: u32 = !(Hooks::MASK << HOOKS);

const fn flags(config: &Config) -> u32 {
    let Config { mode, margin, events, filters, values, lean, fixed_margins, predicted, hooks, .. } = *config;
    flag(EVENTS, events)
        | flag(LEAN, lean)
        | flag(FILTERS, filters)
        | flag(VALUES, values)
        | flag(MARGIN, margin.is_some())
        | flag(FAT, matches!(mode, Mode::Fat))
        | flag(FIXED_MARGINS, fixed_margins)
        | flag(PREDICTED, predicted)
        | (hooks.bits() << HOOKS)
}

const fn flag(bit: u32, is_set: bool) -> u32 {
    if is_set { bit } else { 0 }
}

/// A [`Config`] as plain bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Setup {
    magic: u32,
    index_bytes: u32,
    objects: u32,
    leaf_refs: u32,
    pairs: u32,
    margin: [f32; 3],
    /// All choices between two, and the hooks: see the constants.
    flags: u32,
    workers: u32,
}

impl Setup {
    pub(crate) fn new(config: &Config, index_bytes: usize) -> Self {
        let margin = config.margin.unwrap_or(Margin::length(0.0));
        Self {
            magic: MAGIC,
            index_bytes: index_bytes as u32,
            objects: config.capacity.objects,
            leaf_refs: config.capacity.leaf_refs,
            pairs: config.capacity.pairs,
            margin: [margin.per_extent, margin.min, margin.max],
            flags: flags(config),
            workers: config.workers,
        }
    }

    /// The configuration; `None` if this is not a world of this version and index width.
    pub(crate) fn config(&self, index_bytes: usize) -> Option<Config> {
        if self.magic != MAGIC || self.index_bytes != index_bytes as u32 {
            return None;
        }
        Some(Config {
            capacity: Capacity { objects: self.objects, leaf_refs: self.leaf_refs, pairs: self.pairs },
            mode: self.mode(),
            margin: self.margin(),
            events: self.events(),
            lean: self.flags & LEAN != 0,
            filters: self.flags & FILTERS != 0,
            values: self.flags & VALUES != 0,
            workers: self.workers,
            fixed_margins: self.has_fixed_margins(),
            predicted: self.is_predicted(),
            hooks: Hooks::from_bits(self.flags >> HOOKS)?,
        })
    }

    /// Each by itself, so that only the one that is asked for is read. Bits that name no choice, which no world has,
    /// count as automatic.
    #[inline(always)]
    pub(crate) fn hooks(&self) -> Hooks {
        let choice = |bits: u32| Choice::from_bits(bits).unwrap_or_default();
        let bits = self.flags >> HOOKS;
        Hooks {
            movers_only: choice(bits),
            fine_leaves: choice(bits >> 2),
            sharing: choice(bits >> 4),
            movers_by_leaf: choice(bits >> 6),
        }
    }

    pub(crate) const fn is_predicted(&self) -> bool {
        self.flags & PREDICTED != 0
    }

    pub(crate) const fn has_fixed_margins(&self) -> bool {
        self.flags & FIXED_MARGINS != 0
    }

    pub(crate) const fn events(&self) -> bool {
        self.flags & EVENTS != 0
    }

    pub(crate) const fn mode(&self) -> Mode {
        if self.flags & FAT == 0 { Mode::Exact } else { Mode::Fat }
    }

    /// The margin of new objects.
    pub(crate) fn margin(&self) -> Option<Margin> {
        let [per_extent, min, max] = self.margin;
        (self.flags & MARGIN != 0).then_some(Margin { per_extent, min, max })
    }

    /// The first difference that cannot change while there are objects.
    pub(crate) fn difference(&self, to: &Self) -> Option<Field> {
        let differs = |flag: u32| (self.flags ^ to.flags) & flag != 0;
        let fields = [
            (differs(FAT), Field::Mode),
            (differs(MARGIN), Field::Margin),
            (differs(EVENTS), Field::Events),
            (differs(FILTERS), Field::Filters),
            (differs(VALUES), Field::Values),
            (self.index_bytes != to.index_bytes, Field::Index),
        ];
        fields.into_iter().find(|(differs, _)| *differs).map(|(_, field)| field)
    }

    /// See [`State::portable`](super::State::portable).
    pub(super) const fn portable(&self) -> Self {
        Self { workers: 1, magic: 0, flags: self.flags & PORTABLE, ..*self }
    }

    /// The configuration of a portable state.
    pub(crate) fn portable_config(&self, index_bytes: usize) -> Option<Config> {
        Self { magic: MAGIC, ..*self }.config(index_bytes)
    }
}
