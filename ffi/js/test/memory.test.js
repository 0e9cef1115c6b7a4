// Views, which hold whatever is called, and worlds that grow.

import assert from "node:assert/strict";
import { test } from "node:test";
import { readFile } from "node:fs/promises";
import { BadSnapshotError, createWorld, createWorlds, hasVectors, ObjectsFullError, pairs, StaleIdError } from "trisap";
import { bruteForce, random, scatter, texts, without } from "./brute.js";

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

test("a loop over pairs walks all of them, whatever is called in it", async () => {
  const world = await createWorld({ objects: 10_000, pairs: 200_000, events: true, filters: true, values: true });
  const boxes = scatter(10_000, random(2), 25);
  // One by one: a batch may have had the memory grow before.
  const ids = [];
  for (let i = 0; i < boxes.length; i += 6) {
    ids.push(world.insert(boxes.subarray(i, i + 6)));
  }
  const all = { min: [-1, -1, -1], max: [99, 99, 99] };
  const { pairs, found } = world.step();
  const [copy, view, bytes] = [pairs.slice(), world.boxes, world.memoryBytes];
  assert.ok(pairs.length > 20_000);
  const calls = [
    () => assert.equal(world.overlaps(all).length, ids.length),
    () => assert.equal(world.nearest([0, 0, 0], ids.length).length, ids.length),
    () => assert.equal(world.hits({ box: [-9, -9, -9, 99, 99, 99], direction: [0, 0, 0] }).length, ids.length),
    () => world.save(),
    () => world.setResting(ids),
    () => world.wake(ids),
    () => world.setFilters(ids, {}),
    () => world.setValues(ids, ids),
    () => assert.equal(world.values([...ids, ...ids, ...ids]).length, 3 * ids.length),
    () => assert.equal(world.pairIds().length, pairs.length),
    () => assert.equal(world.pairValues("found").length, pairs.length),
    () => assert.equal(world.awakePairs().length, pairs.length),
    () => world.updateMany(ids, boxes),
    () => world.commit(),
    () => world.shiftOrigin([0, 0, 0]),
    () => assert.throws(() => world.insertMany(new Float32Array(6_000_000)), ObjectsFullError),
    () => assert.throws(() => world.removeMany([...ids, ids[0]]), StaleIdError),
    () => assert.throws(() => world.load(new Uint8Array(2 ** 24)), BadSnapshotError),
    () => world.removeMany(ids),
  ];
  let walked = 0;
  for (let i = 0; i < pairs.length; i += 2) {
    calls[i / 2]?.();
    walked++;
  }
  assert.equal(walked, copy.length / 2);
  for (const pair of [pairs, world.pairs, found, world.found]) {
    assert.deepEqual(pair, copy);
  }
  assert.equal(world.boxes, view);
  assert.equal(world.memoryBytes, bytes);
  // All room for answers at once, also those of snapshots.
  const snapshot = world.save();
  world.load(snapshot);
  assert.equal(world.boxes, view);
});

test("a world that grows goes on with its ids, boxes and events", async () => {
  const next = random(6);
  const world = await createWorld({ objects: 2, pairs: 1, leafRefs: 0, events: true, filters: true, lean: true, grows: true });
  const [boxes, ids] = [[], []];
  let before = [];
  for (let step = 0; step < 12; step++) {
    for (let i = 0; i < 40; i++) {
      const box = scatter(1, next);
      boxes.push(...box);
      ids.push(world.insert(box));
    }
    const many = scatter(30, next);
    boxes.push(...many);
    ids.push(...world.insertMany(many));
    // What was written before objects come is not lost either.
    const slot = Math.floor(next() * ids.length);
    boxes.splice(6 * slot, 6, ...scatter(1, next));
    world.boxes.set(boxes.slice(6 * slot, 6 * slot + 6), 6 * slot);
    world.step();
    const expected = bruteForce(Float32Array.from(boxes));
    assert.deepEqual(texts(world.pairs), expected, `step ${step}`);
    assert.deepEqual(texts(world.found), without(expected, before));
    assert.deepEqual(texts(world.lost), without(before, expected));
    before = expected;
  }
  assert.deepEqual([...world.ids()], ids);
  assert.ok(world.config.objects >= 840 && world.config.pairs >= before.length && world.config.grows && !world.config.lean);
  // The room of a given world takes the snapshot of a smaller one.
  const small = await createWorld({ objects: 2, events: true, filters: true });
  small.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2]));
  world.load(small.save());
  assert.deepEqual([...world.step().pairs], [0, 1]);
});

