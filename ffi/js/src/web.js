// The package in a browser, and in whatever else has `fetch`.

import { compile, moduleFor } from "./load.js";
import { find } from "./once.js";
import { World } from "./world.js";

// Written out, so that bundlers see which files are meant.
const files = {
  scalar: () => new URL("../wasm/trisap.wasm", import.meta.url),
  simd128: () => new URL("../wasm/trisap-simd128.wasm", import.meta.url),
  pairs: () => new URL("../wasm/trisap-pairs.wasm", import.meta.url),
};

/** The module for this host. */
const read = async (variant) => compile(await fetch(files[variant]()));

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
  return find(await moduleFor(read, { ...options, pairsOnly: false }), boxes, between);
}

export { Contacts } from "./contacts.js";
export * from "./errors.js";
export { idOf, idText, slotOf } from "./id.js";
export { hasVectors } from "./load.js";
export { World, WorldCopy } from "./world.js";
