// The package in a browser, and in whatever else has `fetch`.

import { api } from "./api.js";
import { compile } from "./load.js";

// Written out, so that bundlers see which files are meant.
const files = {
  scalar: () => new URL("../wasm/trisap.wasm", import.meta.url),
  simd128: () => new URL("../wasm/trisap-simd128.wasm", import.meta.url),
  pairs: () => new URL("../wasm/trisap-pairs.wasm", import.meta.url),
};

/** The module for this host. */
const read = async (variant) => compile(await fetch(files[variant]()));

export const { createWorld, createWorlds, pairs } = api(read);
export * from "./exports.js";
