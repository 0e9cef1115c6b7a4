//! Prints the hashes of the recordings by each kernel of this CPU, once where they agree: the table `tests/golden.txt`.

use trisap_core::Kernels;
use trisap_tests::golden;
use trisap_tests::worlds::Setup;

fn main() {
    let reference = golden::table(Setup::REFERENCE);
    for kernels in Kernels::all() {
        let setup = Setup { kernels, ..Setup::REFERENCE };
        assert_eq!(golden::table(setup), reference, "{} kernels", kernels.name());
    }
    print!("{reference}");
}
