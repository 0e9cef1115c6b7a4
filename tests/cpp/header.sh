#!/usr/bin/env bash
# Generates include/trisap.h anew and compares it with the committed one; `--write` replaces that. Installs the version of
# cbindgen that it needs into the target folder, unless CBINDGEN names it.
set -euo pipefail
cd "$(dirname "$0")/../.."

version=0.29.2
root="${CARGO_TARGET_DIR:-target}/cbindgen"
cbindgen="${CBINDGEN:-$root/bin/cbindgen}"
if [ "$("$cbindgen" --version 2>/dev/null)" != "cbindgen $version" ]; then
    # Without optimisation: it runs for a second.
    cargo install cbindgen --debug --version "$version" --locked --quiet --root "$root" --target-dir "$root/build"
    cbindgen="$root/bin/cbindgen"
fi

generate() { "$cbindgen" --quiet --config ffi/cbindgen.toml --crate trisap-ffi --output "$1" ffi; }
case "${1-}" in
--write) generate include/trisap.h ;;
"")
    new=$(mktemp)
    trap 'rm -f "$new"' EXIT
    generate "$new"
    diff -u include/trisap.h "$new" || {
        echo "include/trisap.h is not that of the crate: run tests/cpp/header.sh --write" >&2
        exit 1
    }
    echo "include/trisap.h is that of the crate"
    ;;
*) echo "usage: tests/cpp/header.sh [--write]" >&2 && exit 2 ;;
esac
