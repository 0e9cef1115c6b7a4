// The package in node.

import { readFile } from "node:fs/promises";
import { api } from "./api.js";
import { compile, missing } from "./load.js";

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

export const { createWorld, createWorlds, pairs } = api(read);
export * from "./exports.js";
