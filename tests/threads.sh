#!/usr/bin/env bash
# ThreadSanitizer over whatever runs on several threads: parts of the core, the executors of the conformance tests, sequences of
# operations whose twin runs on threads, the pool of the std adapter, and C++ programs with job systems of their own. std is
# built with it too. Needs clang and a nightly toolchain, whose runtime it is, and the sources of std: those of nightly (`rustup
# component add --toolchain nightly rust-src`), or Debian's with its compiler and a linker that finds old names of the C library
# (packages rustc-web, cargo-web, rust-web-src and lld-22). Says so and skips all where they are missing.
set -euo pipefail
cd "$(dirname "$0")/.."

target=x86_64-unknown-linux-gnu
sysroot="$(rustc +nightly --print sysroot 2>/dev/null || true)"
runtime="$sysroot/lib/rustlib/$target/lib/librustc-nightly_rt.tsan.a"
flags=-Zsanitizer=thread
linker=ld
if ! [ -f "$runtime" ] || ! command -v clang++ >/dev/null; then
    echo "skipped: ThreadSanitizer needs a nightly toolchain, and clang"
    exit
elif [ -d "$sysroot/lib/rustlib/src/rust/library/std" ]; then
    cargo=(cargo +nightly)
elif [ -d /usr/lib/rustlib/src/rust/library/std ] && [ -x /usr/bin/cargo ] && [ -x /usr/bin/ld.lld-22 ]; then
    # Debian's compiler has no runtime of its own.
    cargo=(/usr/bin/cargo)
    linker=/usr/bin/ld.lld-22
    export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
    flags+=" -Zexternal-clangrt -Clinker=clang -Clink-arg=-fuse-ld=$linker"
    for argument in -Wl,--whole-archive "$runtime" -Wl,--no-whole-archive -lm -lpthread -ldl -lc -lresolv -lrt; do
        flags+=" -Clink-arg=$argument"
    done
else
    echo "skipped: ThreadSanitizer needs the sources of std: rust-src of nightly, or Debian's rust-web-src, rustc-web and cargo-web, and lld-22"
    exit
fi
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}/threads"
export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="$flags"
export TSAN_OPTIONS="halt_on_error=1 ${TSAN_OPTIONS-}"
on() {
    local command=$1
    shift
    "${cargo[@]}" "$command" --quiet -Zbuild-std --target "$target" --config profile.dev.package.std.opt-level=2 \
        --config profile.dev.package.core.opt-level=2 --config profile.dev.package.alloc.opt-level=2 "$@"
}
# A race that there is on purpose: where it is not seen, nothing below says anything.
folder="$CARGO_TARGET_DIR/programs"
mkdir -p "$folder"
cat >"$folder/race.rs" <<'RACE'
static mut SUM: u32 = 0;
fn main() {
    // They take turns: of a thread that has ended nothing may be known any more.
    let add = || {
        (0..2000).for_each(|_| {
            unsafe { SUM ^= 1 };
            std::thread::yield_now();
        });
    };
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
on test -p trisap --lib --example job_system --example task_graph
on test -p trisap-tests --test conformance executors::
on test -p trisap-tests --test conformance sequences::
# The C ABI, linked into programs that clang instruments, with the same runtime.
on rustc --release -p trisap-ffi --lib --crate-type staticlib
watch() {
    local source=$1 program
    shift
    program="$folder/$(basename "$source" .cpp)"
    clang++ -std=c++17 -O1 -g -fsanitize=thread -Iinclude -isystem /usr/include/bullet \
        ${TRISAP_ENKITS:+-DWITH_ENKITS -isystem "$TRISAP_ENKITS/src"} -c "$source" -o "$program.o"
    clang++ -fuse-ld="$linker" "$program.o" "$CARGO_TARGET_DIR/$target/release/libtrisap_ffi.a" \
        -Wl,--whole-archive "$runtime" -Wl,--no-whole-archive "$@" -pthread -ldl -lm -lrt -lresolv -o "$program"
    "$program" threads
}
watch tests/cpp/jobs.cpp
watch ffi/examples/engine.cpp
# Rays from several threads, right after boxes were set.
if [ -d /usr/include/bullet ]; then
    watch tests/cpp/bullet/changes.cpp -lBulletDynamics -lBulletCollision -lLinearMath
else
    echo "skipped: libbullet-dev is not installed: no rays through the Bullet adapter"
fi
echo "ThreadSanitizer has seen no race"
