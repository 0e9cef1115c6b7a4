//! Which functions a function calls.

use crate::binary::{Binary, Function};
use crate::thumb::{self, Flow};

/// A call or a branch to another function.
pub(crate) struct Call {
    pub(crate) from: u32,
    /// `None` where the address is in a register.
    pub(crate) target: Option<u32>,
}

/// The calls in a function.
pub(crate) fn of(binary: &Binary, function: &Function) -> Vec<Call> {
    let mut calls = Vec::new();
    let mut address = function.start;
    while address < function.end {
        if binary.is_data(address) {
            address += 2;
            continue;
        }
        let Some(first) = binary.half(address) else { break };
        let second = binary.half(address + 2).unwrap_or_default();
        match thumb::flow(address, first, second) {
            // The smallest cores have no other far branch, so a call into the middle of the function is none.
            Flow::Call(target) if !(function.start + 1..function.end).contains(&target) => {
                calls.push(Call { from: address, target: Some(target) });
            }
            Flow::To(target) if !(function.start..function.end).contains(&target) => {
                calls.push(Call { from: address, target: Some(target) });
            }
            Flow::Anywhere => calls.push(Call { from: address, target: None }),
            _ => {}
        }
        address += thumb::length(first);
    }
    calls
}
