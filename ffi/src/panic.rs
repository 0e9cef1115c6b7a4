//! The end of a program that has found a mistake of trisap's.

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    #[cfg(any(unix, windows))]
    {
        unsafe extern "C" {
            safe fn abort() -> !;
        }
        abort()
    }
    // The host sees an exception, not a page that hangs.
    #[cfg(target_family = "wasm")]
    core::arch::wasm32::unreachable();
    // Where there is nobody to tell, the watchdog will notice.
    #[cfg(not(any(unix, windows, target_family = "wasm")))]
    loop {
        core::hint::spin_loop();
    }
}
