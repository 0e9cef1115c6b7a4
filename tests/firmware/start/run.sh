#!/usr/bin/env bash
# Builds the program in Rust for three boards and the one in C for one, and runs them in QEMU. Needs what `../run.sh` needs, and
# clang; with rustup's own targets `cargo run --release --target thumbv7em-none-eabihf` does the same as the lines here.
set -euo pipefail
cd "$(dirname "$0")"
. ../../linker.sh
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../target}/start"

for target in thumbv7em-none-eabihf thumbv6m-none-eabi riscv32imac-unknown-none-elf; do
    /usr/bin/cargo build --quiet --release -Zbuild-std=core --target "$target"
    if [ $target = riscv32imac-unknown-none-elf ] && ! command -v qemu-system-riscv32 >/dev/null; then
        echo "$target: built, not run: that needs the package qemu-system-misc"
        continue
    fi
    told=$(timeout 60 /usr/bin/cargo run --quiet --release -Zbuild-std=core --target "$target" </dev/null)
    [ "$(grep -c 'are near$' <<<"$told")" = 7 ] && [ "$(grep -c 'part$' <<<"$told")" = 7 ] || { echo "$told"; exit 1; }
    echo "$target: the first program runs"
done

# In C: the static library, a header, no C library.
CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_OPT_LEVEL=s /usr/bin/cargo rustc --quiet --release --manifest-path ../../../ffi/Cargo.toml \
    --no-default-features --features events,panic-handler --crate-type staticlib -Zbuild-std=core --target thumbv7em-none-eabihf
library=$CARGO_TARGET_DIR/thumbv7em-none-eabihf/release/libtrisap_ffi.a
program=$CARGO_TARGET_DIR/start-in-c
clang --target=thumbv7em-none-eabihf -mcpu=cortex-m4 -mfloat-abi=hard -Os -std=c11 -Wall -Wextra -Werror -ffreestanding \
    -ffunction-sections -fdata-sections -I ../../../include -c c/main.c -o "$program.o"
ld.lld-22 --gc-sections -T c/mps2.ld "$program.o" "$library" -o "$program"
timeout 60 qemu-system-arm -M mps2-an386 -display none -monitor none -serial none -semihosting-config enable=on,target=native \
    -kernel "$program" </dev/null
echo "the same in C runs"
