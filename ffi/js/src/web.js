// The package in a browser, and in whatever else has `fetch`.

import { compile, moduleFor } from "./load.js";
import { World } from "./world.js";

// Written out, so that bundlers see which files are meant.
const files = {
  scalar: () => new URL("../wasm/trisap.wasm", import.meta.url),
  simd128: () => new URL("../wasm/trisap-simd128.wasm", import.meta.url),
};

/** An empty world. */
export async function createWorld(config, options) {
  const read = async (variant) => compile(await fetch(files[variant]()));
  return World.instantiate(await moduleFor(read, options), config);
}

export { Contacts } from "./contacts.js";
export * from "./errors.js";
export { idOf, idText, slotOf } from "./id.js";
export { hasVectors } from "./load.js";
export { World, WorldCopy } from "./world.js";
