//! Tells the host more than a status: refusals, and where a panic was.

use crate::status::{Refusal, trisap_status, trisap_status_text};
use core::ffi::{c_char, c_void};
use core::ptr::null_mut;
use core::sync::atomic::{
    AtomicPtr,
    Ordering::{Acquire, Release},
};

/// Called with every refusal, on the thread that is refused, after the call has left the world and before it returns: a place for
/// an assertion, a breakpoint or a line in a log. `text` is good until it returns. Full buffers are among the refusals, but for those
/// of worlds that grow (see `trisap_world_set_growing`), and answers are not: `trisap_world_contains` is never reported.
///
/// If trisap finds a mistake of its own, it is called with `TRISAP_STATUS_OTHER` and a text that names the place in its source, and
/// then the program is aborted.
pub type trisap_report =
    Option<unsafe extern "C" fn(user: *mut c_void, status: trisap_status, detail: u64, text: *const c_char)>;

static REPORT: AtomicPtr<c_void> = AtomicPtr::new(null_mut());
static USER: AtomicPtr<c_void> = AtomicPtr::new(null_mut());

/// Sets a function that is called with every refusal of a call that returns a status, of all worlds. `user` is passed to
/// it; null ends the reports. Set it before other threads call trisap. O(1).
#[unsafe(no_mangle)]
pub extern "C" fn trisap_set_report(report: trisap_report, user: *mut c_void) {
    REPORT.store(null_mut(), Release);
    USER.store(user, Release);
    REPORT.store(report.map_or(null_mut(), |report| report as *mut c_void), Release);
}

/// Has the function of `trisap_set_report` called as for a refusal of the library's own: for covers in other languages,
/// which refuse some things before they call. O(1).
#[unsafe(no_mangle)]
pub extern "C" fn trisap_refuse(status: i32, detail: u64) {
    tell(trisap_status::of(status), detail, trisap_status_text(status));
}

/// Tells the host.
pub(crate) fn tell(status: trisap_status, detail: u64, text: *const c_char) {
    let report = REPORT.load(Acquire);
    if !report.is_null() {
        // SAFETY: `trisap_set_report` stores functions of this type, which have the size of a pointer.
        let report = unsafe { core::mem::transmute::<*mut c_void, trisap_report>(report) };
        if let Some(report) = report {
            // SAFETY: called as its contract says.
            unsafe { report(USER.load(Acquire), status, detail, text) };
        }
    }
}

/// The status of a call, reported if it is a refusal.
#[inline(never)]
pub(crate) fn conclude(outcome: Result<(), Refusal>) -> trisap_status {
    match outcome {
        Ok(()) => trisap_status::Ok,
        Err(Refusal { status, detail, quiet }) => {
            if !quiet {
                tell(status, detail, trisap_status_text(status as i32));
            }
            status
        }
    }
}

/// "file:line: message" with a zero at its end, cut if it is too long. Without the formatting of `core`, which is
/// larger than the code of a small world.
#[doc(hidden)]
#[must_use]
pub fn place(file: &str, line: u32, message: &str) -> [u8; 256] {
    let mut text = [0; 256];
    let (mut number, mut rest, mut start) = ([0; 10], line, 10);
    while start == 10 || rest > 0 {
        start -= 1;
        number[start] = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    let parts = [file.as_bytes(), b":", &number[start..], b": ", message.as_bytes()];
    // The last byte stays zero.
    let room = text.iter_mut().take(255);
    room.zip(parts.into_iter().flatten()).for_each(|(to, from)| *to = *from);
    text
}
