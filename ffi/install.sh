#!/usr/bin/env bash
# Builds trisap for C and C++ and installs it: `ffi/install.sh PREFIX`.
#
# Headers go to PREFIX/include, libtrisap.a and libtrisap.so with their CMake and pkg-config files to PREFIX/lib. The
# installed tree can be moved. Both libraries are built without std: they need abort, memcpy and memset, and nothing
# else. DESTDIR, CARGO and CARGO_TARGET_DIR mean what they usually mean; further arguments go to cargo.
set -euo pipefail

case "${1-}" in
"" | -*) echo "usage: ffi/install.sh PREFIX [CARGO ARGUMENTS]" >&2 && exit 2 ;;
esac
# A prefix may be relative to where the caller stands.
mkdir -p "${DESTDIR-}$1"
prefix="$(cd "${DESTDIR-}$1" && pwd)"
shift
cd "$(dirname "$0")"

abi=$(sed -n 's/^pub const TRISAP_ABI_VERSION: u32 = \([0-9]*\);$/\1/p' src/version.rs)
number() { sed -n "s/^pub const TRISAP_VERSION_$1: u32 = \([0-9]*\);$/\1/p" src/version.rs; }
version="$(number MAJOR).$(number MINOR).$(number PATCH)"

# Where cargo puts the libraries is told by cargo alone. Kinds are named one by one: with a Rust library among them there
# would be no optimisation across crates.
built=$(CARGO_PROFILE_RELEASE_PANIC=abort "${CARGO:-cargo}" rustc --release -p trisap-ffi \
    --no-default-features --features panic-handler --crate-type staticlib,cdylib \
    --message-format=json-render-diagnostics "$@")
library() { grep -o "\"[^\"]*/libtrisap_ffi\.$1\"" <<<"$built" | head -n 1 | tr -d '"'; }

include="$prefix/include" lib="$prefix/lib"
install -d "$include" "$lib/pkgconfig" "$lib/cmake/trisap"
install -m 644 ../include/*.h ../include/*.hpp "$include"
cp -R ../include/trisap_jobs "$include"
install -m 644 "$(library a)" "$lib/libtrisap.a"
install -m 755 "$(library so)" "$lib/libtrisap.so.$version"
ln -sf "libtrisap.so.$version" "$lib/libtrisap.so.$abi"
ln -sf "libtrisap.so.$abi" "$lib/libtrisap.so"

fill() { sed -e "s/@VERSION@/$version/g" -e "s/@ABI@/$abi/g" "$1"; }
fill pkg-config/trisap.pc.in >"$lib/pkgconfig/trisap.pc"
fill cmake/trisapConfig.cmake.in >"$lib/cmake/trisap/trisapConfig.cmake"
fill cmake/trisapConfigVersion.cmake.in >"$lib/cmake/trisap/trisapConfigVersion.cmake"
echo "installed trisap $version (ABI $abi) in $prefix"
