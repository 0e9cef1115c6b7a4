#!/usr/bin/env bash
# Builds and tests trisap for targets other than this machine's: 32-bit x86, which this CPU runs; AArch64 and a big-endian
# target (s390x), which QEMU runs; WebAssembly, which node runs. All of them must give the hashes of tests/golden.txt.
# From anywhere; needs the packages below, and installs them where it may.
#
#     tests/targets.sh             all of it
#     tests/targets.sh i686 ...    one target or several: i686, aarch64, s390x, wasm
#     tests/targets.sh --quick     the core's own tests on i686
set -euo pipefail
cd "$(dirname "$0")/.."

quick=false
case "${1-}" in
"") set -- i686 aarch64 s390x wasm ;;
--quick) quick=true && set -- i686 ;;
esac

# Debian's gcc-multilib would do for i686, but it cannot be installed beside the compilers for other machines.
packages=(rustc-web cargo-web rust-web-src)
for target in "$@"; do
    case $target in
    i686) packages+=(gcc-i686-linux-gnu libc6-dev-i386-cross) ;;
    aarch64) packages+=(gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc qemu-user) ;;
    s390x) packages+=(gcc-s390x-linux-gnu libc6-dev-s390x-cross qemu-user) ;;
    wasm) packages+=(lld-22 wasi-libc) ;;
    *) echo "usage: tests/targets.sh [--quick | i686 | aarch64 | s390x | wasm ...]" >&2 && exit 2 ;;
    esac
done
# Whatever node there is will do.
case " $* " in *" wasm "*) command -v node >/dev/null || packages+=(nodejs) ;; esac
if ! dpkg -s "${packages[@]}" >/dev/null 2>&1; then
    [ "$(id -u)" = 0 ] || { echo "please install: apt-get install ${packages[*]}" >&2 && exit 2; }
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends "${packages[@]}"
fi

# The bootstrap switch lets Debian's compiler build std for targets that Debian does not ship it for.
. tests/linker.sh
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}/targets"
export CARGO_TARGET_I686_UNKNOWN_LINUX_GNU_LINKER=i686-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_S390X_UNKNOWN_LINUX_GNU_LINKER=s390x-linux-gnu-gcc
export CARGO_TARGET_I686_UNKNOWN_LINUX_GNU_RUNNER="/usr/i686-linux-gnu/lib/ld-linux.so.2 --library-path /usr/i686-linux-gnu/lib"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
export CARGO_TARGET_S390X_UNKNOWN_LINUX_GNU_RUNNER="qemu-s390x -L /usr/s390x-linux-gnu"

# Debian's libc for WASI is older than what std asks for: it has no threads that say that there are none. Whatever is missing
# becomes a trap.
wasi=/usr/lib/wasm32-wasi
export CARGO_TARGET_WASM32_WASIP1_LINKER=wasm-ld-22
export CARGO_TARGET_WASM32_WASIP1_RUSTFLAGS="-Lnative=$wasi -Clink-self-contained=no -Clink-arg=$wasi/crt1-command.o -Clink-arg=--unresolved-symbols=ignore-all"

# What std has in machine code is in every test: it is optimised as in a std that is shipped. Debug assertions stay on in
# the crates of the workspace, so that a sum that leaves 32 bits stops a test.
on() {
    local command=$1 target=$2
    shift 2
    local settings=()
    for crate in core alloc std compiler_builtins; do
        settings+=(--config "profile.dev.package.$crate.opt-level=2")
    done
    /usr/bin/cargo "$command" --quiet -Zbuild-std=std,panic_unwind,panic_abort "${settings[@]}" --target "$target" "$@"
}

core_tests() {
    on test "$1" -p trisap-core --lib --test steps
}

# Golden hashes are among these.
conformance() {
    on test "$1" -p trisap-tests --lib --test conformance
}

# The same, each module in a process of its own: QEMU keeps memory of all tests of a process, 24 GB after 190 of them.
conformance_by_module() {
    local module modules
    on test "$1" -p trisap-tests --lib
    modules=$(on test "$1" -p trisap-tests --test conformance -- --list | sed -n 's/::.*: test$//p' | sort -u)
    [ -n "$modules" ]
    for module in $modules; do
        on test "$1" -p trisap-tests --test conformance -- "$module::"
    done
}

# The instructions of a step on AArch64, by each of its kernels: those of ten steps more of the same program.
instructions() {
    gcc -O2 -shared -fPIC -o "$CARGO_TARGET_DIR/count.so" tests/targets/count.c
    on build aarch64-unknown-linux-gnu --release -p trisap-runs --bin instructions
    local program=$CARGO_TARGET_DIR/aarch64-unknown-linux-gnu/release/instructions
    local qemu=(qemu-aarch64 -L /usr/aarch64-linux-gnu) log steps first all
    log=$(mktemp)
    for recording in freefall_cubes_1000 gravity_assorted_1000 brownian_cubes_8000; do
        for kernels in $("${qemu[@]}" "$program"); do
            counted() {
                "${qemu[@]}" -plugin "$CARGO_TARGET_DIR/count.so" "$program" "$recording.aabbs" "$kernels" "$1" >"$log" 2>&1
                sed -n 's/^\([0-9]*\) instructions$/\1/p' "$log"
            }
            first=$(counted 0)
            all=$(counted 10)
            steps=$(sed -n 's/^\([0-9]*\) object steps.*/\1/p' "$log")
            echo "$recording, $kernels: $(((all - first) / steps)) instructions an object and step"
        done
    done
    rm "$log"
}

for target in "$@"; do
    case $target in
    i686)
        core_tests i686-unknown-linux-gnu
        $quick || conformance i686-unknown-linux-gnu
        ;;
    aarch64)
        core_tests aarch64-unknown-linux-gnu
        conformance_by_module aarch64-unknown-linux-gnu
        # Exit code 1 if a single pair of the recording is wrong.
        on run aarch64-unknown-linux-gnu -p trisap-program
        instructions
        ;;
    s390x)
        core_tests s390x-unknown-linux-gnu
        on run s390x-unknown-linux-gnu -p trisap-runs --bin golden | diff tests/golden.txt -
        ;;
    wasm)
        # Threads, files that are written and processes are not there: only what is hashed on one thread runs.
        CARGO_PROFILE_DEV_PANIC=abort on build wasm32-wasip1 -p trisap-runs --bin golden
        node --no-warnings tests/targets/wasi.mjs "$CARGO_TARGET_DIR/wasm32-wasip1/debug/golden.wasm" \
            | diff tests/golden.txt -
        ;;
    esac
    echo "$target: passed"
done
