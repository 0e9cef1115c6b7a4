#!/usr/bin/env bash
# Fuzzes sequences of operations for so many seconds (60). Needs a nightly toolchain and cargo-fuzz (`cargo install cargo-fuzz`).
# Starts from the sequences in tests/fuzz/corpus and leaves new ones in the target folder; a fault stops it and is
# left in tests/fuzz/artifacts, where `tests/soak.sh FILE` repeats it. `tests/fuzz/run.sh --least` replaces the corpus by the
# fewest sequences that take the same paths.
#
#     tests/fuzz/run.sh [SECONDS] [OPTIONS OF LIBFUZZER]
set -euo pipefail
cd "$(dirname "$0")/.."
found="${CARGO_TARGET_DIR:-fuzz/target}/found"
mkdir -p "$found"
if [ "${1-}" = --least ]; then
    rm -rf fuzz/corpus.least && mkdir fuzz/corpus.least
    cargo +nightly fuzz run sequence fuzz/corpus.least "$found" fuzz/corpus -- -set_cover_merge=1 -max_len=408
    rm -r fuzz/corpus && mv fuzz/corpus.least fuzz/corpus
    exit
fi
seconds="${1:-60}"
[ $# -eq 0 ] || shift
cargo +nightly fuzz run sequence "$found" fuzz/corpus -- -max_len=408 -max_total_time="$seconds" "$@"
