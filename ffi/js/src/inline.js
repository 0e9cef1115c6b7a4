// The package with its module in the program itself, as a text: for one file, and for workers that are made of a blob.

import encoded from "../wasm/trisap-simd128.js";
import { missing, moduleFor } from "./load.js";
import { find } from "./once.js";
import { World } from "./world.js";

/** The module for this host. */
const read = async (variant) => {
  if (variant === "scalar") {
    throw missing("the module in the program needs 128-bit vectors");
  }
  return WebAssembly.compile(Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0)));
};

/** An empty world. */
export async function createWorld(config, options) {
  return (await createWorlds(1, config, options))[0];
}

/** So many empty worlds of one kind in one memory. */
export async function createWorlds(count, config, options) {
  return World.instantiate(await moduleFor(read, options), config, count);
}

/** The pairs of boxes that are there once. */
export async function pairs(boxes, { between, ...options } = {}) {
  return find(await moduleFor(read, options), boxes, between);
}

export { Contacts } from "./contacts.js";
export * from "./errors.js";
export { idOf, idText, slotOf } from "./id.js";
export { hasVectors } from "./load.js";
export { World, WorldCopy } from "./world.js";
