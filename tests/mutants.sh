#!/usr/bin/env bash
# Mutation testing of the core by cargo-mutants: changes one operator or one function's result at a time, and says which changes
# no test notices. Runs the part PART of PARTS of all some 3,900 mutants (every PARTS-th one, so that a part is a sample of all files).
# What is not killed is judged in tests/mutants.txt, by a test, as equivalent or as speed only. A part of 40 takes about half an hour.
#
#     tests/mutants.sh PART [PARTS]      the list of what was not killed is left in target/mutants
set -euo pipefail
folder="$(cd "$(dirname "$0")/.." && pwd)"
[ $# -ge 1 ] || { echo "usage: tests/mutants.sh PART [PARTS]" >&2 && exit 2; }
part="$1" parts="${2:-40}"
for tool in cargo-mutants cargo-nextest; do
    command -v "$tool" >/dev/null || cargo install --locked "$tool"
done
files=()
for layer in sweep tree pairs lists snapshot query objects step; do
    files+=(--file "core/src/$layer/**")
done
# The quick tests that see most. A mutant that survives them is run against all tests by hand before it is judged.
quick='test(/^(edges|regressions|properties|sequences|golden|snapshots|queries|filters|capacity|forged)::/) or package(trisap-core)'
code=0
cargo mutants --dir "$folder" --package trisap-core "${files[@]}" --exclude-re 'impl (Debug|Display|Default)' \
    --shard "$part/$parts" --sharding round-robin --test-tool nextest --profile mutants --baseline run --minimum-test-timeout 300 \
    --test-package trisap-core --test-package trisap-tests --output "$folder/target/mutants" --no-shuffle --colors never \
    -- --lib --test '*' -E "$quick" || code=$?
# 2 and 3: some were missed, or took too long.
[ "$code" -le 3 ] || exit "$code"
out="$folder/target/mutants/mutants.out"
echo "part $part of $parts: $(wc -l <"$out/caught.txt") killed, $(wc -l <"$out/timeout.txt") ran for ever, $(wc -l <"$out/unviable.txt") do not compile, $(wc -l <"$out/missed.txt") not killed:"
cat "$out/missed.txt"
