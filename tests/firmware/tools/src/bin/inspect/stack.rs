//! A bound for the stack of every public call: the frames, as the compiler tells them, along the deepest chain of calls.
//!
//! Recursion has no bound and is a fault. Calls through registers are the library's hooks: an executor, its job, the
//! work on a block, and where pairs go. [`HOOKS`] says which functions they may reach; a call of which it says nothing
//! is a fault.

use crate::binary::{Binary, Function};
use crate::calls;
use anyhow::Result;
use std::collections::{HashMap, HashSet};

/// What is in the name of a function that calls through registers, and what in the names of those that it calls then.
/// The first line that fits counts.
const HOOKS: [(&str, &[&str]); 34] = [
    ("in_blocks<trisap_core::query::cast", &["first_hits::{closure#0} as"]),
    ("in_blocks<trisap_core::query::region", &["overlaps_many::{closure#0} as"]),
    ("in_blocks::<trisap_core::query::cast", &["first_hits::{closure#0} as"]),
    ("in_blocks::<trisap_core::query::region", &["overlaps_many::{closure#1} as"]),
    ("region::InRegion<u16>>::found", &["collect<trisap_core::id::Id", KEPT]),
    ("region::InRegion<u16>>::{closure", &["collect<trisap_core::id::Id", KEPT, "region::Ball as"]),
    ("cast::OnLine<u16>>::{closure", &["::hits::{closure", "::first_hit::{closure"]),
    ("nearest::Near<u16>>::{closure", &["api::nearest::{closure"]),
    // A program without a ball has none to ask, and the check of pairs asks for boxes alone.
    ("region::InRegion<u16>>::side", &["region::Ball as", KEPT]),
    ("in_parallel::{closure", &["trisap_core::step::", "collect::{closure"]),
    ("collect::{closure", &["trisap_core::step::"]),
    ("Collector", &["trisap_core::step::", "collect::{closure", "in_parallel::{closure", "Executor>::"]),
    ("sweep::Sink<u16>>::take", &[RULE]),
    ("OneStep as", &["Serial as"]),
    ("sweep_movers", &["Sink<u16>>::take"]),
    ("sweep_leaves", &["Sink<u16>>::take"]),
    ("trisap_core::step::full::full::<u16>::{closure", &["Sink<u16>>::take"]),
    ("trisap_core::step::", &["Sink<u16>>::take", "Executor>::", "intake::", "assign::"]),
    ("intake::", &["intake::", "Executor>::"]),
    ("assign::", &["assign::", "Executor>::"]),
    ("results::", &["Executor>::"]),
    ("sweep::s", &[RULE]),
    ("snapshot::saved", &["::snapshot_size::{closure", "::save::{closure"]),
    ("World<u16>>::visit_hits", &["::hits::{closure", "::first_hit::{closure"]),
    ("cast::visit_along", &["::hits::{closure", "::first_hit::{closure"]),
    ("World<u16>>::", &["Executor>::", "results::", "in_blocks::<", "in_blocks<", RULE]),
    ("Stepper<u16>>::", &["Executor>::", "results::", "intake::", "assign::", RULE]),
    ("api::step", &["Executor>::"]),
    ("partition::", &["Executor>::"]),
    ("enclose::", &["Executor>::"]),
    ("keep::", &["Executor>::"]),
    ("relocate::", &["Executor>::"]),
    ("nearest::visit_near", &["api::nearest::{closure"]),
    ("api::nearest", &["api::nearest::{closure"]),
];

/// The filter rule of the program `around`.
const RULE: &str = "api::step_with_rule::{closure";

/// What the check of all pairs does with the boxes that overlap one.
const KEPT: &str = "kept_pairs<u16>::{closure#3} as";

/// Frames of functions that are written by hand, of which no compiler tells: division, in `compiler_builtins`.
const BY_HAND: [(&str, u32); 2] = [("__aeabi_uidivmod", 8), ("__aeabi_uldivmod", 24)];

/// What a function may skip to align its frame to more than the eight bytes that its caller keeps to: the compiler does not
/// count that.
fn realigned(binary: &Binary, function: &Function) -> u32 {
    let half = |address: u32| binary.half(address).unwrap_or_default();
    let to_stack_pointer = |address: &u32| half(*address) & 0xff87 == 0x4685;
    let places = (function.start + 4..function.end).step_by(2).filter(|place| !binary.is_data(*place));
    let bits = places.filter(to_stack_pointer).map(|place| match (half(place - 4), half(place - 2)) {
        // BFC from bit 0 on, of the register that is moved then.
        (0xf36f, second) if second & 0xffe0 == (half(place) & 0x78) << 5 => u32::from(second & 0x1f) + 1,
        // LSRS and LSLS by as much.
        (right, left) if left < 0x800 && right == left | 0x800 => u32::from(left >> 6),
        _ => 0,
    });
    bits.max().filter(|bits| *bits > 3).map_or(0, |bits| (1 << bits) - 8)
}

