#!/usr/bin/env bash
# The gates, from anywhere in the repository. Quick ones by default; `--all` adds the slow ones: more random cases,
# a million objects, more pairs than 32 bits can count, other targets, the package for the web, packages for C and
# C++, Windows under Wine, many ranks where Open MPI is installed, the folder of recordings that TRISAP_RECORDINGS names, a sample of
# mutants, and Miri where it is installed.
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1-}" in
"") all=false ;;
--all) all=true ;;
*) echo "usage: tests/gates.sh [--all]" >&2 && exit 2 ;;
esac

# One target folder: what the workspaces below have in common is checked once.
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
cargo fmt --all --check
cargo clippy --workspace --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps
cargo check -p trisap-core --features glam
# Each capability alone, and none.
for feature in "" large lists events margins filters values; do
    cargo clippy -p trisap-core --no-default-features --features "$feature" -- -D warnings
    cargo clippy -p trisap-ffi --no-default-features --features "std $feature" -- -D warnings
done
cargo clippy --manifest-path tests/loom/Cargo.toml -- -D warnings
(cd tests/firmware && cargo fmt --all --check && cargo clippy --workspace --all-targets -- -D warnings)
# It calls what is compiled for such programs alone.
(cd tests/emulated && cargo fmt --check && RUSTFLAGS="--cfg agreement" cargo clippy -- -D warnings)
(cd tests/fuzz && cargo fmt --check)
cargo test --workspace
# What only a build without debug assertions does: indices out of range are reported instead of ending the program.
cargo test --release -p trisap-core --test steps faults

if $all; then
    TRISAP_EFFORT="${TRISAP_EFFORT:-20}" cargo test --release -p trisap-tests
    TRISAP_EFFORT="${TRISAP_EFFORT:-20}" cargo test --release -p trisap-ffi random_operations
    TRISAP_EFFORT="${TRISAP_EFFORT:-20}" cargo test --release -p trisap-ffi sequences::
    tests/soak.sh 0.1
    tests/mutants.sh 60
    if cargo +nightly fuzz --version >/dev/null 2>&1; then
        tests/fuzz/run.sh 60
    else
        echo "skipped: cargo-fuzz is not installed"
    fi
    cargo run --release -p trisap-runs --bin million
    cargo run --release -p trisap-runs --bin overflow
    # The same where an overflow ends the program.
    CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS=true cargo run --release -p trisap-runs --bin overflow
    tests/instructions.sh
    tests/web.sh
    tests/targets.sh
    tests/cpp/packages.sh
    # Jolt on trisap.
    tests/cpp/jolt/run.sh
    # Box3D on trisap.
    tests/cpp/box3d/test.sh
    # avian3d, with trisap as its broad phase, with the compiler that it needs.
    rustup run --install 1.97.1 cargo test --release --manifest-path std-adapter/avian/Cargo.toml
    if command -v mpirun >/dev/null; then
        CARGO_TARGET_DIR="$PWD/std-adapter/mpi/target" std-adapter/mpi/test.sh
    else
        echo "skipped: Open MPI is not installed"
    fi
    if cargo +nightly miri --version >/dev/null 2>&1; then
        MIRIFLAGS=-Zmiri-many-seeds=0..32 cargo +nightly miri test -p trisap-core --lib threads_
        cargo +nightly miri test -p trisap-tests --test conformance executors::a_small_tree
        # Threads that look at one world: see `Look::world`.
        MIRIFLAGS=-Zmiri-tree-borrows cargo +nightly miri test -p trisap-ffi --test abi border::
    else
        echo "skipped: Miri is not installed"
    fi
fi
echo "all gates passed"
