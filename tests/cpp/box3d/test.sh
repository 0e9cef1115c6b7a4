#!/usr/bin/env bash
# Box3D on trisap: `tests/cpp/box3d/test.sh`. A patch has Box3D ask trisap for new pairs; its trees stay for queries. With both in one
# world, trisap and Box3D's own search find the same pairs in each step, while bodies come, go and change, and in small ones of Box3D's
# benchmark worlds; a recording is repeated to the bit.
#
# `--table` prints what whole steps take in the benchmark worlds, on one thread and on two. BOX3D_CHECKOUT is a folder of Box3D's
# repository at the commit of the sources (781673b): its own unit tests are run then, which the package of the sources does not bring.
# Their three numbers that depend on the order of contacts are replaced, where that is trisap's.
set -euo pipefail
cd "$(dirname "$0")/../../.."

. tests/cpp/hosts/prepare.sh
prepare box3d boxddd-sys
box3d=$package/third-party/box3d
make -s -j "${JOBS:-2}" -C "$root" -f "$PWD/tests/cpp/box3d/Makefile" BOX3D="$box3d" TRISAP="$PWD" LIBRARY="$root/prefix/lib/libtrisap.a"
here=$PWD
cd "$root"

if [ "${1-}" = --table ]; then
    for threads in 1 2; do
        for scene in "convex_pile 500" "junkyard 500" "rain 400" "washer 500" "large_pyramid 200" "many_pyramids 100" "joint_grid 100"; do
            # shellcheck disable=SC2086
            set -- $scene
            ./steps ./own.so ./trisap.so "$1" 0 "$2" "$threads"
        done
    done
    exit
fi

effort=${TRISAP_EFFORT:-1}
./life_shadow $((4 * effort))
./life_trisap $((4 * effort))
# Sizes of the worlds; two threads.
for scene in "convex_pile 8" "junkyard 2" "rain 3" "washer 8" "large_pyramid 20" "many_pyramids 3" "joint_grid 20"; do
    # shellcheck disable=SC2086
    ./steps ./shadow.so $scene $((150 * effort)) 2
done
# And what the patched Box3D does without the shadow.
./steps ./own.so ./trisap.so washer 12 100 2

if [ -n "${BOX3D_CHECKOUT-}" ]; then
    for side in shadow trisap; do
        rm -rf "tests_$side" && mkdir "tests_$side" && cp "$BOX3D_CHECKOUT"/test/*.[ch] "$BOX3D_CHECKOUT"/shared/*.[ch] "tests_$side"
        if [ $side = trisap ]; then
            sed -i 's/\(RAGDOLL_SLEEP_STEP\) 308/\1 271/; s/\(RAGDOLL_HASH\) 0x1E5EDD79/\1 0x9362D19A/; s/\(WAVE_PILE_HASH\) 0x47233541/\1 0x6D24FE10/' \
                "tests_$side/test_determinism.c"
        fi
        # shellcheck disable=SC2046
        gcc -std=c17 -O1 -DNDEBUG -D_POSIX_C_SOURCE=199309L -w -I"$box3d/include" -I"$box3d/src" "tests_$side"/*.c \
            $(find $side -name '*.o' ! -name worlds.o) trisap_box3d.o prefix/lib/libtrisap.a -lstdc++ -lm -pthread -o "tests_$side/test"
        (cd "tests_$side" && ./test | tail -2)
    done
fi
echo "Box3D finds the same pairs with trisap"
