#!/usr/bin/env bash
# Makes a source archive of trisap for C and C++ with the crates that it needs: `ffi/packaging/archive.sh FOLDER` writes
# FOLDER/trisap-VERSION.tar.gz. What it holds builds offline with the versions of Cargo.lock: `./build.sh PREFIX`.
set -euo pipefail
[ $# = 1 ] || { echo "usage: ffi/packaging/archive.sh FOLDER" >&2 && exit 2; }
mkdir -p "$1"
folder="$(cd "$1" && pwd)"
cd "$(dirname "$0")/../.."

version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
name=trisap-$version
staging=$(mktemp -d)
trap 'rm -rf "$staging"' EXIT
root=$staging/$name
mkdir -p "$root/ffi" "$root/.cargo"

cp -R include LICENSE-* Cargo.lock "$root"
cp -R ffi/src ffi/cmake ffi/pkg-config ffi/packaging ffi/build.rs ffi/CMakeLists.txt ffi/README.md ffi/examples "$root/ffi"
cp ffi/packaging/build.sh "$root"
for crate in core core/contacts ffi; do
    mkdir -p "$root/$crate"
    # What only tests need stays behind, and so do their crates.
    awk '/^\[/ { dropped = /^\[(dev-dependencies|target.*dev-dependencies)/ || /^\[\[(test|bench|example)\]\]/ } !dropped' \
        "$crate/Cargo.toml" >"$root/$crate/Cargo.toml"
done
cp -R core/src core/*.md "$root/core"
cp -R core/contacts/src "$root/core/contacts"
[ ! -e core/build.rs ] || cp core/build.rs "$root/core"
# Of the workspace these crates.
awk '/^default-members|^exclude/ { next } { sub(/^members = .*/, "members = [\"core\", \"core/contacts\", \"ffi\"]"); print }' Cargo.toml |
    grep -v '^trisap\(-tests\|-paper\)\? = ' >"$root/Cargo.toml"

cd "$root"
# Takes out of the lock file what is not needed any more, and changes no version.
cargo metadata --format-version 1 >/dev/null
cargo vendor --quiet --locked vendor >/dev/null
# Written here, since a quiet cargo does not print it any more.
cat >.cargo/config.toml <<'CONFIG'
[source.crates-io]
replace-with = "vendored-sources"

[source.vendored-sources]
directory = "vendor"

[net]
offline = true
CONFIG
# Always the same bytes for the same sources.
tar --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 -C "$staging" -c "$name" | gzip -n >"$folder/$name.tar.gz"
echo "$folder/$name.tar.gz"
