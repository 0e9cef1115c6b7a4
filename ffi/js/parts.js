// What fills a module: `node parts.js MODULE [--functions]`, for a module whose functions still have their names, as
// `ffi/js/build.sh --parts` leaves them. Prints the bytes of code by part of the library as a table; with `--functions` also the
// functions, the largest first. What was inlined counts for the function that it is in. Needs c++filt of binutils.

import { execFileSync } from "node:child_process";
import { readFile } from "node:fs/promises";

const [path, ...options] = process.argv.slice(2);
const bytes = await readFile(path);

/** Reads a number of WebAssembly's at a place; returns it and the place behind it. */
function number(at) {
  let [value, shift] = [0, 0];
  for (;;) {
    const byte = bytes[at++];
    value += (byte & 0x7f) * 2 ** shift;
    shift += 7;
    if (byte < 0x80) {
      return [value, at];
    }
  }
}

/** Reads a name; returns it and the place behind it. */
function name(at) {
  const [length, start] = number(at);
  return [bytes.toString("utf8", start, start + length), start + length];
}

const CODE = 10;
const sections = new Map();
const sizes = [];
const names = new Map();
let imports = 0;
for (let at = 8; at < bytes.length; ) {
  const [length, start] = number(at + 1);
  const id = bytes[at];
  const end = start + length;
  let label = { 1: "types", 2: "imports", 3: "functions", 7: "exports", 10: "code", 11: "data" }[id] ?? "other";
  if (id === 0) {
    let place;
    [label, place] = name(start);
    while (label === "name" && place < end) {
      const kind = bytes[place];
      const [size, from] = number(place + 1);
      if (kind === 1) {
        let [count, entry] = number(from);
        for (; count > 0; count--) {
          let index;
          [index, entry] = number(entry);
          [label, entry] = name(entry);
          names.set(index, label);
        }
        label = "name";
      }
      place = from + size;
    }
  } else if (id === 2) {
    imports = number(start)[0];
  } else if (id === CODE) {
    let [count, place] = number(start);
    for (; count > 0; count--) {
      const [size, from] = number(place);
      sizes.push(from + size - place);
      place = from + size;
    }
  }
  sections.set(label, (sections.get(label) ?? 0) + end - at);
  at = end;
}
if (imports > 0) {
  throw new Error("the package's modules import nothing");
}
if (names.size === 0) {
  throw new Error(`${path} has no names: build it with ffi/js/build.sh --parts`);
}

// c++filt leaves the name of a function of C as it is.
const mangled = sizes.map((_, index) => names.get(index) ?? "without a name");
const plain = execFileSync("c++filt", { input: mangled.join("\n"), maxBuffer: 2 ** 26 }).toString().split("\n");

/** What parts of the library are made of: modules of the core, and what is in the names of functions of the C ABI and of a world. */
const PARTS = {
  "steps": [/^(step|sweep|pairs|objects|lists|parallel|sort|access|simd)$/, /step|result|advance|stats/],
  "tree": [/^tree$/, /(?!)/],
  "queries": [/^query$/, /overlaps|hit|nearest|among/],
  "snapshots and their checks": [/^(snapshot|validate)$/, /save|load|snapshot|image/],
  "memory of a world": [/^memory$/, /size|align|init|new_in|open/],
  "moved origin": [/(?!)/, /shift/],
  "values": [/(?!)/, /value/],
  "filters, rest": [/(?!)/, /filter|class|resting|wake/],
  "objects come, change, go": [/^(world|geometry|id)$/, /insert|update|remove|aabb|contains|id_at|len/],
};

/** The part of the library that a function belongs to. A phase that is compiled for vectors is that of its type. */
function part(name) {
  const plainest = name.replace(/\[[0-9a-f]+\]/g, "");
  const [, phase] = plainest.match(/::call::<.*?trisap_core::((?!simd::)\w+)/) ?? [];
  const [, module, rest] = plainest.match(/trisap_core::(\w+)(.*)/) ?? [];
  const abi = /^trisap_\w+$/.test(plainest) || plainest.includes("trisap_ffi");
  const named = Object.entries(PARTS);
  // A world's functions are told apart by their own names.
  if (abi || (!phase && module === "world")) {
    const found = named.find(([, [, names]]) => names.test(abi ? plainest : rest));
    return found ? found[0] : abi ? "C ABI" : "objects come, change, go";
  }
  const found = named.find(([, [modules]]) => modules.test(phase ?? module ?? ""));
  return module ? (found ? found[0] : "other") : "compiler, libm";
}

const parts = new Map();
sizes.forEach((size, index) => {
  const key = part(plain[index]);
  const [total, count] = parts.get(key) ?? [0, 0];
  parts.set(key, [total + size, count + 1]);
});
const sorted = [...parts].sort(([, [a]], [, [b]]) => b - a);
console.log("| part | bytes of code | functions |\n|---|---:|---:|");
sorted.forEach(([key, [size, count]]) => console.log(`| ${key} | ${size} | ${count} |`));
const code = sizes.reduce((a, b) => a + b, 0);
console.log(`| all code | ${code} | ${sizes.length} |`);
console.log([...sections].map(([label, size]) => `${label} ${size}`).join(", "));
if (options.includes("--functions")) {
  const order = [...sizes.keys()].sort((a, b) => sizes[b] - sizes[a]);
  order.forEach((index) => console.log(sizes[index], part(plain[index]), plain[index]));
}
