// Recordings (`.aabbs`, little endian): a header of 304 bytes, then one block of boxes a frame. A box is eight floats:
// minimum x, y, z, 0, maximum x, y, z, 0.

import { readFileSync } from "node:fs";
import { basename } from "node:path";

const NAMES = 128;
const HEADER = 2 * NAMES + 16 + 32;
const PADDED = 8;

/** The frames of a recording, forwards and backwards, as six floats a box. */
export function open(path) {
  const bytes = readFileSync(path);
  const objects = bytes.readUInt32LE(2 * NAMES);
  const blocks = bytes.readUInt32LE(2 * NAMES + 4) + 1;
  if (objects === 0 || bytes.length < HEADER + blocks * objects * PADDED * 4) {
    throw new Error(`${path}: shorter than its frames`);
  }
  const frames = [];
  for (let block = 0; block < blocks; block++) {
    const frame = new Float32Array(6 * objects);
    for (let i = 0; i < objects; i++) {
      for (let axis = 0; axis < 3; axis++) {
        const at = HEADER + (block * objects + i) * PADDED * 4 + 4 * axis;
        frame[6 * i + axis] = bytes.readFloatLE(at);
        frame[6 * i + 3 + axis] = bytes.readFloatLE(at + 16);
      }
    }
    frames.push(frame);
  }
  return { name: basename(path, ".aabbs"), objects, frames: [...frames, ...frames.slice(1, -1).reverse()] };
}
