#!/usr/bin/env bash
# Counts the instructions of a step by callgrind, for three recordings and where all move in predicted boxes, without and with events,
# and of queries, for all kernels, and the branches that its model of a predictor guesses wrong, and compares them with
# tests/instructions.txt: more than 5 % above it fails, and more than 10 % of wrong guesses, as they are few. `--write` writes the file
# anew. Needs valgrind, and installs it where it may. The counts are those of one compiler and one kind of CPU; they repeat exactly
# there.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v valgrind >/dev/null || { apt-get update -qq && apt-get install -y -qq valgrind; }
known=tests/instructions.txt
cargo build --quiet --release -p trisap-runs --bin instructions
program="${CARGO_TARGET_DIR:-target}/release/instructions"
log=$(mktemp)
trap 'rm -f "$log"' EXIT

count() {
    valgrind --tool=callgrind --branch-sim=yes --callgrind-out-file=/dev/null --collect-atstart=no --toggle-collect='*measured*' \
        "$program" "$@" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
    # Instructions, conditional branches, of these wrong, jumps through a register, of these wrong. In tenths what is wrong; and
    # instructions in hundredths.
    awk '/^[0-9]+ object steps/ { steps = $1 } /Collected :/ { sub(/.*Collected : /, ""); total = $1; wrong = $3 + $5 }
        END { printf "%d %d %d\n", total / steps, 10 * wrong / steps, 100 * total / steps }' "$log"
}

result=0
fresh=
# compare NAME KERNELS WHAT ARGUMENTS...: a name in the file, what is counted, and what the program is called with.
compare() {
    local name=$1 kernels=$2 what=$3 counted now wrong was were
    shift 3
    counted=$(count "$@") || exit 1
    read -r now wrong hundredths <<<"$counted"
    fresh+="$name $kernels $now $wrong"$'\n'
    read -r was were < <(awk -v n="$name" -v k="$kernels" '$1 == n && $2 == k { print $3, $4 }' "$known" 2>/dev/null) || true
    echo "$name, $kernels: $now instructions (recorded: ${was:-none}) and $wrong tenths of a wrong guess (${were:-none}) $what"
    if [ -n "$was" ] && [ $((now * 100)) -gt $((was * 105)) ]; then
        echo "more than 5 % above the recorded count" >&2
        result=1
    fi
    if [ -n "$were" ] && [ $((wrong * 100)) -gt $((were * 110 + 100)) ]; then
        echo "more than 10 % above the recorded wrong guesses" >&2
        result=1
    fi
}
for kernels in scalar avx2; do
    if [ "$kernels" = avx2 ] && ! grep -qw avx2 /proc/cpuinfo; then continue; fi
    for recording in freefall_cubes_1000 gravity_assorted_1000 brownian_cubes_8000; do
        compare $recording $kernels "an object and step" $recording.aabbs $kernels
    done
    compare quiet $kernels "an object and step" brownian_cubes_8000.aabbs $kernels quiet
    without=$hundredths
    compare quiet_events $kernels "an object and step" brownian_cubes_8000.aabbs $kernels quiet_events
    # Where nobody leaves the predicted box, events cost next to nothing.
    if [ $((hundredths * 50)) -gt $((without * 51)) ]; then
        echo "events cost more than 2 % of a quiet step, $kernels: $without and $hundredths hundredths" >&2
        result=1
    fi
    for query in regions nearest rays; do
        compare $query $kernels "a query" brownian_cubes_8000.aabbs $kernels $query
    done
done
if [ "${1-}" = --write ]; then
    printf '%s' "$fresh" >"$known"
    result=0
fi
exit $result
