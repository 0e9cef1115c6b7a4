#!/usr/bin/env bash
# ThreadSanitizer over whatever runs on several threads: parts of the core, the executors of the conformance tests, sequences of
# operations whose twin runs on threads, the pool of the std adapter, and C++ programs with job systems of their own. std is
# built with it too, by Debian's compiler; the runtime is clang's. From anywhere; needs the packages below, and installs them
# where it may.
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(rustc-web cargo-web rust-web-src clang libclang-rt-14-dev)
if ! dpkg -s "${packages[@]}" >/dev/null 2>&1; then
    [ "$(id -u)" = 0 ] || { echo "please install: apt-get install ${packages[*]}" >&2 && exit 2; }
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends "${packages[@]}"
fi
target=x86_64-unknown-linux-gnu
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}/threads"
folder="$CARGO_TARGET_DIR/programs"
mkdir -p "$folder"
# Debian's clang is older than its rustc, and its runtime has these functions under their plain names alone.
cat >"$folder/names.c" <<'NAMES'
#include <string.h>
void *__tsan_memcpy(void *to, const void *from, size_t bytes) { return memcpy(to, from, bytes); }
void *__tsan_memmove(void *to, const void *from, size_t bytes) { return memmove(to, from, bytes); }
void *__tsan_memset(void *to, int byte, size_t bytes) { return memset(to, byte, bytes); }
NAMES
clang -O1 -fno-builtin -fPIC -c "$folder/names.c" -o "$folder/names.o"
export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_LINKER=clang
export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-Zsanitizer=thread -Zexternal-clangrt -Clink-arg=-fsanitize=thread -Clink-arg=$folder/names.o --cfg=fuzzing"
export TSAN_OPTIONS="halt_on_error=1 ${TSAN_OPTIONS-}"
on() {
    local command=$1
    shift
    /usr/bin/cargo "$command" --quiet -Zbuild-std=std,panic_unwind,panic_abort --target "$target" \
        --config profile.dev.package.std.opt-level=2 --config profile.dev.package.core.opt-level=2 \
        --config profile.dev.package.alloc.opt-level=2 "$@"
}
# A race that there is on purpose: where it is not seen, nothing below says anything.
cat >"$folder/race.rs" <<'RACE'
static mut SUM: u32 = 0;
fn main() {
    let add = || (0..1_000_000_u32).for_each(|_| unsafe { SUM ^= 1 });
    std::thread::scope(|scope| {
        scope.spawn(add);
        scope.spawn(add);
    });
}
RACE
cat >"$folder/Cargo.toml" <<'RACE'
[package]
name = "race"
version = "0.0.0"
edition = "2021"
[[bin]]
name = "race"
path = "race.rs"
[workspace]
RACE
if on run --manifest-path "$folder/Cargo.toml" >"$folder/race.txt" 2>&1 || ! grep -q "data race" "$folder/race.txt"; then
    cat "$folder/race.txt" && echo "ThreadSanitizer does not see a race" >&2 && exit 1
fi
on test -p trisap-core --lib threads
on test -p trisap-core --lib parallel::
on test -p trisap --lib
on test -p trisap-tests --test conformance executors::
on test -p trisap-tests --test conformance sequences::
# The C ABI, linked into programs that clang instruments too.
on rustc --release -p trisap-ffi --lib --crate-type staticlib
for source in tests/cpp/jobs.cpp ffi/examples/engine.cpp; do
    program="$folder/$(basename "$source" .cpp)"
    clang++ -std=c++17 -O1 -g -fsanitize=thread -DTRISAP_THREADS -Iinclude "$source" -o "$program" \
        "$CARGO_TARGET_DIR/$target/release/libtrisap.a" "$folder/names.o" -pthread -ldl -lm
    "$program"
done
echo "ThreadSanitizer has seen no race"
