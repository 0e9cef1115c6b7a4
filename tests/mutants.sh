#!/usr/bin/env bash
# Mutation testing of the core. cargo-mutants lists the mutants: one operator, arm or result of a function is another. All of them
# are compiled into one copy of the core, each behind a switch (tests/mutants), so that a mutant costs a run of sequences of
# operations and no build. What fails, or comes to another tally than the core as it is, is killed; the rest is to be judged.
# A sample of one mutant in SAMPLE is spread over all files of the core but its kernels; it is always the same one.
#
# `mutants.txt` has those that were judged; others that are not noticed are listed in the end, by their change and function, as lines
# move. The script fails where more than one in six are not noticed: then the sequences do not do what they should.
#
#     tests/mutants.sh [SAMPLE [FILES]]      FILES: parts of paths, as core/src/sweep/,core/src/tree/; by default those of the table
#                                            the results are left in target/mutants/results.txt
set -euo pipefail
folder="$(cd "$(dirname "$0")/.." && pwd)"
sample="${1:-10}"
files="${2:-core/src/sweep/,core/src/tree/,core/src/pairs/,core/src/objects/,core/src/step/,core/src/snapshot/,core/src/query/}"
command -v cargo-mutants >/dev/null || cargo install --locked cargo-mutants
out="${CARGO_TARGET_DIR:-$folder/target}/mutants"
tree="$out/tree" unviable="$out/unviable.txt" excluded="$out/excluded.txt" results="$out/results.txt" stages="$out/stages.txt"
mkdir -p "$out" && rm -rf "$tree" "$unviable" "$results" && mkdir "$tree"
cargo build --quiet --release --manifest-path "$folder/tests/mutants/Cargo.toml" --target-dir "$out/tool"
tool="$out/tool/release/trisap-mutants"
cargo mutants --dir "$folder" --list --json --package trisap-core --exclude 'core/src/simd/**' \
    --exclude-re 'impl (Debug|Display|Default)' >"$out/list.json"
git -C "$folder" ls-files -z | (cd "$folder" && tar --null -cf - -T -) | tar -xf - -C "$tree"

# Those that do not compile are found by the compiler, and taken out.
export RUSTFLAGS="--cap-lints=warn -Awarnings"
while true; do
    "$tool" switch "$out/list.json" "$folder" "$tree" "$unviable"
    (cd "$tree" && cargo check --quiet -p trisap-core --features validate --message-format=json --target-dir "$out/check" 2>/dev/null || true) >"$out/messages"
    said="$("$tool" blame "$tree" "$unviable" <"$out/messages")"
    [ "$said" != "0 do not compile" ] || break
    echo "$said"
done
cargo build --quiet --release --manifest-path "$tree/tests/mutants/play/Cargo.toml" \
    --target-dir "$out/play"
play="$out/play/release/trisap-mutants-play"
: >"$stages"
stage() {
    echo "$1 $play ${*:2} $("$play" "${@:2}" | sed -n 's/^hash: //p')" >>"$stages"
}
stage 12 0 40 60
stage 60 1000 400 100
"$tool" exclude "$out/list.json" "$unviable" "$files" >"$excluded"
"$tool" run "$out/list.json" "$excluded" "$stages" "$results" "$(nproc)" "$sample"
echo "$(grep -c ' killed' "$results" || true) killed, $(grep -c ' for-ever' "$results" || true) ran for ever, $(grep -c ' survived' "$results" || true) not noticed"
# A change and its function, without the line.
change() {
    sed -E 's/:[0-9]+:[0-9]+:/:/'
}
new="$(grep -E ' (survived|for-ever-[0-9]) ' "$results" | cut -d' ' -f4- | change | sort -u |
    comm -23 - <(cut -f2 "$folder/tests/mutants.txt" | change | sort -u))"
[ -z "$new" ] || { echo "to be judged, as they are not in tests/mutants.txt:" && echo "$new"; }
[ "$(($(grep -c ' survived' "$results" || true) * 6))" -le "$(wc -l <"$results")" ]
