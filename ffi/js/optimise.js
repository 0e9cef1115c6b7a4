// Drops what the package does not call from a module, and has Binaryen optimise the rest:
// `node optimise.js FROM TO (scalar | simd128 | pairs) [names]`. Functions keep their names where that is asked for. A module with
// `pairs` alone has vectors, too.

import binaryen from "binaryen";
import { readFile, readdir, writeFile } from "node:fs/promises";

const [from, to, kind, names] = process.argv.slice(2);
const sources = new URL("src/", import.meta.url);
const files = (await readdir(sources)).filter((file) => file.endsWith(".js"));
const source = (await Promise.all(files.map((file) => readFile(new URL(file, sources), "utf8")))).join("\n");
const called = new Set(["memory", ...source.match(/\b(trisap_\w+|__heap_base)\b/g)]);
/** Calls of `World` that a module for pairs alone lacks. */
const more =
  /overlaps|hit|nearest|within|filter|class|value|margin|pair_ids|shift|save|load|snapshot|from_f64|refresh|enable|trisap_pairs/;

const bytes = await readFile(from);
const { Features } = binaryen;
// What Rust takes for granted on this target, and no more: hosts without vectors need a module without them.
const features =
  Features.MutableGlobals | Features.NontrappingFPToInt | Features.BulkMemory | Features.BulkMemoryOpt | Features.SignExt |
  Features.ReferenceTypes | Features.CallIndirectOverlong | Features.Multivalue | (kind === "scalar" ? 0 : Features.SIMD128);
const module = binaryen.readBinary(bytes);
module.setFeatures(features);
for (const { name } of WebAssembly.Module.exports(new WebAssembly.Module(bytes))) {
  if (!called.has(name) || (kind === "pairs" && more.test(name))) {
    module.removeExport(name);
  }
}
binaryen.setDebugInfo(names === "names");
binaryen.setOptimizeLevel(2);
binaryen.setShrinkLevel(1);
// What is called in one place stays where it is, or large functions become larger. Addresses below 1024 are the end of the stack,
// which traps there, and the memory is the module's own, all zero at first.
binaryen.setOneCallerInlineMaxSize(0);
binaryen.setLowMemoryUnused(true);
binaryen.setZeroFilledMemory(true);
module.optimize();
await writeFile(to, module.emitBinary());
