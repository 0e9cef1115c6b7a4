// What a module with shared memory would spare a program whose boxes come from other threads: `node shared.js` prints the
// microseconds that it takes to set boxes from a `SharedArrayBuffer`, to step with events, and to write pairs and events to another one.

import { fileURLToPath } from "node:url";
import { createWorld } from "trisap";
import { open } from "./recording.js";

const { objects, frames } = open(fileURLToPath(new URL("../../../tests/recordings/brownian_cubes_8000.aabbs", import.meta.url)));
const pairs = 8 * objects;
const world = await createWorld({ objects, pairs, events: true });
world.insertMany(frames[0]);
const given = frames.map((frame) => {
  const boxes = new Float32Array(new SharedArrayBuffer(frame.byteLength));
  boxes.set(frame);
  return boxes;
});
const told = new Uint32Array(new SharedArrayBuffer(3 * 8 * pairs));
const times = { boxes: [], step: [], pairs: [] };
for (let round = 0; round < 40; round++) {
  for (const boxes of given) {
    const begin = performance.now();
    world.boxes.set(boxes);
    const set = performance.now();
    const { pairs, found, lost } = world.step();
    const stepped = performance.now();
    told.set(pairs);
    told.set(found, pairs.length);
    told.set(lost, pairs.length + found.length);
    const end = performance.now();
    // The first rounds are the compiler's.
    if (round > 2) {
      times.boxes.push(set - begin);
      times.step.push(stepped - set);
      times.pairs.push(end - stepped);
    }
  }
}
for (const [what, all] of Object.entries(times)) {
  console.log(what, (1000 * all.sort((a, b) => a - b)[all.length >> 1]).toFixed(0));
}
