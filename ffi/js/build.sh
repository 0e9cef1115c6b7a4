#!/usr/bin/env bash
# Builds the WebAssembly modules of the package: `ffi/js/build.sh`, from anywhere. They go to ffi/js/wasm: trisap.wasm,
# trisap-simd128.wasm for hosts with 128-bit vectors, and trisap-pairs.wasm for these, with pairs alone.
# `ffi/js/build.sh --parts` also says what fills them, part by part of the library, with `--functions` behind it function by function.
#
# Needs node with npm, and a Rust that can build core for wasm32-unknown-unknown: Debian's packages rustc-web, cargo-web,
# rust-web-src and lld-22, or rustup's with its component rust-src.
set -euo pipefail
cd "$(dirname "$0")"

. ../../tests/linker.sh
target=wasm32-unknown-unknown
if [[ -x /usr/bin/cargo && -d /usr/lib/rustlib/src/rust/library/core ]]; then
    export RUSTC=/usr/bin/rustc
    cargo=/usr/bin/cargo
elif [[ -d "$(cd ../.. && rustc --print sysroot 2>/dev/null)/lib/rustlib/src/rust/library/core" ]]; then
    cargo=cargo
else
    echo "no source of Rust's core: apt install rustc-web cargo-web rust-web-src lld-22, or rustup component add rust-src" >&2
    exit 1
fi
export RUSTC_BOOTSTRAP=1
[[ -d node_modules/binaryen ]] || npm ci --no-audit --no-fund --loglevel=error

parts=false
[[ "${1-}" == --parts ]] && parts=true && shift
options=("$@")

# A panic ends in a trap, without a text. The stack comes first in memory, so that an overflow traps, too; steps need less
# than 16 KiB of it. Less inlining saves much of the file and costs little time; loops that are there once instead of once for each
# outcome of a test in them, or of whose turns none is written out unless all are, cost none, nor do loops that count with one number
# for all of their arrays, or those that are vectors where the core says so and nowhere else.
export CARGO_PROFILE_RELEASE_PANIC=immediate-abort CARGO_PROFILE_RELEASE_STRIP=none CARGO_PROFILE_RELEASE_DEBUG=none
flags="-C link-arg=-zstack-size=131072 -C llvm-args=-inline-threshold=40 -C llvm-args=-unswitch-threshold=0 -C llvm-args=-unroll-runtime=false"
flags+=" -C llvm-args=-disable-lsr -C no-vectorize-loops -C no-vectorize-slp"
folder=${CARGO_TARGET_DIR:-$(cd ../.. && pwd)/target}
mkdir -p wasm
# They belong to what is packed.
cp ../../LICENSE-* .

# One folder each: other flags make everything anew.
one() {
    RUSTFLAGS="$flags $3" CARGO_TARGET_DIR="$folder/web/$1" "$cargo" rustc -Zbuild-std=core -Zpanic-immediate-abort \
        --quiet --release --locked -p trisap-ffi --target $target --no-default-features --features "$4,panic-handler" \
        --crate-type cdylib
    local linked="$folder/web/$1/$target/release/trisap_ffi.wasm"
    node optimise.js "$linked" "wasm/$1.wasm" "$2"
    if $parts; then
        node optimise.js "$linked" "$folder/web/$1-named.wasm" "$2" names
        echo "$1.wasm:"
        node parts.js "$folder/web/$1-named.wasm" "${options[@]}"
    fi
}
# So does less unrolling; but with vectors, short loops that are not unrolled get none.
vectors="-C target-feature=+simd128 -C llvm-args=-unroll-threshold=120"
one trisap scalar "-C llvm-args=-unroll-threshold=30" full
one trisap-simd128 simd128 "$vectors" full
one trisap-pairs pairs "$vectors" large

# The same as a text, for programs of one file.
{ printf 'export default "'; base64 -w0 wasm/trisap-simd128.wasm; echo '";'; } >wasm/trisap-simd128.js

for file in wasm/*.wasm; do
    bytes=$(wc -c <"$file") packed=$(gzip -9nc "$file" | wc -c)
    echo "$file: $bytes bytes, $packed with gzip"
    # Growth does not go unnoticed.
    most=105
    [[ "$file" != *-pairs.wasm ]] || most=70
    if ((packed > most * 1024)); then
        echo "$file: more than $most KiB with gzip" >&2
        exit 1
    fi
done
