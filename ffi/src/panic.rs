//! Ends a program in which trisap has found a mistake of its own.

use crate::report;
use crate::status::trisap_status;
use core::panic::PanicInfo;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let (file, line) = info.location().map_or(("trisap", 0), |place| (place.file(), place.line()));
    let text = report::place(file, line, info.message().as_str().unwrap_or("panicked"));
    report::tell(trisap_status::Other, 0, text.as_ptr().cast());
    abort()
}

/// C's own.
#[cfg(any(unix, windows))]
fn abort() -> ! {
    unsafe extern "C" {
        safe fn abort() -> !;
    }
    abort()
}

/// The host sees an exception, not a page that hangs.
#[cfg(target_family = "wasm")]
fn abort() -> ! {
    core::arch::wasm32::unreachable()
}

/// Without an operating system: an illegal instruction, so that a debugger or the fault handler sees where.
#[cfg(not(any(unix, windows, target_family = "wasm")))]
fn abort() -> ! {
    // SAFETY: does not return, and touches nothing.
    unsafe {
        #[cfg(target_arch = "arm")]
        core::arch::asm!("udf #0", options(noreturn, nomem, nostack));
        #[cfg(any(target_arch = "riscv32", target_arch = "riscv64"))]
        core::arch::asm!("unimp", options(noreturn, nomem, nostack));
        #[cfg(target_arch = "aarch64")]
        core::arch::asm!("udf #0", options(noreturn, nomem, nostack));
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        core::arch::asm!("ud2", options(noreturn, nomem, nostack));
    }
}
