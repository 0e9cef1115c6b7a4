// The package in node.

import { readFile } from "node:fs/promises";
import { compile, missing, moduleFor } from "./load.js";
import { find } from "./once.js";
import { World } from "./world.js";

const files = {
  scalar: new URL("../wasm/trisap.wasm", import.meta.url),
  simd128: new URL("../wasm/trisap-simd128.wasm", import.meta.url),
  pairs: new URL("../wasm/trisap-pairs.wasm", import.meta.url),
};

/** The module for this host. */
const read = async (variant) => {
  const bytes = await readFile(files[variant]).catch((error) => {
    throw missing(error.message);
  });
  return compile(bytes, files[variant].pathname);
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
  return find(await moduleFor(read, { ...options, pairsOnly: false }), boxes, between);
}

export { Contacts } from "./contacts.js";
export * from "./errors.js";
export { idOf, idText, slotOf } from "./id.js";
export { hasVectors } from "./load.js";
export { World, WorldCopy } from "./world.js";
