// Views, and what becomes of them when the memory grows.

import assert from "node:assert/strict";
import { test } from "node:test";
import { readFile } from "node:fs/promises";
import { createWorld, hasVectors } from "trisap";
import { bruteForce, random, scatter, texts } from "./brute.js";

test("views are in the memory of the world, not copies", async () => {
  const world = await createWorld({ objects: 100, events: true });
  world.insertMany(scatter(100, random(1), 3));
  const { pairs, found } = world.step();
  assert.ok(pairs.length > 0);
  assert.equal(pairs.buffer, world.boxes.buffer);
  assert.equal(found.buffer, world.boxes.buffer);
  assert.ok(pairs instanceof Uint32Array && world.boxes instanceof Float32Array);
  assert.equal(world.boxes.length, 600);
  // The same view each time: no garbage a step.
  assert.equal(world.pairs, pairs);
  assert.equal(world.boxes, world.boxes);
});

test("after growth the properties give right views, and old views are empty", async () => {
  const world = await createWorld({ objects: 4000, pairs: 60000 });
  const boxes = scatter(2000, random(2), 20);
  for (let i = 0; i < boxes.length; i += 600) {
    world.insertMany(boxes.subarray(i, i + 600));
  }
  const { pairs } = world.step();
  const [copy, old, bytes] = [pairs.slice(), world.boxes, world.memoryBytes];
  // A snapshot needs memory of its own.
  const snapshot = world.save();
  assert.ok(world.memoryBytes > bytes, "the memory has not grown");
  assert.equal(old.length, 0);
  assert.equal(pairs.length, 0);
  assert.deepEqual(world.pairs, copy);
  assert.deepEqual(world.boxes.subarray(0, boxes.length), boxes);
  world.boxes.set([0, 0, 0, 30, 30, 30]);
  assert.deepEqual(texts(world.step().pairs), bruteForce(world.boxes.subarray(0, boxes.length)));
  // Steps, changes of single objects and calls that need no more than others before them do not grow it.
  const [view, now] = [world.boxes, world.memoryBytes];
  const id = world.insert([0, 0, 0, 1, 1, 1]);
  world.update(id, [5, 5, 5, 6, 6, 6]);
  world.step();
  world.remove(id);
  world.load(snapshot);
  assert.equal(world.memoryBytes, now);
  assert.equal(world.boxes, view);
});

test("boxes of a world's own memory can be inserted", async () => {
  const world = await createWorld({ objects: 6000 });
  const boxes = scatter(3000, random(3), 60);
  world.boxes.set(boxes);
  const bytes = world.memoryBytes;
  world.insertMany(world.boxes.subarray(0, boxes.length));
  assert.ok(world.memoryBytes > bytes, "the memory has not grown");
  assert.deepEqual(texts(world.step().pairs), bruteForce(boxes));
});

test("another world's growth moves nothing", async () => {
  const [one, other] = await Promise.all([createWorld({ objects: 10 }), createWorld({ objects: 10000 })]);
  const view = one.boxes;
  other.insertMany(scatter(10000, random(4), 100));
  assert.equal(one.boxes, view);
  assert.equal(view.length, 60);
});

test("hundreds of worlds live at once", async () => {
  const worlds = await Promise.all(Array.from({ length: 200 }, () => createWorld({ objects: 20 })));
  for (const world of worlds) {
    world.insertMany(scatter(20, random(5), 2));
    assert.ok(world.step().pairs.length > 0);
  }
});

test("the modules ask their host for nothing", async () => {
  for (const name of ["trisap", "trisap-simd128"]) {
    const module = await WebAssembly.compile(await readFile(new URL(`../wasm/${name}.wasm`, import.meta.url)));
    assert.deepEqual(WebAssembly.Module.imports(module), []);
  }
});

test("the loader takes vectors where the host has them, and what it is given", async () => {
  assert.equal((await createWorld({ objects: 1 })).variant, hasVectors() ? "simd128" : "scalar");
  assert.equal((await createWorld({ objects: 1 }, { simd: false })).variant, "scalar");
  const bytes = await readFile(new URL("../wasm/trisap.wasm", import.meta.url));
  for (const wasm of [bytes, new WebAssembly.Module(bytes), new Response(bytes), Promise.resolve(bytes)]) {
    const world = await createWorld({ objects: 2 }, { wasm });
    world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2]));
    assert.deepEqual([...world.step().pairs], [0, 1]);
  }
});

test("a host without vectors gets the other module", async () => {
  const { validate } = WebAssembly;
  try {
    WebAssembly.validate = () => false;
    assert.equal(hasVectors(), false);
    assert.equal((await createWorld({ objects: 1 })).variant, "scalar");
  } finally {
    WebAssembly.validate = validate;
  }
});
