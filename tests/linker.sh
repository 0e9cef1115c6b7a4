# To be sourced by scripts that build with Debian's compiler: it calls the linker of bare targets `rust-lld`, which Debian has
# under another name. Needs the package lld-22.
if ! command -v rust-lld >/dev/null && command -v lld-22 >/dev/null; then
    linkers=$(mktemp -d)
    ln -s "$(command -v lld-22)" "$linkers/rust-lld"
    PATH=$PATH:$linkers
fi
