#!/bin/sh
# Installs what the peers need, builds them, and races trisap against them:
#
#     tests/peers/run.sh [options] FILE.aabbs...
#
# Options are those of the program (see README.md). A peer that cannot be installed here is left out.
set -eu
here=$(dirname "$0")

features=jolt,box3d
install() {
    dpkg -s "$1" >/dev/null 2>&1 && return
    as_root=
    [ "$(id -u)" = 0 ] || as_root=sudo
    [ -n "${updated-}" ] || { $as_root apt-get update -qq && updated=yes; }
    $as_root apt-get install -y -qq --no-install-recommends "$1" >/dev/null
}
# PhysX is compiled with clang, as its crate and its authors do.
install clang
install libembree-dev && features=$features,embree
install libbullet-dev && features=$features,bullet
install libtbb-dev && install libcgal-dev && features=$features,cgal

# The rayon versions of parry3d and rapier3d are slower on one thread.
case " $* " in
*" --threads 2 "*) features=$features,parallel ;;
esac

cargo run --release --quiet --manifest-path "$here/Cargo.toml" --features "$features" -- "$@"
