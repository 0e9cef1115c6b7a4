#!/usr/bin/env bash
# Tests of trisap-mpi on 1, 2, 3, 4 and 8 ranks of this machine, from anywhere: pairs, found and lost of all ranks against one
# world in each frame, restarts on other numbers of ranks, and faults. Needs Open MPI and libclang (Debian: libopenmpi-dev
# openmpi-bin libclang-dev). TRISAP_MPIRUN is another mpirun with its options.
set -euo pipefail
cd "$(dirname "$0")"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
missing=
command -v mpicc >/dev/null || missing+=" mpicc (libopenmpi-dev)"
command -v mpirun >/dev/null || missing+=" mpirun (openmpi-bin)"
[ -z "$missing" ] || { echo "missing:$missing" >&2 && exit 1; }
cargo fmt --check
cargo clippy --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
cargo test
cargo build

program="$CARGO_TARGET_DIR/debug/trisap-mpi-run"
# More ranks than cores: who waits gives way.
mpirun="${TRISAP_MPIRUN:-mpirun --oversubscribe --allow-run-as-root --mca mpi_yield_when_idle 1}"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
output="$folder/output"
checks=0

fail() {
    echo "failed: $*" >&2
    tail -20 "$output" >&2
    exit 1
}

# check RANKS ARGUMENTS: all answers as in one world. A run that hangs fails too.
check() {
    local ranks="$1"
    shift
    timeout 300 $mpirun -n "$ranks" "$program" --check --timeout 60 "$@" >"$output" 2>&1 || fail "$ranks ranks: $*"
    grep -q "all as in one world" "$output" || fail "$ranks ranks: $*"
    checks=$((checks + 1))
}

# Whether the column of the sums over all ranks is above a number: what a test is about has happened.
above() {
    awk -v at="$1" -v least="$2" '$1 == "all" { found = $(at + 1) > least } END { exit !found }' "$output" ||
        fail "column $1 is not above $2"
}

# exactly COLUMN NUMBER: the mean of each rank is that number.
exactly() {
    awk -v at="$1" -v number="$2" '
        $1 == "rank" { part++ }
        part == 1 && $1 ~ /^[0-9]+$/ { ranks++; other += $(at + 1) != number }
        END { exit !(ranks && !other) }' "$output" || fail "column $1 is not $2 on each rank"
}

# A rank without objects has taken part.
empty() {
    awk '$1 == "rank" { part++ } part == 1 && $1 ~ /^[0-9]+$/ && $2 == 0 { found = 1 } END { exit !found }' "$output" ||
        fail "no rank is empty"
}

recordings=../../tests/recordings
for ranks in 1 2 3 4 8; do
    echo "$ranks ranks"
    check "$ranks" --file "$recordings/freefall_cubes_1000.aabbs"
    check "$ranks" --file "$recordings/gravity_assorted_1000.aabbs" --overlap always
    check "$ranks" --file "$recordings/brownian_cubes_8000.aabbs"
    for overlap in never always; do
        check "$ranks" --scene brownian -n 2000 --frames 20 --overlap $overlap
        check "$ranks" --scene freefall --assorted -n 1000 --frames 40 --overlap $overlap
        check "$ranks" --scene gravity -n 1500 --frames 30 --overlap $overlap
        check "$ranks" --scene unbounded -n 600 --frames 30 --overlap $overlap
        check "$ranks" --scene corner -n 800 --frames 40 --overlap $overlap
        [ "$ranks" = 1 ] || above 13 0 # planes have moved
        check "$ranks" --scene corner -n 800 --frames 20 --fixed-planes --overlap $overlap
        check "$ranks" --scene lives -n 1200 --frames 30 --overlap $overlap
        # Growth from next to nothing, with all that comes and goes.
        check "$ranks" --scene lives -n 700 --frames 20 --room 2 --overlap $overlap
        check "$ranks" --scene unbounded -n 300 --frames 20 --room 2 --overlap $overlap
        # Fewer objects than ranks, and one object: some ranks are empty.
        check "$ranks" --scene scatter -n 3 --frames 40 --overlap $overlap
        check "$ranks" --scene scatter -n 1 --frames 40 --overlap $overlap
        [ "$ranks" = 1 ] || empty
        check "$ranks" --scene lives -n 5 --frames 60 --overlap $overlap
        check "$ranks" --scene scatter -n 2000 --frames 20 --overlap $overlap
        # One object in ten has come from another rank.
        [ "$ranks" = 1 ] || above 6 195
    done
    # Threads in each rank, alone and while messages travel.
    for overlap in never always; do
        check "$ranks" --scene brownian -n 20000 --frames 10 --threads 3 --overlap $overlap
        check "$ranks" --scene lives -n 12000 --frames 10 --threads 2 --overlap $overlap
    done
    # One reduction a step and no message to a rank that expects none, as long as boxes move by little.
    check "$ranks" --scene brownian -n 4000 --frames 30 --warm-up 12
    if [ "$ranks" != 1 ]; then
        exactly 11 0.0
        exactly 12 1.0
    fi
    for scene in town level ground:inf ground:1e4 lognormal bullets spawn hitch flat; do
        check "$ranks" --scene $scene -n 1000 --frames 15
    done
