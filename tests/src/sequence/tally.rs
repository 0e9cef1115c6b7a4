//! What ran in a sequence, and what was said in it.

use super::format::{KIND_COUNT, Kind};
use crate::SlotPair;
use crate::checked::Outcome;
use std::fmt;
use std::ops::AddAssign;
use trisap_core::{Error, Field, Path, Stats};

/// Counts of what ran, and a hash of all that was said: what the same sequence through the C ABI must come to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Operations by kind.
    pub kinds: [u64; KIND_COUNT],
    /// Calls that were refused.
    pub refused: u64,
    /// Complete steps by path.
    pub paths: [u64; 6],
    /// Steps whose buffer was full.
    pub full: u64,
    /// Steps that refused boxes.
    pub rejecting: u64,
    /// Pairs of complete steps.
    pub pairs: u64,
    /// Pairs that came.
    pub found: u64,
    /// Pairs that went.
    pub lost: u64,
    /// Pairs beyond the exact ones.
    pub surplus: u64,
    /// Steps with small leaves.
    pub fine: u64,
    /// Steps with objects in the list of large ones.
    pub large: u64,
    /// Answers to queries.
    pub answers: u64,
    /// Snapshots that were loaded.
    pub loaded: u64,
    /// Forged snapshots that were refused.
    pub forged_refused: u64,
    /// Forged snapshots that were loaded.
    pub forged_loaded: u64,
    /// Moves into other capacities.
    pub grown: u64,
    /// Trees that were brought up to date for queries.
    pub refreshed: u64,
    /// Of all that was said.
    pub hash: u64,
}

impl Tally {
    /// Operations in all.
    #[must_use]
    pub fn operations(&self) -> u64 {
        self.kinds.iter().sum()
    }

    /// Steps in all.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.paths.iter().sum::<u64>() + self.full
    }

    /// The numbers in the order in which the C++ program prints them.
    #[must_use]
    pub fn numbers(&self) -> Vec<u64> {
        let rest = [
            self.refused,
            self.full,
            self.rejecting,
            self.pairs,
            self.found,
            self.lost,
            self.fine,
            self.large,
            self.answers,
            self.loaded,
            self.forged_refused,
            self.forged_loaded,
            self.grown,
            self.refreshed,
            self.hash,
        ];
        self.kinds.iter().chain(&self.paths).chain(&rest).copied().collect()
    }

    pub(super) fn say(&mut self, number: u64) {
        self.hash = (self.hash ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    }

    pub(super) fn say_pairs(&mut self, pairs: &[SlotPair]) {
        self.say(pairs.len() as u64);
        pairs.iter().for_each(|[a, b]| self.say(u64::from(*a) << 32 | u64::from(*b)));
    }

    /// What became of a call: the number of its status in C, and the detail of one that was refused.
    pub(super) fn say_status<T>(&mut self, result: &Result<T, Error>) {
        match result {
            Ok(_) => self.say(0),
            Err(error) => {
                self.refused += 1;
                self.say(status(error));
                self.say(detail(error));
            }
        }
    }

    pub(super) fn step(&mut self, outcome: &Result<Outcome, Error>, prefix: &[SlotPair]) {
        match outcome {
            Ok(outcome) => {
                self.say(0);
                self.count(&outcome.stats);
                self.surplus += outcome.surplus;
                self.say_pairs(&outcome.pairs);
                self.say_pairs(&outcome.found);
                self.say_pairs(&outcome.lost);
                outcome.values.iter().for_each(|[a, b]| self.say(a ^ b.rotate_left(32)));
                self.rejecting += u64::from(outcome.rejected.is_some());
                self.say(outcome.rejected.map_or(0, |rejected| u64::from(rejected.count)));
                self.say(outcome.rejected.map_or(0, |rejected| rejected.first.to_bits()));
            }
            Err(error) => {
                self.full += 1;
                self.say(status(error));
                self.say_pairs(prefix);
                let Error::PairsFull { needed, .. } = error else { panic!("{error}") };
                self.say(*needed);
            }
        }
    }

    fn count(&mut self, stats: &Stats) {
        let path = match stats.path {
            Path::Unchanged => 0,
            Path::Lists => 1,
            Path::Movers => 2,
            Path::Full => 3,
            Path::Rebuilt => 4,
            Path::MoversByLeaf => 5,
            path => panic!("{path:?} is not counted"),
        };
        self.paths[path] += 1;
        self.pairs += stats.pairs;
        self.found += stats.found;
        self.lost += stats.lost;
        self.fine += u64::from(stats.fine_leaves);
        self.large += u64::from(stats.large > 0);
        self.say(stats.candidates);
        self.say(stats.copies);
        self.say(u64::from(stats.moved));
    }
}

