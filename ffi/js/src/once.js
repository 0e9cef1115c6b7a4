// Pairs of boxes that are there once: no world to keep, no room to guess.

import { BOX, STATUS } from "./calls.js";
import { BadBoxError, InvalidArgumentError, OutOfMemoryError, TrisapError } from "./errors.js";
import { Memory } from "./memory.js";

// Where the structs of the call stand, and what is in them on a machine with pointers of four bytes.
const SECOND = 64;
const BYTES = 128;
const PAIRS = 132;
const COUNT = 136;

/** The pairs of boxes, or of a box of each side, in an instance of the module that goes afterwards. */
export async function find({ module }, boxes, others) {
  for (const side of [boxes, others ?? boxes]) {
    if (side.length % BOX !== 0) {
      throw new InvalidArgumentError("boxes", "have six numbers each: minimum x, y, z, maximum x, y, z");
    }
  }
  const memory = new Memory(await WebAssembly.instantiate(module, {}));
  const { calls, structs } = memory;
  const from = memory.boxes;
  const counts = [boxes.length / BOX, (others?.length ?? 0) / BOX];
  const all = counts[0] + counts[1];
  memory.lay(from, all, 0, 0);
  new Float32Array(memory.buffer, from, boxes.length).set(boxes);
  new Float32Array(memory.buffer, from + 4 * boxes.length, others?.length ?? 0).set(others ?? []);
  const a = memory.boxesAt(structs, from, counts[0]);
  const b = (others ?? null) === null ? 0 : memory.boxesAt(structs + SECOND, from + 4 * boxes.length, counts[1]);
  let world = 0;
  for (;;) {
    const status = calls.trisap_pairs(a, b, 0, world, structs + BYTES, structs + PAIRS, structs + COUNT);
    const word = (at) => memory.view.getUint32(structs + at, true);
    if (status === STATUS.OK) {
      return new Uint32Array(memory.buffer, word(PAIRS), 2 * word(COUNT)).slice();
    }
    if (status === STATUS.BAD_BOX) {
      throw new BadBoxError(`pairs, box ${word(COUNT)}`, { index: word(COUNT), id: null });
    }
    if (status !== STATUS.MEMORY_TOO_SMALL) {
      const text = memory.text(calls.trisap_status_text(status));
      throw all > 2 ** 27 ? new OutOfMemoryError(24 * all) : new TrisapError(`pairs: ${text}`);
    }
    memory.lay(from, all, word(BYTES), 0);
    world = memory.world;
  }
}
