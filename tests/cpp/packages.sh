#!/usr/bin/env bash
# Builds, installs and consumes trisap by each way that takes minutes: `tests/cpp/packages.sh`, or some of them by name.
# CMake and pkg-config are quick: `cargo test -p trisap-ffi`.
#
#     cargo-c    cargo cinstall, which is compiled first; programs find the library by pkg-config and CMake
#     archive    the source archive, built offline in a folder of its own with nothing but its own crates
#     conan      a Conan package, made and consumed; Conan comes from PyPI
#     vcpkg      the portfile, with stand-ins for vcpkg's own functions
#     windows    the library by mingw-w64, static and shared; its C tests run under Wine
#     mingw      the same with rustup's own target for Windows, x86_64-pc-windows-gnu
#     msvc       the static library by Microsoft's ABI, with clang and lld-link; the C tests run under Wine
#     macos      the static library, compiled and looked at
#     small      one level of vectors, optimised for size: a whole program of at most 250 KB
#
# A way that this machine has no tools for says that it is skipped; with TRISAP_NO_SKIP=1 it fails.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ $# -gt 0 ] || set -- cargo-c archive conan vcpkg windows mingw msvc macos small

root="${CARGO_TARGET_DIR:-$PWD/target}/packages"
mkdir -p "$root"
source=$PWD
consumers=$PWD/tests/cpp/consumers

# A C program and a C++ program by pkg-config, and all that CMake offers.
consume() {
    local prefix=$1 pc
    pc=$(dirname "$(find "$prefix" -name trisap.pc)")
    rm -rf "$prefix-consumer"
    mkdir -p "$prefix-consumer"
    (cd "$prefix-consumer" && PKG_CONFIG_PATH=$pc make -s -B -f "$consumers/pkg-config/Makefile" SOURCES="$consumers")
    for program in c_shared c_static cpp_shared; do
        "$prefix-consumer/$program"
    done
}

consume_by_cmake() {
    local prefix=$1 build=$1-cmake
    rm -rf "$build"
    cmake -S "$consumers/cmake" -B "$build" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
    cmake --build "$build" >/dev/null
    ctest --test-dir "$build" --output-on-failure
}

# What a way takes from Debian, whose compiler builds core for targets that Debian does not ship it for.
packages_for() {
    case $1 in
    windows) echo rustc-web cargo-web rust-web-src gcc-mingw-w64-x86-64 g++-mingw-w64-x86-64 wine wine64 ;;
    msvc) echo rustc-web cargo-web rust-web-src clang llvm lld-22 gcc-mingw-w64-x86-64 wine wine64 ;;
    macos) echo rustc-web cargo-web rust-web-src ;;
    esac
}

is_installed() { dpkg -s $(packages_for "$1") >/dev/null 2>&1; }

# What a way needs that this machine has not and cannot get.
lacks() {
    local commands=(cargo cc c++ make cmake ctest pkg-config)
    case $1 in
    cargo-c) commands=(cargo cc c++ make pkg-config readelf) ;;
    conan) commands=(cargo cc c++ cmake python3) ;;
    windows | msvc | macos) commands=(dpkg apt-get) ;;
    mingw) commands=(rustup cmake x86_64-w64-mingw32-gcc) ;;
    esac
    for command in "${commands[@]}"; do
        command -v "$command" >/dev/null || echo "$command"
    done
    if [ -n "$(packages_for "$1")" ] && command -v dpkg >/dev/null && ! is_installed "$1" && [ "$(id -u)" != 0 ]; then
        packages_for "$1"
    fi
}

debian() {
    if ! is_installed "$1"; then
        apt-get update -qq
        apt-get install -y -qq --no-install-recommends $(packages_for "$1")
    fi
    . tests/linker.sh
    export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
}

cargo_c() {
    local version=0.10.24+cargo-0.98.0 tools="${CARGO_C:-$root/cargo-c}" prefix=$root/cargo-c-prefix
    if [ "$("$tools/bin/cargo-cinstall" --version 2>/dev/null | grep -o '[0-9.]*+cargo-[0-9.]*')" != "$version" ]; then
        # Without optimisation: it does little itself.
        cargo install cargo-c --debug --version "$version" --locked --quiet --config profile.dev.debug=false \
            --root "$tools" --target-dir "$root/cargo-c-build"
    fi
    rm -rf "$prefix"
    PATH=$tools/bin:$PATH CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_DEBUG=false CARGO_TERM_QUIET=true \
        cargo cinstall --release --locked -p trisap-ffi --no-default-features --features full,panic-handler,validate,sse41,avx2 --prefix "$prefix" --libdir "$prefix/lib" \
        --target-dir "$root/cargo-c-target"
    # The names are those of CMake.
    local abi
    abi=$(sed -n 's/^pub const TRISAP_ABI_VERSION: u32 = \([0-9]*\);$/\1/p' ffi/src/version.rs)
    readelf -d "$prefix/lib/libtrisap.so" | grep -F "[libtrisap.so.$abi]"
    for file in include/trisap.h include/trisap.hpp include/trisap_jobs/jolt.hpp lib/libtrisap.a share/licenses/trisap/LICENSE-MIT; do
        test -e "$prefix/$file"
    done
    consume "$prefix"
}

