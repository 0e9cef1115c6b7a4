#!/usr/bin/env bash
# Runs the kernels on CPUs that Bochs emulates: all of them must give the same bytes. Also shows that AVX2 is taken only
# where the CPU has it and its registers are kept, and that wrong operations are found. From anywhere; needs the packages
# below, and installs them where it may.
set -euo pipefail
cd "$(dirname "$0")"

packages=(binutils bochs)
if ! dpkg -s "${packages[@]}" >/dev/null 2>&1; then
    [ "$(id -u)" = 0 ] || { echo "please install: apt-get install ${packages[*]}" >&2 && exit 2; }
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends "${packages[@]}"
fi

target=${CARGO_TARGET_DIR:-$PWD/target}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Makes a ROM of the program in a directory: rom FOLDER TARGET NAME
rom() {
    (cd "$1" && CARGO_TARGET_DIR="$2" RUSTFLAGS="${RUSTFLAGS-} --cfg agreement" cargo build --quiet --release)
    objcopy -O binary "$2/release/trisap-emulated" "$work/$3"
}

# Changes a number at the end of a ROM: poke NAME BYTES_FROM_THE_END ESCAPED_BYTE
poke() {
    printf "$3" | dd of="$work/$1" bs=1 seek=$((2 * 1024 * 1024 - $2)) conv=notrunc status=none
}

# Prints what the program says on a CPU: boot CPU ROM
boot() {
    # There is no display; the one that waits for nobody is the remote one. No video BIOS either, but a file must be named.
    head -c 512 /dev/zero >"$work/none"
    cat >"$work/configuration" <<CONFIGURATION
config_interface: textconfig
display_library: rfb, options="timeout=0"
plugin_ctrl: unmapped=1, biosdev=0, speaker=0, extfpuirq=0, parallel=0, serial=0, gameport=0, iodebug=0
cpu: model=$1, count=1, ips=1000000000, reset_on_triple_fault=0
memory: guest=64, host=64
romimage: file=$work/$2
vgaromimage: file=$work/none
vga: extension=none
pci: enabled=0
port_e9_hack: enabled=1
panic: action=fatal
error: action=report
info: action=ignore
log: $work/log
CONFIGURATION
    # For builds of Bochs that start in its debugger, as Debian's does.
    printf 'continue\nquit\n' >"$work/commands"
    # It ends by a panic, and so with a failure.
    timeout 1200 bochs -q -f "$work/configuration" -rc "$work/commands" </dev/null 2>&1 \
        | tee "$work/output" | grep -aE '^(levels|operations|\||all levels|the levels|a world|panicked)' || true
}

# Stops unless the last boot has said a line.
said() {
    grep -aqxF "$1" "$work/output" || { echo "not said: $1" >&2 && tail -5 "$work/log" >&2 && exit 1; }
}

rom . "$target" rom

# CPUs with AVX2.
cp "$work/rom" "$work/levels"
poke levels 4 '\001'
for cpu in corei7_icelake_u corei7_haswell_4770; do
    boot $cpu levels
    said "levels: scalar sse4.1 avx2; detected: avx2"
done
# Older ones: without AVX, with an AVX that is not enough, without POPCNT, and without vectors that are any use.
for cpu in corei5_lynnfield_750 zambezi; do
    boot $cpu levels
    said "levels: scalar sse4.1; detected: sse4.1"
done
for cpu in core2_penryn_t9600 athlon64_clawhammer; do
    boot $cpu levels
    said "levels: scalar; detected: scalar"
done

# An operating system that does not keep the wide registers.
poke levels 8 '\003'
boot corei7_haswell_4770 levels
said "levels: scalar sse4.1; detected: sse4.1"

# Wrong operations are found: bytes compared as signed ones on two levels, a row left out of a window.
mkdir "$work/copy" "$work/copy/tests"
cp -r ../../Cargo.toml ../../core "$work/copy"
cp -r ../recordings "$work/copy/tests"
mkdir "$work/copy/tests/emulated"
cp -r Cargo.toml Cargo.lock build.rs machine.ld src "$work/copy/tests/emulated"
copy=$work/copy/core/src/simd
sed -i -e '0,/_mm256_subs_epu8/s/_mm256_subs_epu8/_mm256_subs_epi8/' -e 's/count.min(N)/count.min(N - 1)/' "$copy/vectors/avx2.rs"
sed -i 's/_mm_subs_epu8/_mm_subs_epi8/' "$copy/vectors/sse41.rs"
[ "$(diff -r ../../core/src/simd "$copy" | grep -c '^>')" = 4 ]
rom "$work/copy/tests/emulated" "$target" wrong
boot corei7_icelake_u wrong
for level in sse4.1 avx2; do
    found=$(sed -n "s/^operations of $level .*: \(.*\)\.$/\1/p" "$work/output" | tr ' ' '\n' | sort | xargs)
    [ "$found" = "half_window window" ] || { echo "found of $level are: $found" >&2 && exit 1; }
done
said "the levels differ"

# All the rest: all levels, and what the older CPU has with its own instructions alone.
for cpu in corei5_lynnfield_750 corei7_icelake_u; do
    boot $cpu rom
    said "all levels give the same bytes"
done
