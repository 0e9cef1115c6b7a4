// Measures trisap and its peers: `node run.js [RECORDING ...] [--rounds N]`.
//
// One process, the same frames, the peers in turn within each round, so that a busy machine is busy for all of them. Every
// count is compared with that of brute force. Times are medians of CPU
// time over all steps after the first round, in milliseconds.

import { fileURLToPath } from "node:url";
import { overlap } from "../test/brute.js";
import { peers } from "./peers.js";
import { open } from "./recording.js";

const [paths, rounds] = options(process.argv.slice(2));
const rows = [];
for (const path of paths) {
  await measure(open(path));
}
print();

function options(words) {
  const at = words.indexOf("--rounds");
  const rounds = at < 0 ? 12 : Number(words.splice(at, 2)[1]);
  const own = ["brownian_cubes_8000", "gravity_assorted_1000", "freefall_cubes_1000"];
  const recording = (name) => fileURLToPath(new URL(`../../../tests/recordings/${name}.aabbs`, import.meta.url));
  return [words.length > 0 ? words : own.map(recording), rounds];
}

/** CPU time of the process, its collector of garbage included: a busy machine would interrupt long steps more often. */
function cpu() {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1000;
}

function bruteForce(boxes) {
  let count = 0;
  for (let a = 0; a < boxes.length / 6; a++) {
    for (let b = a + 1; b < boxes.length / 6; b++) {
      count += overlap(boxes, a, b) ? 1 : 0;
    }
  }
  return count;
}

async function measure({ name, objects, frames }) {
  const expected = frames.map(bruteForce);
  const all = await peers(objects, Math.max(...expected));
  const times = new Map();
  const note = (peer, time) => times.set(peer, [...(times.get(peer) ?? []), time]);
  let off = 0;
  for (const peer of Object.values(all)) {
    peer.begin(frames[0]);
  }
  for (let round = 0; round < rounds; round++) {
    for (const [label, peer] of Object.entries(all)) {
      frames.forEach((frame, i) => {
        peer.prepare(frame);
        const start = cpu();
        const count = peer.step(frame);
        const time = cpu() - start;
        if (count !== null && count !== expected[i]) {
          throw new Error(`${name}, ${label}, frame ${i}: ${count} pairs, not ${expected[i]}`);
        }
        // The first round is the compiler's.
        if (round > 0) {
          note(label, time);
          if (peer.own) {
            note("rapier3d, its broad phase", peer.own());
            off = Math.max(off, round === rounds - 1 ? Math.abs(peer.count() - expected[i]) : 0);
          }
        }
      });
    }
  }
  const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
  const results = new Map([...times].map(([label, list]) => [label, median(list)]));
  rows.push({ name, objects, pairs: Math.round(expected.reduce((a, b) => a + b) / expected.length), results, off });
}

function print() {
  const labels = [...rows[0].results.keys()];
  console.log(`node ${process.version}, ${rounds - 1} rounds, median milliseconds of CPU a step (times trisap, simd128)\n`);
  console.log(`| | ${rows.map(({ name, objects, pairs }) => `${name}: ${objects} boxes, ${pairs} pairs`).join(" | ")} |`);
  console.log(`|---|${"---:|".repeat(rows.length)}`);
  for (const label of labels) {
    const cells = rows.map(({ results }) => {
      const ratio = results.get(label) / results.get(labels[0]);
      return `${results.get(label).toFixed(3)} (${ratio.toFixed(1)})`;
    });
    console.log(`| ${label} | ${cells.join(" | ")} |`);
  }
  console.log(`\nPairs of rapier3d off from brute force by at most: ${rows.map(({ off }) => off).join(", ")}.`);
}