archive() {
    local folder=$root/archive prefix=$root/archive-prefix archive
    rm -rf "$folder" "$prefix"
    archive=$(ffi/packaging/archive.sh "$folder")
    tar -C "$folder" -xzf "$archive"
    # No registry and no home to find crates in; and no network, where a user may leave it.
    local offline=(env CARGO_HOME="$folder/home" CARGO_TARGET_DIR="$folder/target")
    if unshare -rn true 2>/dev/null; then
        offline=(unshare -rn "${offline[@]}")
    fi
    "${offline[@]}" RUSTC="$(rustc --print sysroot)/bin/rustc" "$(rustc --print sysroot)/bin/cargo" --version
    "${offline[@]}" PATH="$(rustc --print sysroot)/bin:$PATH" "${archive%.tar.gz}/build.sh" "$prefix"
    ! grep -aF "$folder" "$prefix/lib/libtrisap.a" "$prefix/lib/libtrisap.so"
    consume "$prefix"
    consume_by_cmake "$prefix"
    ls -l "$archive"
}

conan() {
    local tools=$root/conan
    [ -x "$tools/bin/conan" ] || { python3 -m venv "$tools" && "$tools/bin/pip" install --quiet 'conan>=2,<3'; }
    export CONAN_HOME=$root/conan-home CARGO_TARGET_DIR=$root/conan-target
    [ -e "$CONAN_HOME/profiles/default" ] || "$tools/bin/conan" profile detect
    # It needs no other package; and its test is built elsewhere than in the sources.
    local create=("$tools/bin/conan" create ffi/packaging/conan --no-remote --build=missing
        -c "tools.cmake.cmake_layout:test_folder=$root/conan-test" -c tools.cmake.cmaketoolchain:user_presets=)
    "${create[@]}"
    "${create[@]}" -o 'trisap/*:shared=True'
}

vcpkg() {
    local packages=$root/vcpkg
    rm -rf "$packages"
    cmake -DPORT="$source/ffi/packaging/vcpkg" -DPACKAGES="$packages" -P tests/cpp/consumers/vcpkg.cmake
    consume_by_cmake "$packages"
}

windows() {
    debian windows
    local build=$root/windows prefix=$root/windows-prefix
    cmake -S ffi -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Windows -DCMAKE_C_COMPILER=x86_64-w64-mingw32-gcc \
        -DCMAKE_INSTALL_PREFIX="$prefix" -DTRISAP_TARGET=x86_64-pc-windows-gnu -DTRISAP_CARGO=/usr/bin/cargo \
        -DTRISAP_CARGO_ARGUMENTS=-Zbuild-std=core -DTRISAP_CARGO_FOLDER="$root/debian"
    cmake --build "$build"
    cmake --install "$build"
    local flags=(-std=c11 -O2 -Wall -Wextra -Werror "-I$prefix/include")
    for test in life misuse regressions; do
        x86_64-w64-mingw32-gcc "${flags[@]}" "tests/cpp/$test.c" -o "$build/$test.exe" -static "$prefix/lib/libtrisap.a"
        x86_64-w64-mingw32-gcc "${flags[@]}" "tests/cpp/$test.c" -o "$build/${test}_dll.exe" "$prefix/lib/libtrisap.dll.a"
    done
    x86_64-w64-mingw32-g++ -std=c++17 "-I$prefix/include" "$consumers/main.cpp" -o "$build/cpp.exe" -static "$prefix/lib/libtrisap.a"
    cp "$prefix/bin/trisap.dll" "$build"
    for program in life misuse regressions life_dll misuse_dll regressions_dll cpp; do
        WINEPREFIX=$root/wine WINEDEBUG=-all /usr/lib/wine/wine64 "$build/$program.exe"
        echo "$program.exe: passed"
    done
}

mingw() {
    local build=$root/mingw wine
    rustup target add x86_64-pc-windows-gnu 2>/dev/null
    cmake -S ffi -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Windows -DCMAKE_C_COMPILER=x86_64-w64-mingw32-gcc \
        -DTRISAP_TARGET=x86_64-pc-windows-gnu -DTRISAP_CARGO_FOLDER="$build/cargo" >/dev/null
    cmake --build "$build"
    wine=$(command -v wine64 || ls /usr/lib/wine/wine64 2>/dev/null || true)
    for test in life misuse regressions; do
        x86_64-w64-mingw32-gcc -std=c11 -O2 -Wall -Wextra -Werror -Iinclude "tests/cpp/$test.c" -o "$build/$test.exe" -static "$build/libtrisap.a"
        x86_64-w64-mingw32-gcc -std=c11 -O2 -Iinclude "tests/cpp/$test.c" -o "$build/${test}_dll.exe" "$build/libtrisap.dll.a"
        for program in "$test" "${test}_dll"; do
            if [ -n "$wine" ]; then
                WINEPREFIX=$root/wine WINEDEBUG=-all "$wine" "$build/$program.exe"
            else
                echo "skipped: $program.exe is not run, for want of wine64"
                [ -z "${TRISAP_NO_SKIP-}" ] || exit 1
            fi
        done
    done
}

