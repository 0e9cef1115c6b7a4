#!/usr/bin/env bash
# Builds the C ABI, and the core with it, for bare-metal targets against `core` alone: any use of std or alloc, or of an
# atomic that the target lacks, is an error there. From the repository's root; needs Debian's rustc-web, cargo-web and
# rust-web-src, and installs them where it may.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! dpkg -s rustc-web cargo-web rust-web-src >/dev/null 2>&1; then
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends rustc-web cargo-web rust-web-src
fi
# The settings and the folder of tests/firmware, so that both share the `core` that is built for a target.
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zemit-stack-sizes
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/tests/firmware/target}/boards"
export CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_OPT_LEVEL=s
for target in thumbv7em-none-eabihf thumbv6m-none-eabi riscv32imac-unknown-none-elf; do
    /usr/bin/cargo rustc --quiet --release -p trisap-ffi --no-default-features --features full,panic-handler \
        --crate-type staticlib -Zbuild-std=core --target "$target"
done
echo "the core and the C ABI build without std and alloc"
