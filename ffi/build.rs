//! Names the shared library as `install.sh` installs it.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        // The number is the ABI version: programs find a library that speaks the ABI they were linked with.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libtrisap.so.3");
        // Without std nobody else asks for memcpy and its like.
        println!("cargo:rustc-cdylib-link-arg=-lc");
    }
}
