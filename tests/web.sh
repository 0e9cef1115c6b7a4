#!/usr/bin/env bash
# The package for the web, from anywhere: builds it, runs its tests in node and in Chromium, installs what `npm pack` makes
# into an empty program and runs that, runs what vite, webpack, rollup and esbuild make of it, and has the peers agree on every count.
#
# Needs node with npm and what ffi/js/build.sh needs; says so and does nothing without them, or fails with TRISAP_NO_SKIP.
set -euo pipefail
cd "$(dirname "$0")/../ffi/js"

missing=
command -v npm >/dev/null || missing="npm"
[[ -d /usr/lib/rustlib/src/rust/library/core || -d "$(rustc --print sysroot)/lib/rustlib/src/rust/library/core" ]] ||
    missing="the source of Rust's core (rust-web-src)"
if [[ -n "$missing" ]]; then
    [[ -z "${TRISAP_NO_SKIP-}" ]] || { echo "$missing is not installed" >&2 && exit 1; }
    echo "skipped: $missing is not installed: nobody builds the package for the web"
    exit 0
fi

npm ci --no-audit --no-fund --loglevel=error
./build.sh
npm test
# A host without vectors.
node --no-enable-sse4-1 --input-type=module -e '
import { createWorld, hasVectors } from "trisap";
const world = await createWorld({ objects: 2 });
world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2]));
if (process.arch === "x64" && (hasVectors() || world.variant !== "scalar")) throw new Error("the host has vectors");
if (world.step().pairs.join() !== "0,1") throw new Error("a pair is missing");
'

packed=$(mktemp -d)
trap 'rm -rf "$packed"' EXIT
npm pack --ignore-scripts --loglevel=error --pack-destination "$packed" >/dev/null
(
    cd "$packed"
    echo '{ "private": true, "type": "module" }' >package.json
    npm install --no-audit --no-fund --loglevel=error ./trisap-*.tgz
    # Nothing comes with it.
    [[ "$(ls node_modules)" == trisap ]]
    cat >main.js <<'PROGRAM'
import { createWorld } from "trisap";
const world = await createWorld({ objects: 2 });
world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2]));
if (world.step().pairs.join() !== "0,1") throw new Error("a pair is missing");
PROGRAM
    node main.js
)

# As bundlers make it, away from this checkout.
cp -r bundlers "$packed"
(
    cd "$packed/bundlers"
    npm ci --no-audit --no-fund --loglevel=error
    npm install --no-save --no-audit --no-fund --loglevel=error ../trisap-*.tgz
    node --test bundlers.test.js
)

cd peers
npm ci --no-audit --no-fund --loglevel=error
node run.js --rounds 3
