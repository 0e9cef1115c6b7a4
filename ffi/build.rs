//! Names the shared library as CMake installs it.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=src/version.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        // The number is the ABI version: programs find a library that speaks the ABI they were linked with.
        let version = include_str!("src/version.rs");
        let abi = version.split("TRISAP_ABI_VERSION: u32 = ").nth(1).and_then(|rest| rest.split(';').next());
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libtrisap.so.{}", abi.expect("the ABI version"));
        // Without std nobody else asks for memcpy and its like.
        println!("cargo:rustc-cdylib-link-arg=-lc");
    }
}
