#!/usr/bin/env bash
# Random sequences of operations for so many hours on all processors, half of the time in a build whose leaves have 16 objects instead of
# 512. Prints what ran each minute, and in the end the sums of all turns. Stops at the first fault and leaves the sequence in
# soak-fault.bin, which `tests/soak.sh soak-fault.bin` repeats (in both builds). With `forgeries` every second operation loads a forged
# snapshot.
#
#     tests/soak.sh HOURS [FIRST_SEED [forgeries]]
set -euo pipefail
folder="$(cd "$(dirname "$0")/.." && pwd)"
[ $# -ge 1 ] || { echo "usage: tests/soak.sh HOURS [FIRST_SEED [forgeries]] | tests/soak.sh FILE" >&2 && exit 2; }
target="${CARGO_TARGET_DIR:-$folder/target}"
build() {
    cargo build --quiet --manifest-path "$folder/Cargo.toml" --release -p trisap-runs --bin soak --target-dir "$1"
}
build "$target"
RUSTFLAGS="${RUSTFLAGS-} --cfg fuzzing" build "$target/small-trees"
soaks=("$target/small-trees/release/soak" "$target/release/soak")
if [ -f "$1" ]; then
    for soak in "${soaks[@]}"; do "$soak" "$1"; done
    exit
fi
# Short turns, so that neither build waits for the other's hours.
seconds="$(awk "BEGIN { print int($1 * 3600) }")"
seed="${2:-$(date +%s)000000}"
turn=$((seconds / 2 < 600 ? seconds / 2 : 600))
ran="$(mktemp)"
trap 'rm -f "$ran" "$ran.turn"' EXIT
for ((done = 0; done + 2 * turn <= seconds && turn > 0; done += 2 * turn)); do
    for soak in "${soaks[@]}"; do
        "$soak" "$turn" "$seed" "${@:3}" | tee "$ran.turn"
        # Of a turn the last report counts: each has all of the turn so far.
        tac "$ran.turn" | sed '/^sequences/q' >>"$ran"
    done
    seed=$((seed + 100000000))
done
awk '/ operations, / { operations += $1; steps += $3 }
    /^paths:/ { trees += $6 + $8 + $10 + $12 }
    /^loads:/ { refused += $5; loaded += $7 }
    END {
        printf "in all: %d operations, %d steps compared with brute force, %d of them in a tree; ", operations, steps, trees
        printf "forged: %d refused, %d loaded\n", refused, loaded
    }' "$ran"