test("a world is what it was asked for when it was made, whatever becomes of the object that said so", async () => {
  const config = { objects: 2, grows: true };
  const world = await createWorld(config);
  Object.assign(config, { events: true, grows: false, margin: 3 });
  for (let i = 0; i < 5; i++) {
    world.insert([i, 0, 0, i + 1, 1, 1]);
  }
  assert.equal(world.step().pairs.length, 2 * 4);
  assert.ok(world.config.objects >= 5 && !world.config.events && world.config.grows);
});

test("a world that grows takes boxes that stand in its own memory", async () => {
  const world = await createWorld({ objects: 2, grows: true });
  world.insert([0, 1, 2, 3, 4, 5]);
  // Views of the boxes are taken away while their object comes.
  for (let slot = 1; slot < 2000; slot++) {
    const box = world.boxes.subarray(6 * slot - 6, 6 * slot);
    const id = slot % 2 === 0 ? world.insert(box) : world.insertAt(slot, box);
    assert.deepEqual([...world.box(id)], [0, 1, 2, 3, 4, 5]);
    assert.deepEqual([...world.boxes.subarray(6 * slot, 6 * slot + 6)], [0, 1, 2, 3, 4, 5]);
  }
});

test("a world that grows keeps the room that there was", async () => {
  const world = await createWorld({ objects: 2, leafRefs: 500, pairs: 9000, grows: true });
  world.insertMany(new Float32Array(6 * 100));
  const { leafRefs, pairs } = world.config;
  assert.deepEqual([leafRefs, pairs], [500, 9000]);
});

test("a lean world that grows is lean as long as it can be", async () => {
  const world = await createWorld({ objects: 100, lean: true, grows: true });
  for (let i = 0; i < 300; i++) {
    world.insert([2 * i, 0, 0, 2 * i + 1, 1, 1]);
    assert.equal(world.config.lean, i < 200);
  }
  assert.equal(world.step().pairs.length, 0);
});

test("a world that grows takes any snapshot", async () => {
  const next = random(7);
  const crowd = await createWorld({ objects: 3000, events: true });
  crowd.insertMany(scatter(3000, next, 20));
  crowd.step();
  // Few objects with many pairs.
  const heap = await createWorld({ objects: 60, pairs: 2000, events: true });
  heap.insertMany(scatter(60, next, 0));
  heap.step();
  for (const from of [crowd, heap]) {
    const world = await createWorld({ objects: 60, pairs: 4, events: true, grows: true });
    const fixed = await createWorld({ objects: 60, pairs: 4, events: true });
    world.insert([0, 0, 0, 1, 1, 1]);
    const snapshot = from.save();
    assert.throws(() => fixed.load(snapshot));
    world.load(snapshot);
    assert.equal(world.size, from.size);
    assert.ok(from.pairs.length > 100);
    assert.deepEqual(world.pairs, from.pairs);
    assert.deepEqual(world.boxes.slice(0, 6 * from.size), from.boxes.slice(0, 6 * from.size));
    assert.deepEqual(texts(world.step().pairs), texts(from.pairs));
    assert.equal(world.found.length + world.lost.length, 0);
  }
  // What is none changes nothing, however long it is.
  const world = await createWorld({ objects: 1, grows: true });
  world.insert([0, 0, 0, 1, 1, 1]);
  world.step();
  assert.throws(() => world.load(new Uint8Array(2 ** 22 + 1)), BadSnapshotError);
  assert.deepEqual([...world.boxes], [0, 0, 0, 1, 1, 1]);
  world.insert([0, 0, 0, 1, 1, 1]);
  assert.deepEqual([...world.step().pairs], [0, 1]);
});

