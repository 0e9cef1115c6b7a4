#!/usr/bin/env bash
# Builds the WebAssembly modules of the package: `ffi/js/build.sh`, from anywhere. They go to ffi/js/wasm: trisap.wasm, and
# trisap-simd128.wasm for hosts with 128-bit vectors.
#
# Needs a Rust that can build for wasm32-unknown-unknown: that of rustup with this target, or Debian's packages rustc-web,
# cargo-web and rust-web-src, which come without the built core and build it here.
set -euo pipefail
cd "$(dirname "$0")"

target=wasm32-unknown-unknown
library=$(cd ../.. && rustc --print target-libdir --target $target 2>/dev/null || true)
if [[ -n "$library" && -d "$library" ]]; then
    build=(cargo rustc)
elif [[ -x /usr/bin/cargo && -d /usr/lib/rustlib/src/rust/library/core ]]; then
    export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
    build=(/usr/bin/cargo rustc -Zbuild-std=core)
else
    echo "no Rust for $target: rustup target add $target, or apt install rustc-web cargo-web rust-web-src" >&2
    exit 1
fi

# A panic would end in a trap. Debug information would be most of the file. The stack comes first in memory, so that an
# overflow traps, too; steps need less than 16 KiB.
export CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_STRIP=true CARGO_PROFILE_RELEASE_DEBUG=none
flags="-C link-arg=-zstack-size=131072"
folder=${CARGO_TARGET_DIR:-$(cd ../.. && pwd)/target}
mkdir -p wasm

# One folder each: other flags make everything anew.
one() {
    RUSTFLAGS="$flags $2" CARGO_TARGET_DIR="$folder/web/$1" "${build[@]}" --quiet --release --locked -p trisap-ffi --target $target \
        --no-default-features --features panic-handler --crate-type cdylib
    cp "$folder/web/$1/$target/release/trisap_ffi.wasm" "wasm/$1.wasm"
}
one trisap ""
one trisap-simd128 "-C target-feature=+simd128"

for file in wasm/*.wasm; do
    bytes=$(wc -c <"$file") packed=$(gzip -9nc "$file" | wc -c)
    echo "$file: $bytes bytes, $packed with gzip"
    # What the package promises of each of them.
    if ((bytes > 120 * 1024 || packed > 50 * 1024)); then
        echo "$file: more than 120 KiB, or 50 with gzip" >&2
        exit 1
    fi
done
