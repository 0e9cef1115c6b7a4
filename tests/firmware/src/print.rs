//! Numbers as text, without `core::fmt`: its code is as large as the broad phase and can panic.

use crate::board;

/// Prints a number, right-aligned to a width.
pub fn number(value: u32, width: usize) {
    let mut digits = [None; 10];
    let mut rest = value;
    for place in digits.iter_mut().rev() {
        *place = (rest > 0).then_some(rest % 10);
        rest /= 10;
    }
    let written = digits.iter().flatten().count().max(1);
    spaces(width.saturating_sub(written));
    if value == 0 {
        digit(0);
    }
    digits.iter().flatten().for_each(|value| digit(*value as usize));
}

/// Prints 16 hexadecimal digits.
pub fn hexadecimal(value: u64) {
    for place in (0..16).rev() {
        digit((value >> (4 * place)) as usize & 15);
    }
}

/// Prints a text, left-aligned to a width.
pub fn text(text: &str, width: usize) {
    board::print(text);
    spaces(width.saturating_sub(text.len()));
}

fn spaces(count: usize) {
    (0..count).for_each(|_| board::print(" "));
}

fn digit(value: usize) {
    board::print("0123456789abcdef".get(value..=value).unwrap_or_default());
}
