// The package with its module in the program itself, as a text: for one file, and for workers that are made of a blob.

import encoded from "../wasm/trisap-simd128.js";
import { api } from "./api.js";
import { missing } from "./load.js";

/** The module for this host. */
const read = async (variant) => {
  if (variant === "scalar") {
    throw missing("the module in the program needs 128-bit vectors");
  }
  return WebAssembly.compile(Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0)));
};

export const { createWorld, createWorlds, pairs } = api(read);
export * from "./exports.js";
