#!/usr/bin/env bash
# Builds the firmware for three bare-metal targets, runs it in QEMU, compares it with the host and proves what is said
# of its binaries. From anywhere; needs the packages below, and installs them where it may. With `--write` it puts the
# tables that it prints into the README instead of comparing them.
set -euo pipefail
cd "$(dirname "$0")"

packages=(rustc-web cargo-web rust-web-src lld-22 clang qemu-system-arm)
if ! dpkg -s "${packages[@]}" >/dev/null 2>&1; then
    [ "$(id -u)" = 0 ] || { echo "please install: apt-get install ${packages[*]}" >&2 && exit 2; }
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends "${packages[@]}"
fi

. ../linker.sh

# One compiler for the host and the boards. The bootstrap switch lets it build `core` for targets that Debian does not
# ship, and tell the frames of functions.
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"

# Programs for a board: build TARGET PROGRAMS... All are in one directory, so that `core` is built once for a target; with
# other features a program takes the place of the one before.
boards=$CARGO_TARGET_DIR/boards
build() {
    local target=$1
    shift
    RUSTFLAGS=-Zemit-stack-sizes CARGO_TARGET_DIR="$boards" \
        /usr/bin/cargo build --quiet --release -p trisap-firmware -Zbuild-std=core --target "$target" "$@"
}

# Runs a binary on the board of its target, with an argument.
run() {
    local binary=$1 argument=$2 machine
    shift 2
    case $binary in
    */thumbv7em-none-eabihf/*) machine=(qemu-system-arm -M mps2-an386) ;;
    */thumbv6m-none-eabi/*) machine=(qemu-system-arm -M microbit) ;;
    *) machine=(qemu-system-riscv32 -M virt -bios none) ;;
    esac
    timeout 300 "${machine[@]}" "$@" -display none -monitor none -serial none -chardev stdio,id=out \
        -semihosting-config "enable=on,target=native,chardev=out,arg=program,arg=$argument" -kernel "$binary" </dev/null
}

# The exit code of a command that must fail.
failure() {
    local code=0
    "$@" >&2 || code=$?
    echo "$code"
}

# Small builds with all capabilities, with each of them, and with none find what brute force finds.
for features in events,margins,filters,values events margins filters values ""; do
    /usr/bin/cargo test --quiet --no-default-features --features "validate,$features" --test small
done
# With debug assertions: on the host the same frames also stop at a broken invariant.
/usr/bin/cargo build --quiet --workspace
tools=$CARGO_TARGET_DIR/debug
expected=$("$tools/replay")
echo "the host's hash of all pairs: $expected"

for target in thumbv7em-none-eabihf thumbv6m-none-eabi riscv32imac-unknown-none-elf; do
    programs=(--bin replay --bin calls --bin around)
    build $target "${programs[@]}"
    release=$boards/$target/release

    if [ $target != riscv32imac-unknown-none-elf ] || command -v qemu-system-riscv32 >/dev/null; then
        run "$release/replay" "$expected"
        # The comparison can fail.
        [ "$(failure run "$release/replay" "x$expected")" = 1 ]
        run "$release/calls" "" >/dev/null
        run "$release/around" "" >/dev/null
        echo "$target: runs, and all pairs are the host's"
    else
        echo "$target: built, not run: that needs the package qemu-system-misc"
    fi
done

for target in thumbv7em-none-eabihf thumbv6m-none-eabi riscv32imac-unknown-none-elf; do
    "$tools/inspect" "$boards/$target/release/replay" --sizes sizes.txt
done
# The tables of the README.
tables=$CARGO_TARGET_DIR/tables.txt
"$tools/bytes" | tee "$tables"
printf '\n| board | calls | stack |\n|---|---|--:|\n' >>"$tables"
# The text and the stack of `calls` are those of the exact path; `around` has the rest.
stack() {
    local binary=$1 what=$2 limit=$3
    shift 3
    run "$binary" "" >"$CARGO_TARGET_DIR/stack.txt"
    "$tools/inspect" "$binary" "$@" --stack "$limit" --measured "$CARGO_TARGET_DIR/stack.txt" >"$CARGO_TARGET_DIR/said.txt" ||
        { cat "$CARGO_TARGET_DIR/said.txt" && exit 1; }
    grep -v '^stack of' "$CARGO_TARGET_DIR/said.txt" || true
    # The names of calls have spaces.
    awk -v what="$what" '/^stack of/ && sub(/.*: at most /, "") && $1 + 0 > most { most = $1 + 0 }
        END { printf "| %s | %d |\n", what, most }' \
        "$CARGO_TARGET_DIR/said.txt" | tee -a "$tables"
}
for board in "thumbv7em-none-eabihf Cortex-M4" "thumbv6m-none-eabi Cortex-M0"; do
    read -r target name <<<"$board"
    stack "$boards/$target/release/calls" "$name | exact path" 1536 --sizes sizes.txt
    stack "$boards/$target/release/around" "$name | around it" 2112 --sizes sizes.txt
done
"$tools/inspect" "$boards/riscv32imac-unknown-none-elf/release/around"
# Nor does the tree panic, which is in no program for so few objects but by this feature; nor do filters, which need it, and
# all that is around the exact path. The stack is that of any world, however large.
build thumbv7em-none-eabihf --bin calls --bin around --features large
large=$boards/thumbv7em-none-eabihf/release
"$tools/inspect" "$large/calls"
stack "$large/around" "Cortex-M4 | all, with the feature \`large\`" 4672
# Fixed point takes no soft-float; a margin does, which shows that the search finds it.
calls=$boards/thumbv6m-none-eabi/release/calls
"$tools/inspect" "$calls" --integers from_fixed
[ "$(failure "$tools/inspect" "$calls" --integers insert)" = 1 ]
# The search for panics finds one that is there.
build thumbv7em-none-eabihf --bin replay --features panic
[ "$(failure "$tools/inspect" "$boards/thumbv7em-none-eabihf/release/replay")" = 1 ]
# The table of instructions. Without an exact clock there are no figures.
build thumbv7em-none-eabihf --bin measure --features filters
[ "$(failure run "$boards/thumbv7em-none-eabihf/release/measure" "")" = 1 ]
echo | tee -a "$tables"
run "$boards/thumbv7em-none-eabihf/release/measure" "" -icount shift=0 | tee -a "$tables"
# The table of flash.
echo | tee -a "$tables"
./flash.sh | tee -a "$tables"
# What others begin with.
start/run.sh
printf '\n| program | text |\n|---|--:|\n| in C, on a Cortex-M4, with events | %d |\n' \
    "$(size -A "$CARGO_TARGET_DIR/start/start-in-c" | awk '$1 == ".text" { print $2 }')" | tee -a "$tables"
# The README has these tables; and the comparison can fail.
"$tools/table" README.md "$@" <"$tables"
[ "$(sed 's/^| pairs alone | ./&9/' "$tables" | failure "$tools/table" README.md)" = 1 ]
echo "the firmware runs, and holds what is said of it"
