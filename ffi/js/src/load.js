// From bytes to a compiled module.

import { ModuleError } from "./errors.js";

/** A function that uses 128-bit vectors: hosts without them refuse it. */
const VECTORS = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

/** Whether this host has 128-bit vectors. */
export function hasVectors() {
  return WebAssembly.validate(VECTORS);
}

/** Compiled once for all worlds. */
const compiled = new Map();

/**
 * The module for this host, or the one asked for.
 * @param {(variant: string) => Promise<WebAssembly.Module>} read how this host gets at the files of the package
 */
export async function moduleFor(read, { simd = hasVectors(), wasm, pairsOnly = false } = {}) {
  if (wasm !== undefined) {
    return { module: await compile(await wasm), variant: "given" };
  }
  const variant = !simd ? "scalar" : pairsOnly ? "pairs" : "simd128";
  if (!compiled.has(variant)) {
    compiled.set(variant, read(variant));
  }
  try {
    return { module: await compiled.get(variant), variant };
  } catch (error) {
    // A file that did not come may come the next time.
    compiled.delete(variant);
    throw error;
  }
}

/** Of a module, an answer to a request, or bytes. `from` says where bytes came from. */
export async function compile(source, from = "the bytes given") {
  if (source instanceof WebAssembly.Module) {
    return source;
  }
  if (typeof Response !== "undefined" && source instanceof Response) {
    const type = source.headers.get("content-type") ?? "no type";
    const what = `${source.url || "the answer"} (status ${source.status}, ${type})`;
    if (!source.ok) {
      throw missing(`${what} is no module`);
    }
    // Other servers' types are refused by the streaming compiler.
    if (type.startsWith("application/wasm") && WebAssembly.compileStreaming) {
      return WebAssembly.compileStreaming(source);
    }
    return compile(await source.arrayBuffer(), what);
  }
  const bytes = ArrayBuffer.isView(source) ? new Uint8Array(source.buffer, source.byteOffset, source.byteLength) : new Uint8Array(source);
  // Bundlers and servers answer with a page where the file is not.
  if (MAGIC.some((byte, i) => bytes[i] !== byte)) {
    const first = String.fromCharCode(...bytes.subarray(0, 16));
    throw missing(`${from} ${from.endsWith(")") ? "is" : "are"} no module: ${JSON.stringify(first)} came instead`);
  }
  return WebAssembly.compile(source);
}

/** The error of a module that is not where the package has put it. */
export function missing(what) {
  const hint = 'pass { wasm: fetch(url) } or { wasm: bytes } of "trisap/wasm/trisap-simd128.wasm", or import "trisap/inline"';
  return new ModuleError(`${what}; ${hint}`);
}

/** How a module begins. */
const MAGIC = [0, 97, 115, 109];
