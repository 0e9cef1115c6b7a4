//! What all boards have in common: no operating system, a debugger, a stack at the end of the RAM.

#[cfg(target_arch = "arm")]
use super::arm as cpu;
#[cfg(target_arch = "riscv32")]
use super::riscv as cpu;

unsafe extern "Rust" {
    /// What [`entry`](crate::entry) defines.
    safe fn trisap_main() -> u8;
}

unsafe extern "C" {
    /// From the linker script: the end of all statics.
    static mut bss_end: u32;
}

/// Called by the reset handler, once, with memory as Rust expects it.
#[unsafe(no_mangle)]
extern "C" fn start() -> ! {
    exit(trisap_main())
}

/// Where the hardware goes on a fault.
#[unsafe(no_mangle)]
extern "C" fn fault() -> ! {
    print("fault\n");
    exit(102)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    print("panic\n");
    exit(101)
}

/// Writes to the debugger's console.
pub fn print(text: &str) {
    const WRITE_BYTE: usize = 0x03;
    for byte in text.as_bytes() {
        // SAFETY: the operation reads the one byte.
        unsafe { cpu::semihosting(WRITE_BYTE, core::ptr::from_ref(byte).addr()) };
    }
}

/// Ends the run: QEMU ends with this exit code.
pub fn exit(code: u8) -> ! {
    const EXIT: usize = 0x20;
    /// The program has ended by itself.
    const APPLICATION_EXIT: usize = 0x2_0026;
    let block = [APPLICATION_EXIT, usize::from(code)];
    loop {
        // SAFETY: the operation reads the two words.
        unsafe { cpu::semihosting(EXIT, block.as_ptr().addr()) };
    }
}

/// The command line, behind the program's name: what QEMU has been given by `-semihosting-config arg=`.
pub fn argument(buffer: &mut [u8]) -> &[u8] {
    const COMMAND_LINE: usize = 0x15;
    let mut block = [buffer.as_mut_ptr().addr(), buffer.len()];
    // SAFETY: the operation writes at most the buffer's length to the buffer, and how much it was to the block.
    let failed = unsafe { cpu::semihosting(COMMAND_LINE, block.as_mut_ptr().expose_provenance()) };
    if failed != 0 {
        return &[];
    }
    let line = buffer.get(..block[1]).unwrap_or_default();
    let name = line.iter().take_while(|byte| **byte != b' ').count();
    line.get(name + 1..).unwrap_or_default()
}

/// The instructions that `work` takes, where QEMU counts them.
pub fn instructions(work: impl FnOnce()) -> Option<u32> {
    Some(cpu::instructions(work))
}

/// Takes two instructions a round.
pub fn spin(rounds: u32) {
    cpu::spin(rounds);
}

/// The stack that `work` uses, in bytes below the caller's frame.
#[inline(never)]
pub fn stack(work: impl FnOnce()) -> Option<usize> {
    const PAINT: u32 = 0x5eed_cafe;
    /// What this function may push while it paints.
    const OWN: usize = 16;
    let top = cpu::stack_pointer();
    let bottom = &raw mut bss_end;
    let words = (top - OWN - bottom.addr()) / size_of::<u32>();
    for word in 0..words {
        // SAFETY: between the statics and the stack in use there is RAM that nobody else uses.
        unsafe { bottom.add(word).write_volatile(PAINT) };
    }
    work();
    // SAFETY: as above.
    let unused = (0..words).take_while(|&word| unsafe { bottom.add(word).read_volatile() } == PAINT).count();
    Some(top - (bottom.addr() + unused * size_of::<u32>()))
}
