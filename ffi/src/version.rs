//! Versions.

use core::ffi::{CStr, c_char};
use trisap_core::Kernels;

/// The version of the ABI that this header describes. Libraries with the same ABI version can take each other's place.
pub const TRISAP_ABI_VERSION: u32 = 7;
/// Major version of the library that this header belongs to.
pub const TRISAP_VERSION_MAJOR: u32 = 0;
/// Minor version of the library that this header belongs to.
pub const TRISAP_VERSION_MINOR: u32 = 1;
/// Patch version of the library that this header belongs to.
pub const TRISAP_VERSION_PATCH: u32 = 0;

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(version) => version,
    Err(_) => c"",
};

// The header cannot be written from the environment, so its numbers are compared with the crate's.
const _: () = {
    const fn number(digits: &str) -> u32 {
        match u32::from_str_radix(digits, 10) {
            Ok(number) => number,
            Err(_) => u32::MAX,
        }
    }
    assert!(number(env!("CARGO_PKG_VERSION_MAJOR")) == TRISAP_VERSION_MAJOR);
    assert!(number(env!("CARGO_PKG_VERSION_MINOR")) == TRISAP_VERSION_MINOR);
    assert!(number(env!("CARGO_PKG_VERSION_PATCH")) == TRISAP_VERSION_PATCH);
};

/// The ABI version of the linked library. If it differs from `TRISAP_ABI_VERSION`, call nothing else. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_abi_version() -> u32 {
    TRISAP_ABI_VERSION
}

/// The version of the linked library, as "1.2.3". O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_version() -> *const c_char {
    VERSION.as_ptr()
}

/// The instruction set that steps use on this CPU: "scalar", "avx2", or one of 128 bits: "sse4.1", "neon",
/// "simd128". Only the speed differs. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_instruction_set() -> *const c_char {
    let name = match Kernels::detect().name() {
        "scalar" => c"scalar",
        "avx2" => c"avx2",
        "neon" => c"neon",
        "simd128" => c"simd128",
        _ => c"sse4.1",
    };
    name.as_ptr()
}
