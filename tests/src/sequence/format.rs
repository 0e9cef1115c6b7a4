//! What the bytes of a sequence mean.

use crate::forced::{Choice, Forced as _};
use crate::scenes::Rng;
use trisap_core::{Capacity, Config, Margin, Mode};

/// Bytes that say what the world is like.
pub const HEADER: usize = 8;

/// Bytes of an operation.
pub const OPERATION: usize = 4;

/// The capacities that there are. The last one has a tree in every build.
const OBJECTS: [u32; 8] = [3, 9, 24, 40, 64, 70, 140, 700];

/// Much or little room, or none, for copies in leaves and for pairs.
fn capacity(objects: u32, choice: usize) -> Capacity {
    let leaf_refs = [objects / 2, 0, objects / 8, 2 * objects][choice % 4];
    let few = if choice < 192 { objects / 2 } else { 0 };
    let pairs = [8 * objects, objects * objects / 2, few, 2 * objects][choice / 4 % 4];
    Capacity::for_objects(objects).with_leaf_refs(leaf_refs).with_pairs(pairs)
}

/// What the world is like.
#[derive(Clone, Copy, Debug)]
pub struct Header([u8; HEADER]);

impl Header {
    /// Takes the header off the front; bytes that are not there are zero.
    #[must_use]
    pub fn split(bytes: &[u8]) -> (Self, &[u8]) {
        let (front, rest) = bytes.split_at(bytes.len().min(HEADER));
        let mut header = [0; HEADER];
        header[..front.len()].copy_from_slice(front);
        (Self(header), rest)
    }

    /// How many objects there is room for in the beginning.
    #[must_use]
    pub fn objects(&self) -> u32 {
        OBJECTS[self.0[0] as usize % OBJECTS.len()]
    }

    fn flag(&self, bit: u32) -> bool {
        self.0[1] >> bit & 1 != 0
    }

    /// Whether slots have 16 bits instead of 32.
    #[must_use]
    pub fn narrow(&self) -> bool {
        self.flag(7)
    }

    /// Whether steps have a rule.
    #[must_use]
    pub fn rule(&self) -> bool {
        self.flag(1) && self.flag(2)
    }

    /// Whether leaves have few objects, so that small worlds take all paths.
    #[must_use]
    pub fn small_leaves(&self) -> bool {
        self.0[4] & 16 != 0
    }

    /// The configuration, for one worker.
    #[must_use]
    pub fn config(&self) -> Config {
        let objects = self.objects();
        let choice =
            |by: u8| [Choice::Automatic, Choice::Never, Choice::Always][(self.0[2] / by % 3) as usize];
        let capacity = capacity(objects, self.0[3] as usize);
        let mut config = Config::new(capacity)
            .with_mode(if self.flag(4) { Mode::Fat } else { Mode::Exact })
            .with_movers_only(choice(1))
            .with_fine_leaves(choice(3))
            .with_sharing(choice(9))
            .with_movers_by_leaf(choice(27));
        config.margin = self.flag(3).then_some(Margin { per_extent: 0.125, min: 0.03125, max: 1.0 });
        config.events = self.flag(0);
        config.filters = self.flag(1);
        config.values = self.0[4] & 4 != 0;
        config.lean = self.flag(5) && objects <= 256;
        config.fixed_margins = self.flag(6);
        config.predicted = self.0[4] & 8 != 0;
        if self.small_leaves() { config.with_small_leaves() } else { config }
    }

    /// What a world of some configuration becomes when it grows, or shrinks.
    #[must_use]
    pub fn grown(&self, config: &Config, argument: usize) -> Config {
        let sizes = [(self.objects() / 2).max(2), self.objects(), self.objects() + 7, 2 * self.objects()];
        let objects = sizes[argument % 4];
        let mut config = config.with_capacity(capacity(objects, argument / 4));
        config.lean = self.flag(5) && objects <= 256;
        config
    }

    /// The workers of the twin.
    #[must_use]
    pub fn workers(&self) -> u32 {
        2 + u32::from(self.0[4]) % 4
    }

    /// The steps of the lattice that corners are on, and an axis on which all have the same, or none (3).
    #[must_use]
    pub fn lattice(&self) -> (usize, usize) {
        (3 + self.0[5] as usize % 64, self.0[6] as usize % 8)
    }

    /// Boxes on the lattice (0 and 1), between its steps (2), or of all sizes (3).
    #[must_use]
    pub fn style(&self) -> u8 {
        self.0[6] / 8 % 4
    }

    /// Objects that are there from the beginning.
    #[must_use]
    pub fn start(&self) -> usize {
        self.objects() as usize * self.0[7] as usize / 255
    }
}

