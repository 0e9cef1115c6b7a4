#!/bin/sh
# Installs what the peers need, builds them, and races trisap against them:
#
#     tests/peers/run.sh [options] SCENE...
#     tests/peers/run.sh --table [options] [SCENE...]
#
# or draws chart.svg from such a table, by default the one of README.md:
#
#     tests/peers/run.sh --chart [FILE]
#
# Options are those of the program (see README.md). PEERS says which peers are built: `rust` (no C++ compiler needed),
# `physx` (these and PhysX) or `all`, the default. A peer that cannot be installed here is left out.
set -eu
here=$(dirname "$0")

if [ "${1-}" = --chart ]; then
    program=$(mktemp)
    trap 'rm -f "$program"' EXIT
    rustc --edition 2024 -o "$program" "$here/chart.rs"
    drawn=$("$program" <"${2-$here/README.md}")
    printf '%s\n' "$drawn" >"$here/chart.svg"
    echo "drawn: $here/chart.svg"
    exit
fi

install() {
    dpkg -s "$1" >/dev/null 2>&1 && return
    as_root=
    [ "$(id -u)" = 0 ] || as_root=sudo
    [ -n "${updated-}" ] || { $as_root apt-get update -qq && updated=yes; }
    $as_root apt-get install -y -qq --no-install-recommends "$1" >/dev/null
}
features=
case "${PEERS:-all}" in
rust | physx | all) ;;
*) echo "PEERS=$PEERS: rust, physx or all" >&2 && exit 2 ;;
esac
# PhysX is compiled with clang, as its crate and its authors do.
case "${PEERS:-all}" in
physx | all) install clang && features=$features,physx ;;
esac
if [ "${PEERS:-all}" = all ]; then
    features=$features,jolt,box3d
    install libembree-dev && features=$features,embree
    install libbullet-dev && features=$features,bullet
    install libtbb-dev && install libcgal-dev && features=$features,cgal
fi

# The rayon versions of parry3d and rapier3d are slower on one thread.
case " $* " in
*" --threads 2 "*) features=$features,parallel ;;
esac

cargo run --release --quiet --manifest-path "$here/Cargo.toml" --features "$features" -- "$@"
