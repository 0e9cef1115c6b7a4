#!/usr/bin/env bash
# Jolt on trisap: `tests/cpp/jolt/run.sh`. Its own performance test has to end in the same state, bit for bit, with its own broad phase
# and with trisap, on one thread and on several; in each step both find the same pairs, and the same answers to casts; and so they do
# while bodies come, go and change. Prints the steps a second of both by the clock, and their processor time. Compiles Jolt, which takes
# minutes the first time; its sources come in a package of crates.io.
set -euo pipefail
cd "$(dirname "$0")/../../.."

. tests/cpp/hosts/prepare.sh
prepare jolt joltc-sys
jolt=$package/JoltC/JoltPhysics
make -s -j "${JOBS:-2}" -C "$root" -f "$PWD/tests/cpp/jolt/Makefile" JOLT="$jolt" TRISAP="$PWD" LIBRARY="$root/prefix/lib/libtrisap.a"

cd "$root"
./life
# Where bodies move and hardly touch.
for threads in 1 2; do
    for broad_phase in own trisap; do
        echo "$broad_phase: $("./many_$broad_phase" 16000 "$threads" 60)"
    done
done
steps=${STEPS:-300}
for scene in ConvexVsMesh Pyramid; do
    # Motion quality, threads, steps a second, hash.
    lines() {
        local lines TIMEFORMAT="$1: %U s of processor time"
        lines=$(time ./"$1" "-s=$scene" "-i=$2" "$3" | grep '^\(Discrete\|LinearCast\), ')
        echo "$lines" | tee >(cat >&2)
    }
    for threads in 1 2; do
        echo "$scene: Jolt's own broad phase" >&2
        own=$(lines own "$steps" "-t=$threads" | sed 's|, [0-9]*[.][0-9]*,|,|')
        echo "$scene: trisap" >&2
        ours=$(lines trisap "$steps" "-t=$threads" | sed 's|, [0-9]*[.][0-9]*,|,|')
        [ "$(wc -l <<<"$own")" = 2 ]
        diff <(echo "$own") <(echo "$ours")
    done
    ./shadow "-s=$scene" "-i=$steps" -t=2 | grep '^the same: [1-9]'
done
