#!/usr/bin/env bash
# Prints the table of flash: the text of the program `flash`, which has 64 objects and room for 256 pairs, and what each
# capability adds to it. Optimised for size.
set -euo pipefail
cd "$(dirname "$0")"
. ../linker.sh
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}/boards"

text() {
    RUSTFLAGS=-Zemit-stack-sizes /usr/bin/cargo build --quiet --release -p trisap-firmware -Zbuild-std=core --target "$1" \
        --no-default-features --features "$2" --bin flash
    size -A "$CARGO_TARGET_DIR/$1/release/flash" | awk '$1 == ".text" { print $2 }'
}

targets=(thumbv7em-none-eabihf thumbv6m-none-eabi)
alone=()
for target in "${targets[@]}"; do alone+=("$(text $target "")"); done
echo "| capability | Cortex-M4 | Cortex-M0 |"
echo "|---|--:|--:|"
printf '| pairs alone | %d | %d |\n' "${alone[@]}"
for feature in lists events margins filters values rest shifts queries; do
    row=()
    for at in 0 1; do row+=($(($(text "${targets[at]}" $feature) - ${alone[at]}))); done
    printf '| %s | +%d | +%d |\n' $feature "${row[@]}"
done