test("a world goes back to any copy, also after it has grown another time", async () => {
  const next = random(10);
  const world = await createWorld({ objects: 4, events: true, grows: true });
  world.insertMany(scatter(4, next, 0));
  world.step();
  const small = world.copy();
  world.insertMany(scatter(3000, next, 20));
  world.step();
  const [large, pairs, boxes] = [world.copy(), world.pairs.slice(), world.boxes.slice()];
  for (let again = 0; again < 2; again++) {
    world.restore(small);
    world.insert([0, 0, 0, 1, 1, 1]);
    world.step();
    assert.equal(world.size, 5);
    world.restore(large);
    assert.equal(world.size, 3004);
    assert.deepEqual(world.pairs, pairs);
    assert.deepEqual(world.boxes, boxes);
    assert.equal(world.ids().length, 3004);
    assert.equal(world.overlaps({ min: [-1, -1, -1], max: [99, 99, 99] }).length, 3004);
    assert.deepEqual(texts(world.step().pairs), texts(pairs));
  }
  // To grow again and again takes no more memory than once.
  const bytes = world.memoryBytes;
  for (let again = 0; again < 50; again++) {
    world.restore(small);
    world.insertMany(scatter(3000, next, 20));
    world.step();
  }
  assert.equal(world.memoryBytes, bytes);
});