impl AddAssign<&Self> for Tally {
    fn add_assign(&mut self, other: &Self) {
        let add = |to: &mut [u64], from: &[u64]| to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        add(&mut self.kinds, &other.kinds);
        add(&mut self.paths, &other.paths);
        self.refused += other.refused;
        self.full += other.full;
        self.rejecting += other.rejecting;
        self.pairs += other.pairs;
        self.found += other.found;
        self.lost += other.lost;
        self.surplus += other.surplus;
        self.fine += other.fine;
        self.large += other.large;
        self.answers += other.answers;
        self.loaded += other.loaded;
        self.forged_refused += other.forged_refused;
        self.forged_loaded += other.forged_loaded;
        self.grown += other.grown;
        self.refreshed += other.refreshed;
        // The same in any order: sequences are played on several threads.
        self.hash = self.hash.wrapping_add(other.hash);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [unchanged, lists, movers, full, rebuilt, by_leaf] = self.paths;
        writeln!(f, "{} operations, {} steps compared with brute force", self.operations(), self.steps())?;
        writeln!(
            f,
            "paths: {unchanged} unchanged, {lists} lists, {movers} movers, {full} full, {rebuilt} rebuilt, {by_leaf} movers by leaf"
        )?;
        writeln!(f, "steps: {} full buffers, {} refused boxes", self.full, self.rejecting)?;
        writeln!(f, "       {} with small leaves, {} with large objects", self.fine, self.large)?;
        writeln!(
            f,
            "pairs: {}, {} found, {} lost, {} surplus",
            self.pairs, self.found, self.lost, self.surplus
        )?;
        writeln!(f, "calls: {} refused; {} answers of queries", self.refused, self.answers)?;
        let (refused, loaded) = (self.forged_refused, self.forged_loaded);
        writeln!(f, "loads: {} good, forged: {refused} refused, {loaded} loaded", self.loaded)?;
        let copies = self.kinds[Kind::Copy as usize];
        let attempts = self.kinds[Kind::Grow as usize];
        writeln!(f, "moves: {copies} to other memory, {} of {attempts} into other capacities", self.grown)?;
        write!(f, "hash: {:016x}", self.hash)
    }
}

/// The number of an error in C.
fn status(error: &Error) -> u64 {
    match error {
        Error::CapacityTooLarge { .. } => 9,
        Error::BadMargin => 10,
        Error::ObjectsFull { .. } => 11,
        Error::BadBox { .. } => 12,
        Error::StaleId { .. } => 13,
        Error::PairsFull { .. } => 14,
        Error::NoFilters => 16,
        Error::BadClass { .. } => 17,
        Error::BadQuery { .. } => 18,
        Error::OutputFull { .. } => 19,
        Error::BadSnapshot => 20,
        Error::BadShift => 21,
        Error::NoRoom { field: Field::Objects, .. } => 11,
        Error::NoRoom { .. } => 14,
        Error::OtherConfig { .. } => 23,
        Error::NoValues => 24,
        Error::NoMargins => 25,
        Error::SlotTaken { .. } => 26,
        other => panic!("{other} is no answer to what a sequence does"),
    }
}

/// The detail of an error in C.
fn detail(error: &Error) -> u64 {
    match *error {
        Error::ObjectsFull { needed, .. }
        | Error::PairsFull { needed, .. }
        | Error::OutputFull { needed, .. } => needed,
        Error::CapacityTooLarge { most, .. } => most,
        Error::BadBox { index } | Error::BadQuery { index } => u64::from(index),
        Error::StaleId { id } | Error::SlotTaken { id } => id.to_bits(),
        Error::BadClass { class } => u64::from(class),
        Error::NoRoom { needed, .. } => u64::from(needed),
        Error::OtherConfig { field: Field::Mode } => 1,
        Error::OtherConfig { field: Field::Margin } => 2,
        Error::OtherConfig { field: Field::Events } => 3,
        Error::OtherConfig { field: Field::Filters } => 4,
        Error::OtherConfig { field: Field::Index } => 5,
        Error::OtherConfig { field: Field::Values } => 6,
        _ => 0,
    }
}