done

# Links end where there is nothing to tell, and begin anew: fewer messages than from each rank to each other one.
check 8 --scene scatter -n 3 --frames 300
awk '$1 == "all" { found = $11 < 56 && $12 > 0 } END { exit !found }' "$output" || fail "no link has ended"

timeout 100 $mpirun -n 3 "$program" --network >"$output" 2>&1 || fail "network"
[ "$(grep -cE '^(message|reduction) of .*: [0-9]' "$output")" = 3 ] || fail "network"

echo "restarts"
for ranks in 1 3 8; do
    rm -rf "$folder/saved"
    check "$ranks" --scene lives -n 900 --frames 8 --save "$folder/saved"
    for others in 1 2 3 4 8; do
        check "$others" --scene lives -n 900 --frames 16 --load "$folder/saved" --from 8
    done
done

# ends MESSAGE MOST COMMAND: the command fails with the message, and not later than so many seconds.
ends() {
    local message="$1" most="$2" begun=$SECONDS
    shift 2
    if timeout 100 "$@" >"$output" 2>&1; then fail "no fault: $*"; fi
    local took=$((SECONDS - begun))
    grep -q "$message" "$output" || fail "no message '$message': $*"
    [ "$took" -le "$most" ] || fail "took $took s: $*"
    if pgrep -f "$folder/tag" >/dev/null; then fail "a rank lives on: $*"; fi
    echo "$message: $took s"
    checks=$((checks + 1))
}

# Files that are not those of one scene, and one that has changed: no rank goes on.
refused() {
    if timeout 60 $mpirun -n 3 "$program" --scene lives -n 900 --frames 16 --load "$folder/saved" --from 8 >"$output" 2>&1
    then fail "no refusal: $1"; fi
    grep -q "$1" "$output" || fail "no message '$1'"
    checks=$((checks + 1))
}
mv "$folder/saved/rank5.trisap" "$folder/rank5"
refused "do not make one saved scene"
head -c -1 "$folder/rank5" >"$folder/saved/rank5.trisap"
refused "rank 2: .*file"
cp "$folder/saved/rank4.trisap" "$folder/saved/rank5.trisap"
refused "do not make one saved scene"

echo "faults"
faulty="--scene brownian -n 20000 --frames 1000000 --save $folder/tag --timeout 5"
for ranks in 2 4 8; do
    ends "exited on signal" 10 $mpirun -n "$ranks" "$program" $faulty --fault die@1:5
    ends "no .* within 5 s" 10 $mpirun -n "$ranks" "$program" $faulty --fault hang@1:5
    ends "different versions" 10 $mpirun -n "$ranks" "$program" $faulty --fault version@1:0
    ends "two objects have the key" 10 $mpirun -n "$ranks" "$program" $faulty --fault key@1:5
done

# signal NAME MESSAGE: a rank gets a signal while all of them step.
signal() {
    local begun victim runner
    $mpirun -n 4 "$program" $faulty --processes >"$output" 2>&1 &
    runner=$!
    for _ in $(seq 100); do
        sleep 0.2
        victim="$(sed -n 's/^rank 2 is process //p' "$output")"
        if [ -n "$victim" ] && grep -q "^frame" "$output"; then break; fi
    done
    [ -n "$victim" ] || fail "no process"
    begun=$SECONDS
    kill "-$1" "$victim"
    for _ in $(seq 150); do
        kill -0 "$runner" 2>/dev/null || break
        sleep 0.1
    done
    if kill -0 "$runner" 2>/dev/null; then kill -KILL "$runner"; fail "lives on after SIG$1"; fi
    if wait "$runner"; then fail "no fault after SIG$1"; fi
    [ $((SECONDS - begun)) -le 10 ] || fail "took $((SECONDS - begun)) s after SIG$1"
    grep -q "$2" "$output" || fail "no message after SIG$1"
    if pgrep -f "$folder/tag" >/dev/null; then fail "a rank lives on after SIG$1"; fi
    echo "SIG$1: $((SECONDS - begun)) s"
    checks=$((checks + 1))
}
signal KILL "exited on signal 9"
signal STOP "within 5 s"
echo "$checks runs passed"