test("boxes of a world's own memory can be inserted", async () => {
  for (const [objects, grows] of [[6000, false], [3000, true]]) {
    const world = await createWorld({ objects, grows });
    const boxes = scatter(3000, random(3), 60);
    world.boxes.set(boxes);
    const first = world.insertMany(new Float32Array(boxes.subarray(0, 6)));
    world.boxes.set(boxes);
    world.insertMany(world.boxes.subarray(0, boxes.length));
    world.remove(first[0]);
    const all = Float32Array.of(...boxes.subarray(0, 6), ...boxes);
    assert.deepEqual(texts(world.step().pairs), bruteForce(all, (slot) => slot > 0));
  }
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

test("many worlds in one memory do not know of each other", async () => {
  const config = { objects: 8, pairs: 28, events: true, values: true };
  const worlds = await createWorlds(14000, config);
  assert.ok(worlds.every((world) => world.boxes.buffer === worlds[0].boxes.buffer));
  // Views that were handed out before others are used stay.
  const views = worlds.map((world) => world.boxes);
  const all = worlds.map((_, i) => scatter(8, random(i), 2));
  worlds.forEach((world, i) => world.insertMany(all[i]));
  worlds.forEach((world, i) => {
    assert.equal(world.boxes, views[i]);
    assert.deepEqual(texts(world.step().found), bruteForce(all[i]));
  });
  const snapshot = worlds[1].save();
  const copy = worlds[2].copy();
  worlds[2].clear();
  worlds[2].load(snapshot);
  assert.deepEqual(texts(worlds[2].step().pairs), bruteForce(all[1]));
  worlds[2].restore(copy);
  assert.deepEqual(texts(worlds[2].step().pairs), bruteForce(all[2]));
  worlds.forEach((world, i) => assert.deepEqual(texts(world.step().pairs), bruteForce(all[i])));
  await assert.rejects(createWorlds(2, { objects: 8, grows: true }), { name: "InvalidArgumentError", field: "grows" });
  await assert.rejects(createWorlds(1.5, config), { field: "count" });
  assert.deepEqual(await createWorlds(0, config), []);
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

test("a program of one file has the module in itself", async () => {
  const inline = await import("trisap/inline");
  const world = await inline.createWorld({ objects: 2 });
  world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2]));
  assert.deepEqual([...world.step().pairs], [0, 1]);
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

test("a world goes back to a copy, byte for byte, also where it has grown", async () => {
  const next = random(8);
  const world = await createWorld({ objects: 40, events: true, grows: true });
  world.insertMany(scatter(40, next, 4));
  world.step();
  // What is written before a copy is in it.
  world.boxes.set(scatter(3, next, 4), 60);
  let kept = world.copy();
  const play = (seed) => {
    const moves = random(seed);
    const told = [];
    for (let frame = 0; frame < 8; frame++) {
      world.boxes.set(scatter(5, moves, 4), 6 * Math.floor(moves() * 30));
      if (frame === 4) {
        world.insertMany(scatter(60, moves, 4));
      }
      const { pairs, found, lost } = world.step();
      told.push([pairs, found, lost].map((some) => some.slice()), world.stats());
    }
    return told;
  };
  const told = play(1);
  assert.ok(world.config.objects > 40 && told[0].every((pairs) => pairs.length > 0));
  for (let again = 0; again < 3; again++) {
    world.restore(kept);
    assert.equal(world.size, 40);
    assert.equal(world.boxes.length, 240);
    // Memory that is used again.
    assert.equal(world.copy(kept), kept);
    play(9 + again);
    world.restore(kept);
    assert.deepEqual(play(1), told);
  }
  const other = await createWorld({ objects: 40, events: true });
  for (const copy of [other.copy(), world.save(), null]) {
    assert.throws(() => world.restore(copy), { name: "InvalidArgumentError", field: "copy" });
  }
});

test("sorted results are the same after another past and in other room", async () => {
  const next = random(9);
  const world = await createWorld({ objects: 600, events: true });
  world.insertMany(scatter(600, next, 9));
  for (let frame = 0; frame < 6; frame++) {
    world.boxes.set(scatter(20, next, 9), 6 * Math.floor(next() * 500));
    world.step();
  }
  const late = await createWorld({ objects: 3000, events: true });
  late.load(world.save());
  for (let frame = 0; frame < 4; frame++) {
    const moved = scatter(20, next, 9);
    const [one, other] = [world, late].map((some) => {
      some.boxes.set(moved, 600);
      const { pairs, found, lost } = some.step().sortResults();
      return [pairs, found, lost].map((list) => list.slice());
    });
    assert.deepEqual(one, other);
    assert.ok(one[0].length > 200);
  }
});

test("a module with pairs alone has the same pairs, and refuses the rest", async () => {
  const [small, whole] = await Promise.all([true, false].map((pairsOnly) => createWorld({ objects: 8, grows: true }, { pairsOnly })));
  assert.equal(small.variant, hasVectors() ? "pairs" : "scalar");
  const [next, worlds] = [random(5), [small, whole]];
  let boxes = scatter(2000, next, 3);
  const ids = worlds.map((world) => world.insertMany(boxes));
  for (let frame = 0; frame < 8; frame++) {
    boxes = boxes.map((x, i) => x + (i % 30 < 6 * (frame % 4) ? 0.25 : 0));
    worlds.forEach((world, i) => {
      world.boxes.set(boxes);
      world.remove(ids[i][frame]);
      world.setResting([ids[i][100 + frame]]);
    });
    assert.deepEqual(texts(small.step().pairs), texts(whole.step().pairs));
    assert.deepEqual(texts(small.awakePairs()), texts(whole.awakePairs()));
    assert.ok(small.pairs.length > 1000);
  }
  small.boxes.set([7, 7, 7, 8, 8, 8], 6 * 500);
  small.commit();
  assert.deepEqual([...small.box(ids[0][500])], [7, 7, 7, 8, 8, 8]);
  const kept = small.copy();
  small.remove(ids[0][500]);
  small.step();
  small.restore(kept);
  assert.deepEqual(texts(small.pairs), texts(whole.pairs));
  if (small.variant === "pairs") {
    for (const [field, value] of [["events", true], ["filters", true], ["values", true], ["marginMin", 0]]) {
      await assert.rejects(createWorld({ objects: 8, [field]: value }, { pairsOnly: true }), { name: "InvalidArgumentError", field });
    }
    assert.throws(() => small.firstHit({ origin: [0, 0, 0], direction: [1, 0, 0] }), { name: "ModuleError" });
    assert.throws(() => small.save(), { name: "ModuleError" });
  }
  // What needs the complete module takes it.
  assert.deepEqual([...(await pairs([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2], { pairsOnly: true }))], [0, 1]);
});
