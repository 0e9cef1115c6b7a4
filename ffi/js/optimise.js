// Drops what the package does not call from a module, and has Binaryen optimise the rest:
// `node optimise.js FROM TO (scalar | simd128) [names]`. Functions keep their names where that is asked for.

import binaryen from "binaryen";
import { readFile, readdir, writeFile } from "node:fs/promises";

const [from, to, vectors, names] = process.argv.slice(2);
const sources = new URL("src/", import.meta.url);
const files = (await readdir(sources)).filter((file) => file.endsWith(".js"));
const source = (await Promise.all(files.map((file) => readFile(new URL(file, sources), "utf8")))).join("\n");
const called = new Set(["memory", ...source.match(/\b(trisap_\w+|__heap_base)\b/g)]);

const bytes = await readFile(from);
const { Features } = binaryen;
// What Rust takes for granted on this target, and no more: hosts without vectors need a module without them.
const features =
  Features.MutableGlobals | Features.NontrappingFPToInt | Features.BulkMemory | Features.BulkMemoryOpt | Features.SignExt |
  Features.ReferenceTypes | Features.CallIndirectOverlong | Features.Multivalue | (vectors === "simd128" ? Features.SIMD128 : 0);
const module = binaryen.readBinary(bytes);
module.setFeatures(features);
for (const { name } of WebAssembly.Module.exports(new WebAssembly.Module(bytes))) {
  if (!called.has(name)) {
    module.removeExport(name);
  }
}
binaryen.setDebugInfo(names === "names");
binaryen.setOptimizeLevel(2);
binaryen.setShrinkLevel(1);
module.optimize();
await writeFile(to, module.emitBinary());
