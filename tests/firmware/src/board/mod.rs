//! What the programs need of the machine that they run on, and all `unsafe` of this package.

#[cfg(target_arch = "arm")]
mod arm;
#[cfg(target_os = "none")]
mod bare;
#[cfg(not(target_os = "none"))]
mod host;
#[cfg(target_arch = "riscv32")]
mod riscv;

#[cfg(target_os = "none")]
pub use bare::{argument, exit, instructions, print, spin, stack};
#[cfg(not(target_os = "none"))]
pub use host::{argument, instructions, print, spin, stack};

/// Makes a function without arguments, which returns the exit code, the program: on a board after the reset, on
/// the host as usual.
#[macro_export]
macro_rules! entry {
    ($run:path) => {
        #[cfg(target_os = "none")]
        #[unsafe(no_mangle)]
        fn trisap_main() -> u8 {
            $run()
        }

        #[cfg(not(target_os = "none"))]
        fn main() -> std::process::ExitCode {
            $run().into()
        }
    };
}
