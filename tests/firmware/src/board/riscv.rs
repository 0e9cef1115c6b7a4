//! RISC-V: what must happen before Rust can run, semihosting and the instruction counter.

use core::arch::{asm, global_asm};

global_asm!(
    ".section .start, \"ax\"",
    ".global reset",
    "reset:",
    "la sp, stack_top",
    "la t0, 5f",
    "csrw mtvec, t0",
    "la t0, data_start",
    "la t1, data_end",
    "la t2, data_load",
    "j 2f",
    "1: lw t3, 0(t2)",
    "sw t3, 0(t0)",
    "addi t0, t0, 4",
    "addi t2, t2, 4",
    "2: bltu t0, t1, 1b",
    "la t0, bss_start",
    "la t1, bss_end",
    "j 4f",
    "3: sw zero, 0(t0)",
    "addi t0, t0, 4",
    "4: bltu t0, t1, 3b",
    "call start",
    ".balign 4",
    "5: j fault",
);

/// Asks the debugger, which is QEMU here.
///
/// # Safety
/// `argument` is what the operation takes: a number, or the address of what it reads and writes.
pub(super) unsafe fn semihosting(operation: usize, argument: usize) -> usize {
    let result;
    // SAFETY: the three words hand both registers to the debugger, which knows them by the shifts around the
    // breakpoint and needs them uncompressed on one page; the caller answers for the memory.
    unsafe {
        asm!(
            ".option push",
            ".option norvc",
            ".balign 16",
            "slli x0, x0, 0x1f",
            "ebreak",
            "srai x0, x0, 7",
            ".option pop",
            inout("a0") operation => result,
            in("a1") argument,
            options(nostack)
        );
    }
    result
}

/// The instructions that `work` takes, exactly.
pub(super) fn instructions(work: impl FnOnce()) -> u32 {
    let before = retired();
    work();
    retired().wrapping_sub(before)
}

fn retired() -> u32 {
    let count;
    // SAFETY: reads a counter.
    unsafe { asm!("csrr {}, minstret", out(reg) count, options(nomem, nostack)) };
    count
}

/// Takes two instructions a round.
pub(super) fn spin(rounds: u32) {
    // SAFETY: counts a register down.
    unsafe { asm!("1: addi {0}, {0}, -1", "bnez {0}, 1b", inout(reg) rounds => _, options(nomem, nostack)) };
}

/// The stack pointer.
#[inline(always)]
pub(super) fn stack_pointer() -> usize {
    let pointer;
    // SAFETY: reads a register.
    unsafe { asm!("mv {}, sp", out(reg) pointer, options(nomem, nostack)) };
    pointer
}
