#!/usr/bin/env bash
# Counts the instructions of a step by callgrind, for three recordings and all kernels, and compares them with
# tests/instructions.txt: more than 5 % above it fails. `--write` writes the file anew. Needs valgrind, and installs it
# where it may. The counts are those of one compiler and one kind of CPU; they repeat exactly there.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v valgrind >/dev/null || { apt-get update -qq && apt-get install -y -qq valgrind; }
known=tests/instructions.txt
cargo build --quiet --release -p trisap-tests --example instructions
program="${CARGO_TARGET_DIR:-target}/release/examples/instructions"
log=$(mktemp)
trap 'rm -f "$log"' EXIT

count() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --collect-atstart=no --toggle-collect='*measured*' \
        "$program" "$1" "$2" >"$log" 2>&1 || { cat "$log"; exit 1; }
    local steps total
    steps=$(sed -n 's/^\([0-9]*\) object steps.*/\1/p' "$log")
    total=$(sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "$log")
    echo $((total / steps))
}

result=0
fresh=
for recording in freefall_cubes_1000 gravity_assorted_1000 brownian_cubes_8000; do
    for kernels in scalar avx2; do
        if [ "$kernels" = avx2 ] && ! grep -qw avx2 /proc/cpuinfo; then continue; fi
        now=$(count "$recording.aabbs" "$kernels")
        fresh+="$recording $kernels $now"$'\n'
        was=$(awk -v r="$recording" -v k="$kernels" '$1 == r && $2 == k { print $3 }' "$known" 2>/dev/null || true)
        echo "$recording, $kernels: $now instructions an object and step (recorded: ${was:-none})"
        if [ -n "$was" ] && [ $((now * 100)) -gt $((was * 105)) ]; then
            echo "more than 5 % above the recorded count" >&2
            result=1
        fi
    done
done
if [ "${1-}" = --write ]; then
    printf '%s' "$fresh" >"$known"
    result=0
fi
exit $result
