# To be sourced at the top of the repository. `prepare ENGINE PACKAGE` installs trisap below $root, a folder of the engine's own, and
# sets $package to the folder of the package that has the engine's sources.
prepare() {
    root="${CARGO_TARGET_DIR:-$PWD/target}/$1"
    mkdir -p "$root"
    cargo fetch --locked --quiet --manifest-path tests/cpp/hosts/Cargo.toml
    package=$(cargo metadata --locked --offline --format-version 1 --manifest-path tests/cpp/hosts/Cargo.toml |
        grep -o "\"manifest_path\":\"[^\"]*$2[^\"]*/Cargo.toml\"" | head -1 | cut -d'"' -f4)
    package=$(dirname "$package")
    cmake -S ffi -B "$root/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_LIBDIR=lib >/dev/null
    cmake --build "$root/build" >/dev/null
    cmake --install "$root/build" --prefix "$root/prefix" >/dev/null
}
