#!/usr/bin/env bash
# Random sequences of operations for so many hours on all processors. Prints what ran each minute, and in the end the sums.
# Stops at the first fault and leaves the sequence in soak-fault.bin, which `tests/soak.sh soak-fault.bin` repeats.
# With `forgeries` every second operation loads a forged snapshot.
#
#     tests/soak.sh HOURS [FIRST_SEED [forgeries]]
set -euo pipefail
folder="$(cd "$(dirname "$0")/.." && pwd)"
[ $# -ge 1 ] || { echo "usage: tests/soak.sh HOURS [FIRST_SEED [forgeries]] | tests/soak.sh FILE" >&2 && exit 2; }
target="${CARGO_TARGET_DIR:-$folder/target}"
cargo build --quiet --manifest-path "$folder/Cargo.toml" --release -p trisap-runs --bin soak --target-dir "$target"
soak="$target/release/soak"
if [ -f "$1" ]; then
    "$soak" "$1"
    exit
fi
seconds="$(awk "BEGIN { print int($1 * 3600) }")"
ran="$(mktemp)"
trap 'rm -f "$ran"' EXIT
"$soak" "$seconds" "${2:-$(date +%s)000000}" "${@:3}" | tee "$ran"
# The last report has all of the run.
tac "$ran" | sed '/^sequences/q' |
    awk '/ operations, / { operations += $1; steps += $3 }
        /^paths:/ { trees += $6 + $8 + $10 + $12 }
        /^loads:/ { refused += $5; loaded += $7 }
        END {
            printf "in all: %d operations, %d steps compared with brute force, %d of them in a tree; ", operations, steps, trees
            printf "forged: %d refused, %d loaded\n", refused, loaded
        }'