msvc() {
    debian msvc
    local build=$root/msvc system=/usr/x86_64-w64-mingw32
    # There are no libraries of Microsoft's to try the compiler with.
    cmake -S ffi -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Windows -DCMAKE_C_COMPILER=clang \
        -DCMAKE_C_COMPILER_TARGET=x86_64-pc-windows-msvc -DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY \
        -DTRISAP_TARGET=x86_64-pc-windows-msvc -DTRISAP_SHARED=OFF -DTRISAP_CARGO=/usr/bin/cargo \
        -DTRISAP_CARGO_ARGUMENTS=-Zbuild-std=core -DTRISAP_CARGO_FOLDER="$root/debian"
    cmake --build "$build"
    # Microsoft's ABI with headers and import libraries of mingw-w64. The runtime is Windows' own (UCRT), as with Visual Studio; what
    # its start-up code and its stack probe would bring comes from here.
    local compile=(clang --target=x86_64-pc-windows-msvc -std=c11 -O2 -Wall -Wextra -Werror -fno-ms-compatibility -fdeclspec -U_MSC_VER
        -D__MINGW32__ -D__MINGW64__ -D_UCRT -isystem "$system/include" -Iinclude -c)
    echo '#include <stdlib.h>
        int main(void); void start(void); int _fltused; void start(void) { exit(main()); }' | "${compile[@]}" -x c - -o "$build/start.obj"
    for test in life misuse regressions; do
        "${compile[@]}" "tests/cpp/$test.c" -o "$build/$test.obj"
        lld-link-22 -nologo -subsystem:console -entry:start -nodefaultlib -alternatename:__chkstk=___chkstk_ms "-out:$build/$test.exe" \
            "$build/$test.obj" "$build/start.obj" "$build/trisap.lib" "$system/lib/libucrt.a" "$system/lib/libkernel32.a" \
            "$(x86_64-w64-mingw32-gcc -print-libgcc-file-name)"
        WINEPREFIX=$root/wine WINEDEBUG=-all /usr/lib/wine/wine64 "$build/$test.exe"
        echo "$test.exe: passed"
    done
}

macos() {
    debian macos
    local build=$root/macos symbols
    # There is no linker for macOS here, and a static library needs none.
    CARGO_PROFILE_RELEASE_PANIC=abort CARGO_PROFILE_RELEASE_DEBUG=false /usr/bin/cargo rustc --quiet --release --locked -p trisap-ffi \
        --no-default-features --features full,panic-handler,validate --crate-type staticlib -Zbuild-std=core --target aarch64-apple-darwin \
        --target-dir "$root/debian"
    mkdir -p "$build"
    cp "$root/debian/aarch64-apple-darwin/release/libtrisap_ffi.a" "$build/libtrisap.a"
    symbols=$(strings "$build/libtrisap.a" | grep -c '^_trisap_' || true)
    echo "libtrisap.a for aarch64-apple-darwin: $symbols names"
    [ "$symbols" -gt 30 ]
}

small() {
    local build=$root/small code
    cmake -S ffi -B "$build" -DCMAKE_BUILD_TYPE=Release -DTRISAP_LEVELS=avx2 -DTRISAP_CPU=x86-64-v3 -DTRISAP_SMALL=ON \
        -DTRISAP_CARGO_FOLDER="$build/cargo" >/dev/null
    cmake --build "$build" >/dev/null
    cc -std=c11 -O2 -Iinclude "$consumers/main.c" "$build/libtrisap.a" -Wl,--gc-sections -s -o "$build/main"
    if grep -qw avx2 /proc/cpuinfo; then
        "$build/main"
    fi
    code=$(size "$build/main" | tail -1 | awk '{ print $1 + $2 }')
    echo "code and data of a program with one level of vectors: $code bytes"
    [ "$code" -le 256000 ]
}

for way in "$@"; do
    missing=$(lacks "$way" | tr '\n' ' ')
    if [ -n "$missing" ]; then
        echo "skipped: $way, for want of: $missing"
        [ -z "${TRISAP_NO_SKIP-}" ] || exit 1
        continue
    fi
    case $way in
    cargo-c) (cargo_c) ;;
    archive | conan | vcpkg | windows | mingw | msvc | macos | small) ("$way") ;;
    *) echo "usage: tests/cpp/packages.sh [cargo-c | archive | conan | vcpkg | windows | mingw | msvc | macos | small ...]" >&2 && exit 2 ;;
    esac
    echo "$way: passed"
done
