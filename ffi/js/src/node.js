// The package in node.

import { readFile } from "node:fs/promises";
import { compile, moduleFor } from "./load.js";
import { World } from "./world.js";

const files = {
  scalar: new URL("../wasm/trisap.wasm", import.meta.url),
  simd128: new URL("../wasm/trisap-simd128.wasm", import.meta.url),
};

/** An empty world. */
export async function createWorld(config, options) {
  const read = async (variant) => compile(await readFile(files[variant]));
  return World.instantiate(await moduleFor(read, options), config);
}

export * from "./errors.js";
export { slotOf } from "./id.js";
export { hasVectors } from "./load.js";
export { World } from "./world.js";
