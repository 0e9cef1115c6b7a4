//! The emulated machine: its start, its output, its end, and what every program expects of a C library.

use core::arch::{asm, global_asm};
use core::fmt;
use core::panic::PanicInfo;

global_asm!(include_str!("boot.s"));

/// Bochs prints what is written to this port.
const CONSOLE: u16 = 0xe9;
/// Bochs ends when it reads a certain word here.
const POWER: u16 = 0x8900;

fn write(port: u16, byte: u8) {
    // SAFETY: both ports are the emulator's own, and touch no memory.
    unsafe { asm!("out dx, al", in("dx") port, in("al") byte, options(nomem, nostack, preserves_flags)) }
}

/// What the emulator prints.
pub(crate) struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| write(CONSOLE, byte));
        Ok(())
    }
}

/// Ends the emulator.
pub(crate) fn end() -> ! {
    "Shutdown".bytes().for_each(|byte| write(POWER, byte));
    loop {
        core::hint::spin_loop();
    }
}

/// Instructions since the start: the emulator's clock ticks once for each.
pub(crate) fn instructions() -> u64 {
    // SAFETY: every x86-64 CPU has the instruction.
    unsafe { core::arch::x86_64::_rdtsc() }
}

/// Whether the start code asks for the names of the levels alone.
pub(crate) fn levels_only() -> bool {
    unsafe extern "C" {
        #[link_name = "levels_only"]
        static LEVELS_ONLY: u32;
    }
    // SAFETY: it is in the ROM, which is mapped and does not change.
    unsafe { (&raw const LEVELS_ONLY).read_volatile() != 0 }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let _ = fmt::write(&mut Console, format_args!("{info}\n"));
    end()
}

// The string instructions, since a loop would be compiled into a call of the very function.
global_asm!(
    ".section .text.memory, \"ax\"",
    ".globl memcpy, memmove, memset, memcmp, bcmp",
    "memcpy:",
    "mov rax, rdi",
    "mov rcx, rdx",
    "rep movsb",
    "ret",
    "memmove:",
    "mov rax, rdi",
    "mov rcx, rdx",
    "sub rdi, rsi",
    "cmp rdi, rdx",
    "mov rdi, rax",
    "jae 2f",
    "lea rdi, [rdi + rdx - 1]",
    "lea rsi, [rsi + rdx - 1]",
    "std",
    "2: rep movsb",
    "cld",
    "ret",
    "memset:",
    "mov r8, rdi",
    "mov eax, esi",
    "mov rcx, rdx",
    "rep stosb",
    "mov rax, r8",
    "ret",
    "memcmp:",
    "bcmp:",
    "xor eax, eax",
    "mov rcx, rdx",
    "cmp rcx, rcx",
    "repe cmpsb",
    "je 2f",
    "movzx eax, byte ptr [rdi - 1]",
    "movzx ecx, byte ptr [rsi - 1]",
    "sub eax, ecx",
    "2: ret",
);
