#!/usr/bin/env bash
# Builds and installs trisap from its source archive, offline: `./build.sh PREFIX [CMAKE ARGUMENTS]`. Needs CMake, a C compiler
# and Rust.
set -euo pipefail
case "${1-}" in
"" | -*) echo "usage: ./build.sh PREFIX [CMAKE ARGUMENTS]" >&2 && exit 2 ;;
esac
mkdir -p "$1"
prefix="$(cd "$1" && pwd)"
shift
cd "$(dirname "$0")"
cmake -S ffi -B build -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" "$@"
cmake --build build
cmake --install build