/// What is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An object comes.
    Insert,
    /// Some come.
    InsertMany,
    /// One moves.
    Set,
    /// Some move.
    UpdateMany,
    /// One goes.
    Remove,
    /// Some go.
    RemoveMany,
    /// One gets a margin.
    SetMargin,
    /// One gets a filter.
    SetFilter,
    /// Classes meet or not.
    SetClasses,
    /// The rule thinks again about one.
    Refilter,
    /// Some are put to rest.
    SetResting,
    /// Some are woken.
    Wake,
    /// The origin moves.
    Shift,
    /// A step.
    Step,
    /// A step over an array of boxes.
    StepOver,
    /// Which objects a region overlaps.
    Overlaps,
    /// What a cast meets.
    Cast,
    /// The objects that are nearest to a point.
    Nearest,
    /// Many queries at once.
    Batches,
    /// What the tree and the configuration look like.
    View,
    /// A snapshot is kept.
    Save,
    /// The world goes back to one.
    Load,
    /// A damaged snapshot is refused.
    LoadDamaged,
    /// A forged one with a right checksum is refused, or as right as any.
    LoadForged,
    /// The world is dropped and opened again.
    Reopen,
    /// The world is copied to other memory and opened there, or moves there.
    Copy,
    /// All objects go.
    Clear,
    /// The world moves into other capacities, or is loaded there.
    Grow,
    /// Some get filters.
    SetFilterMany,
    /// One gets a value.
    SetValue,
    /// Some get values.
    SetValueMany,
    /// Some are disabled, or enabled.
    SetEnabled,
}

/// As often as they are here.
const KINDS: [Kind; 41] = {
    use Kind::*;
    [
        Step,
        Step,
        Step,
        Step,
        Step,
        Step,
        Step,
        Step,
        StepOver,
        StepOver,
        StepOver,
        StepOver,
        Insert,
        Insert,
        InsertMany,
        Set,
        Set,
        Set,
        UpdateMany,
        UpdateMany,
        Remove,
        Remove,
        RemoveMany,
        SetMargin,
        SetFilter,
        SetClasses,
        Refilter,
        SetResting,
        Wake,
        Shift,
        Overlaps,
        Cast,
        Nearest,
        Batches,
        View,
        Save,
        Load,
        LoadDamaged,
        LoadForged,
        Reopen,
        Grow,
    ]
};

/// How many kinds there are.
pub const KIND_COUNT: usize = Kind::SetEnabled as usize + 1;

/// An operation.
#[derive(Clone, Debug)]
pub struct Operation {
    /// What is done.
    pub kind: Kind,
    /// How.
    pub argument: usize,
    /// The numbers that it takes.
    pub rng: Rng,
}

impl Operation {
    /// Reads one.
    #[must_use]
    pub fn read([kind, argument, low, high]: [u8; OPERATION]) -> Self {
        let argument = argument as usize;
        let mut kind = KINDS[kind as usize % KINDS.len()];
        if kind == Kind::Reopen && argument.is_multiple_of(2) {
            kind = Kind::Copy;
        }
        if kind == Kind::RemoveMany && argument % 8 == 7 {
            kind = Kind::Clear;
        }
        if kind == Kind::SetFilter && argument % 4 == 3 {
            kind = Kind::SetFilterMany;
        }
        if kind == Kind::Set && argument % 4 == 3 {
            kind = Kind::SetValue;
        }
        if kind == Kind::UpdateMany && argument % 8 == 7 {
            kind = Kind::SetValueMany;
        }
        if matches!(kind, Kind::SetResting | Kind::Wake) && argument % 2 == 1 {
            kind = Kind::SetEnabled;
        }
        Self { kind, argument, rng: Rng::new(u64::from(u16::from_le_bytes([low, high]))) }
    }
}

/// All operations, without what is left over at the end.
pub fn operations(bytes: &[u8]) -> impl Iterator<Item = Operation> + '_ {
    bytes.as_chunks::<OPERATION>().0.iter().map(|bytes| Operation::read(*bytes))
}

/// Random bytes of a sequence of so many operations. Three in four worlds are small and few are large, as these take their time.
#[must_use]
pub fn random(seed: u64, operations: usize) -> Vec<u8> {
    let mut rng = Rng::new(seed);
    let words = (HEADER + OPERATION * operations).div_ceil(8);
    let mut bytes: Vec<u8> = (0..words).flat_map(|_| rng.bits().to_le_bytes()).collect();
    bytes.truncate(HEADER + OPERATION * operations);
    bytes[0] = if rng.once_in(4) { rng.below(OBJECTS.len() - 1) } else { 1 + rng.below(3) } as u8;
    if rng.once_in(8) {
        // As a user has them: a tree, leaves of the usual size, and nothing forced.
        (bytes[0], bytes[2]) = (OBJECTS.len() as u8 - 2, 0);
        bytes[1] &= !(1 << 5);
        bytes[4] &= !16;
    }
    if rng.once_in(64) {
        bytes[0] = OBJECTS.len() as u8 - 1;
        bytes[7] |= 0xc0;
    }
    bytes
}

/// The same, but every second operation loads a forged snapshot.
#[must_use]
pub fn forging(mut bytes: Vec<u8>) -> Vec<u8> {
    let load = KINDS.iter().position(|kind| *kind == Kind::LoadForged).unwrap_or(0) as u8;
    bytes.iter_mut().skip(HEADER).step_by(2 * OPERATION).for_each(|kind| *kind = load);
    bytes
}

/// The same with slots of 32 bits, as the C ABI has them.
#[must_use]
pub fn wide(mut bytes: Vec<u8>) -> Vec<u8> {
    if let Some(flags) = bytes.get_mut(1) {
        *flags &= 0x7f;
    }
    bytes
}
