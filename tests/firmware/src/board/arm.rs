//! Cortex-M: the vector table, what must happen before Rust can run, semihosting and the system timer.

use core::arch::{asm, global_asm};

// The core loads its stack pointer from the first word of the table and starts at the second. A fault ends the run.
global_asm!(
    ".section .start, \"ax\"",
    ".word stack_top",
    ".word reset",
    ".rept 14",
    ".word fault",
    ".endr",
    ".global reset",
    ".thumb_func",
    "reset:",
    "bl enable_fpu",
    "ldr r0, =data_start",
    "ldr r1, =data_end",
    "ldr r2, =data_load",
    "b 2f",
    "1: ldr r3, [r2]",
    "str r3, [r0]",
    "adds r2, #4",
    "adds r0, #4",
    "2: cmp r0, r1",
    "blo 1b",
    "ldr r0, =bss_start",
    "ldr r1, =bss_end",
    "movs r2, #0",
    "b 4f",
    "3: str r2, [r0]",
    "adds r0, #4",
    "4: cmp r0, r1",
    "blo 3b",
    "bl start",
    ".ltorg",
);

// The access register of coprocessors 10 and 11, which are the FPU.
#[cfg(target_abi = "eabihf")]
global_asm!(
    ".section .start, \"ax\"",
    ".thumb_func",
    "enable_fpu:",
    "ldr r0, =0xe000ed88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xf00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "bx lr",
    ".ltorg",
);

#[cfg(not(target_abi = "eabihf"))]
global_asm!(".section .start, \"ax\"", ".thumb_func", "enable_fpu:", "bx lr");

/// Asks the debugger, which is QEMU here.
///
/// # Safety
/// `argument` is what the operation takes: a number, or the address of what it reads and writes.
pub(super) unsafe fn semihosting(operation: usize, argument: usize) -> usize {
    let result;
    // SAFETY: the breakpoint hands both registers to the debugger; the caller answers for the memory.
    unsafe { asm!("bkpt 0xab", inout("r0") operation => result, in("r1") argument, options(nostack)) };
    result
}

/// Control, reload value and current value of the system timer.
const TIMER: [*mut u32; 3] = [0xe000_e010 as *mut u32, 0xe000_e014 as *mut u32, 0xe000_e018 as *mut u32];
/// Its counter has 24 bits.
const TIMER_TOP: u32 = 0xff_ffff;
/// The timer counts at 25 MHz; under `-icount shift=0` QEMU runs an instruction each nanosecond.
const INSTRUCTIONS_PER_TICK: u32 = 40;

/// The instructions that `work` takes, to the next 40, up to 670 million.
pub(super) fn instructions(work: impl FnOnce()) -> u32 {
    let [control, reload, current] = TIMER;
    // SAFETY: registers of the system control block, which nobody else uses; writing restarts the counter.
    unsafe {
        reload.write_volatile(TIMER_TOP);
        current.write_volatile(0);
        // Enabled, without interrupt, from the processor's clock.
        control.write_volatile(0b101);
    }
    // SAFETY: as above; reading has no effect.
    let before = unsafe { current.read_volatile() };
    work();
    // SAFETY: as above.
    let after = unsafe { current.read_volatile() };
    (before.wrapping_sub(after) & TIMER_TOP) * INSTRUCTIONS_PER_TICK
}

/// Takes two instructions a round.
pub(super) fn spin(rounds: u32) {
    // SAFETY: counts a register down.
    unsafe { asm!("1: subs {0}, #1", "bne 1b", inout(reg) rounds => _, options(nomem, nostack)) };
}

/// The stack pointer.
#[inline(always)]
pub(super) fn stack_pointer() -> usize {
    let pointer;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
    pointer
}