/// Prints the bound of every public call and returns what is wrong.
pub(crate) fn check(binary: &Binary, limit: u32, measured: &str) -> Result<Vec<String>> {
    let measured: HashMap<&str, u32> = measured.lines().filter_map(row).collect();
    let mut bounds = Bounds { binary, pointed: pointed(binary), known: HashMap::new(), faults: Vec::new() };
    let mut faults = Vec::new();
    let mut count = 0;
    for function in &binary.functions {
        let Some((_, call)) = function.name.split_once("::api::") else { continue };
        let bound = bounds.of(function);
        let seen = measured.get(call).copied();
        println!(
            "stack of {call}: at most {bound} bytes, seen {}",
            seen.map_or("-".into(), |seen| seen.to_string())
        );
        if bound > limit {
            let chain = bounds.chain(function);
            faults.push(format!("{call} may use {bound} bytes of stack, more than {limit}:\n{chain}"));
        }
        if seen.is_some_and(|seen| seen > bound) {
            faults.push(format!("{call} was seen to use more stack than the computed {bound} bytes"));
        }
        count += 1;
    }
    faults.append(&mut bounds.faults);
    if count == 0 {
        faults.push("there is no public call to bound".into());
    }
    Ok(faults)
}

/// A call and the stack that it was seen to use.
fn row(line: &str) -> Option<(&str, u32)> {
    let (call, stack) = line.split_once(' ')?;
    Some((call, stack.trim().parse().ok()?))
}

/// The functions whose addresses stand in the read-only data.
fn pointed(binary: &Binary) -> Vec<&Function> {
    let words: HashSet<u32> = binary.words.iter().map(|word| word & !1).collect();
    binary.functions.iter().filter(|function| words.contains(&function.start)).collect()
}

struct Bounds<'b> {
    binary: &'b Binary,
    pointed: Vec<&'b Function>,
    /// By the start of the function; `None` while its own calls are followed.
    known: HashMap<u32, Option<u32>>,
    faults: Vec<String>,
}

impl<'b> Bounds<'b> {
    fn of(&mut self, function: &'b Function) -> u32 {
        match self.known.get(&function.start) {
            Some(Some(bound)) => return *bound,
            Some(None) => {
                self.faults.push(format!("{} calls itself", function.name));
                return 0;
            }
            None => {}
        }
        self.known.insert(function.start, None);
        let mut deepest = 0;
        for called in self.called_by(function) {
            deepest = deepest.max(self.of(called));
        }
        let by_hand = || BY_HAND.iter().find(|(name, _)| *name == function.name).map(|(_, frame)| *frame);
        let frame = function.frame.or_else(by_hand).unwrap_or_else(|| {
            self.faults.push(format!("the frame of {} is not known", function.name));
            0
        });
        let bound = frame + realigned(self.binary, function) + deepest;
        self.known.insert(function.start, Some(bound));
        bound
    }

    /// The calls that need the most stack, and how much there is left to go in each.
    fn chain(&mut self, function: &'b Function) -> String {
        let (mut text, mut next) = (String::new(), Some(function));
        while let Some(function) = next {
            let bound = self.of(function);
            text += &format!("  {bound} {}\n", function.name);
            let deeper = self.called_by(function).into_iter().map(|called| (self.of(called), called));
            // Less is left in each, but for what calls itself.
            next = deeper
                .filter(|(left, _)| *left < bound)
                .max_by_key(|(left, _)| *left)
                .map(|(_, called)| called);
        }
        text
    }

    fn called_by(&mut self, function: &'b Function) -> Vec<&'b Function> {
        let mut called = Vec::new();
        for call in calls::of(self.binary, function) {
            let before = called.len();
            match call.target {
                Some(target) => called.extend(self.binary.function_at(target)),
                None => called.extend(self.hooked(function)),
            }
            if called.len() == before {
                self.faults.push(format!("{} calls nobody knows whom at {:#x}", function.name, call.from));
            }
        }
        called.sort_by_key(|function| function.start);
        called.dedup_by_key(|function| function.start);
        called
    }

    /// What a function may call through registers: of the functions whose addresses stand in the data, or, where there is
    /// none, since the compiler has put the address into the code, of all.
    fn hooked(&self, function: &Function) -> Vec<&'b Function> {
        let Some((_, parts)) = HOOKS.iter().find(|(caller, _)| function.name.contains(caller)) else {
            return Vec::new();
        };
        let fits = |called: &&Function| parts.iter().any(|part| called.name.contains(part));
        let pointed: Vec<_> = self.pointed.iter().copied().filter(fits).collect();
        if pointed.is_empty() { self.binary.functions.iter().filter(fits).collect() } else { pointed }
    }
}
