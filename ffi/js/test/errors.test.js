// Refusals are exceptions that say what they are about; the world is as it was before, or the step has happened.

import assert from "node:assert/strict";
import { test } from "node:test";
import * as trisap from "trisap";
import { random, scatter } from "./brute.js";

const { createWorld, slotOf } = trisap;

/** The exception, which is of a class and has these fields. */
function refused(call, type, fields = {}) {
  let caught = null;
  try {
    call();
  } catch (error) {
    caught = error;
  }
  assert.ok(caught instanceof type, `${type.name}, not ${caught}`);
  assert.ok(caught instanceof trisap.TrisapError);
  assert.equal(caught.name, type.name);
  for (const [field, value] of Object.entries(fields)) {
    assert.deepEqual(caught[field], value, `${type.name}.${field}`);
  }
  return caught;
}

test("boxes that are none", async () => {
  const world = await createWorld({ objects: 4 });
  const id = world.insert([0, 0, 0, 1, 1, 1]);
  refused(() => world.insert([0, 0, NaN, 1, 1, 1]), trisap.BadBoxError);
  const boxes = new Float32Array([0, 0, 0, 1, 1, 1, 0, 2, 0, 1, 1, 1]);
  const error = refused(() => world.insertMany(boxes), trisap.BadBoxError, { index: 1, id: null });
  assert.match(error.message, /box 1/);
  const bad = refused(() => world.update(id, [2, 0, 0, 1, 1, 1]), trisap.BadBoxError, { id, slot: 0 });
  assert.match(bad.message, new RegExp(`object ${id}`));
  refused(() => world.insert([1, 2, 3]), trisap.InvalidArgumentError);
  refused(() => world.insertMany([1, 2, 3]), trisap.InvalidArgumentError, { field: "boxes" });
  assert.equal(world.size, 1);
  assert.deepEqual([...world.box(id)], [0, 0, 0, 1, 1, 1]);
});

test("a step names the object whose box is bad, and has happened", async () => {
  const world = await createWorld({ objects: 4 });
  const ids = world.insertMany(scatter(3, random(1), 0));
  world.step();
  world.boxes[6 * 1] = NaN;
  world.boxes[6 * 2 + 1] = Infinity;
  world.boxes.set([50, 50, 50, 51, 51, 51], 0);
  const error = refused(() => world.step(), trisap.BadBoxError, { id: ids[1], slot: 1, count: 2 });
  assert.match(error.message, /slot 1/);
  assert.deepEqual([...world.pairs], [1, 2]);
});

test("ids of objects that are gone", async () => {
  const world = await createWorld({ objects: 4, filters: true });
  const old = world.insert([0, 0, 0, 1, 1, 1]);
  world.remove(old);
  const other = world.insert([0, 0, 0, 1, 1, 1]);
  assert.equal(slotOf(old), slotOf(other));
  const box = [0, 0, 0, 1, 1, 1];
  const calls = [
    () => world.remove(old), () => world.update(old, box), () => world.box(old), () => world.setFilter(old, {}),
    () => world.removeMany([other, old]), () => world.setResting([old]), () => world.wake(BigUint64Array.of(old)),
  ];
  for (const call of calls) {
    const error = refused(call, trisap.StaleIdError, { id: old, slot: 0 });
    assert.match(error.message, new RegExp(`object ${old}`));
  }
  refused(() => world.removeMany([other, other]), trisap.StaleIdError, { id: other });
  refused(() => world.removeMany([other, other, other, other, other]), trisap.StaleIdError, { id: other });
  assert.ok(world.has(other) && !world.has(old));
  assert.equal(world.idAt(0), other);
  assert.equal(world.idAt(1), null);
});

test("what is refused has taken in no box", async () => {
  const world = await createWorld({ objects: 4 });
  const [id, gone] = world.insertMany(Float32Array.of(0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1));
  world.remove(gone);
  world.step();
  world.boxes.set([7, 7, 7, 8, 8, 8]);
  for (const call of ["setResting", "setEnabled"]) {
    for (const ids of [[id, gone], BigUint64Array.of(id, gone), [id, id, id, id, gone]]) {
      refused(() => world[call](ids, false), trisap.StaleIdError, { id: gone });
      assert.deepEqual([...world.box(id)], [0, 0, 0, 1, 1, 1]);
    }
    refused(() => world[call]([id, 0n], false), trisap.StaleIdError, { id: 0n });
  }
  assert.ok(world.isEnabled(id) && !world.isResting(id));
  world.setResting([id]);
  assert.deepEqual([...world.box(id)], [7, 7, 7, 8, 8, 8]);
});

test("an object may come any number of times", async () => {
  for (const objects of [1, 2, 900]) {
    const world = await createWorld({ objects, filters: true, values: true });
    const id = world.insert([0, 0, 0, 1, 1, 1]);
    for (const times of [2, 100_000]) {
      const ids = new Array(times).fill(id);
      const last = (before, value) => ids.map((_, i) => (i < times - 1 ? before : value));
      world.setResting(ids);
      assert.ok(world.isResting(id));
      world.wake(BigUint64Array.from(ids));
      assert.ok(!world.isResting(id));
      world.setEnabled(ids, false);
      assert.ok(!world.isEnabled(id));
      world.setEnabled(ids, true);
      world.setFilters(ids, { mask: 3 });
      world.setFilters(ids, last({ mask: 1 }, { mask: 2 }));
      world.setValues(ids, last(4n, 5n));
      assert.equal(world.value(id), 5n);
      refused(() => world.removeMany(ids), trisap.StaleIdError, { id });
      for (const call of [(ids) => world.setResting(ids), (ids) => world.wake(ids), (ids) => world.setFilters(ids, {})]) {
        refused(() => call([...ids, id + 1n]), trisap.StaleIdError, { id: id + 1n });
      }
    }
  }
});

test("slots that are named", async () => {
  const world = await createWorld({ objects: 4 });
  const id = world.insertAt(2, [0, 0, 0, 1, 1, 1]);
  assert.deepEqual([slotOf(id), world.idAt(2), world.size], [2, id, 1]);
  assert.equal(slotOf(world.insert([0, 0, 0, 1, 1, 1])), 0);
  refused(() => world.insertAt(2, [0, 0, 0, 1, 1, 1]), trisap.SlotTakenError, { id, slot: 2 });
  refused(() => world.insertAt(9, [0, 0, 0, 1, 1, 1]), trisap.ObjectsFullError, { needed: 10, capacity: 4 });
  refused(() => world.insertAt(-1, [0, 0, 0, 1, 1, 1]), trisap.InvalidArgumentError, { field: "slot" });
  assert.equal(world.step().pairs.length, 2);
  const growing = await createWorld({ objects: 4, grows: true });
  assert.equal(slotOf(growing.insertAt(900, [0, 0, 0, 1, 1, 1])), 900);
});

test("capacities", async () => {
  const world = await createWorld({ objects: 8, pairs: 5 });
  world.insertMany(scatter(8, random(1), 0));
  refused(() => world.insert([0, 0, 0, 1, 1, 1]), trisap.ObjectsFullError, { needed: 9, capacity: 8 });
  refused(() => world.insertMany(scatter(3, random(1))), trisap.ObjectsFullError, { needed: 11, capacity: 8 });
  refused(() => world.step(), trisap.PairsFullError, { needed: 28, capacity: 5 });
  assert.equal(world.pairs.length, 10);
});

test("configurations", async () => {
  const bad = [
    [{}, "objects"], [{ objects: -1 }, "objects"], [{ objects: 1.5 }, "objects"], [{ objects: 1, event: true }, "event"],
    [{ objects: 1, mode: "loose" }, "mode"], [{ objects: 1, events: 1 }, "events"], [{ objects: 1, marginMin: -1 }, "marginMin"],
    [{ objects: 1, grows: 2 }, "grows"], [undefined, "config"], [{ objects: 2 ** 28 }, "objects"],
    [{ objects: 1, marginMin: 2, marginMax: 1 }, "margins"],
  ];
  for (const [config, field] of bad) {
    const error = await createWorld(config).catch((error) => error);
    assert.ok(error instanceof trisap.InvalidArgumentError, `${JSON.stringify(config)}: ${error}`);
    assert.equal(error.field, field);
  }
});

test("filters, queries and snapshots", async () => {
  const world = await createWorld({ objects: 4 });
  const id = world.insert([0, 0, 0, 1, 1, 1]);
  refused(() => world.setFilter(id, {}), trisap.NoFiltersError);
  refused(() => world.setMargin(id, 1), trisap.NoMarginsError);
  const filtered = await createWorld({ objects: 4, filters: true });
  const other = filtered.insert([0, 0, 0, 1, 1, 1]);
  refused(() => filtered.setFilter(other, { objectClass: 32 }), trisap.BadClassError, { objectClass: 32 });
  refused(() => filtered.setClasses([1, 2]), trisap.InvalidArgumentError, { field: "meets" });
  refused(() => world.overlaps({ center: [0, 0, 0], radius: -1 }), trisap.BadQueryError);
  refused(() => world.overlaps({ min: [0, 0], max: [1, 1] }), trisap.InvalidArgumentError);
  refused(() => world.firstHit({ origin: [0, NaN, 0], direction: [1, 0, 0] }), trisap.BadQueryError);
  refused(() => world.nearest([0, 0, 0], -1), trisap.InvalidArgumentError, { field: "count" });
  const snapshot = world.save();
  snapshot[40] ^= 1;
  refused(() => world.load(snapshot), trisap.BadSnapshotError);
  refused(() => world.load(filtered.save()), trisap.BadSnapshotError);
  assert.equal(world.size, 1);
});

test("a host that gives no memory", async () => {
  const { grow } = WebAssembly.Memory.prototype;
  const world = await createWorld({ objects: 1000 });
  const growing = await createWorld({ objects: 1, grows: true });
  refused(() => growing.insertAt(3_000_000_000, [0, 0, 0, 1, 1, 1]), trisap.OutOfMemoryError);
  try {
    WebAssembly.Memory.prototype.grow = () => {
      throw new RangeError("no memory");
    };
    const error = await createWorld({ objects: 100_000 }).catch((error) => error);
    assert.ok(error instanceof trisap.OutOfMemoryError, `${error}`);
    assert.ok(error.bytes > 24 * 100_000);
    refused(() => growing.insertMany(new Float32Array(6_000_000)), trisap.OutOfMemoryError);
    growing.insert([0, 0, 0, 1, 1, 1]);
    assert.equal(growing.step().size, 1);
  } finally {
    WebAssembly.Memory.prototype.grow = grow;
  }
  // The world goes on.
  world.insertMany(scatter(1000, random(1), 3));
  assert.equal(world.size, 1000);
});

test("fields and ids that mean nothing", async () => {
  const world = await createWorld({ objects: 4, filters: true });
  const id = world.insert([0, 0, 0, 1, 1, 1]);
  const [origin, direction] = [[0, 0, 0], [1, 0, 0]];
  refused(() => world.setFilter(id, { groups: 3 }), trisap.InvalidArgumentError, { field: "groups" });
  refused(() => world.setFilters([id], [{ group: 3 }, {}]), trisap.InvalidArgumentError, { field: "filters" });
  refused(() => world.firstHit({ origin, direction, distnce: 3 }), trisap.InvalidArgumentError, { field: "distnce" });
  refused(() => world.hits({ origin, box: [0, 0, 0, 1, 1, 1], direction }), trisap.InvalidArgumentError, { field: "origin" });
  refused(() => world.overlaps({ center: origin, radius: 1, min: origin }), trisap.InvalidArgumentError, { field: "min" });
  refused(() => world.overlaps(), trisap.InvalidArgumentError, { field: "region" });
  refused(() => world.shiftOrigin([1, 2]), trisap.InvalidArgumentError, { field: "by" });
  refused(() => world.shiftOrigin([1, 2, NaN]), trisap.InvalidArgumentError, { field: "by" });
  [undefined, NaN, -1, 0.5, 2 ** 32].forEach((slot) => assert.equal(world.idAt(slot), null));
  for (const no of [0, "0", null, undefined, -1n, 2n ** 64n]) {
    const calls = [
      () => world.update(no, [0, 0, 0, 1, 1, 1]), () => world.remove(no), () => world.has(no), () => world.box(no),
      () => world.removeMany([no]), () => world.values([no]), () => world.isResting(no), () => trisap.slotOf(no), () => trisap.idText(no),
    ];
    calls.forEach((call) => refused(call, trisap.InvalidArgumentError, { field: "id" }));
  }
  assert.match(refused(() => world.update(0, [0, 0, 0, 1, 1, 1]), trisap.InvalidArgumentError).message, /bigint.*not number 0.*idAt/);
  refused(() => trisap.idOf("x"), trisap.InvalidArgumentError, { field: "text" });
  assert.equal(trisap.idOf(JSON.parse(JSON.stringify({ id: trisap.idText(id) })).id), id);
});

test("what came instead of the module is told", async () => {
  const page = () => new Response("<!doctype html>", { headers: { "content-type": "text/html" } });
  for (const wasm of [page(), new TextEncoder().encode("<!doctype html>"), new ArrayBuffer(0), new Response("", { status: 404 })]) {
    const error = await createWorld({ objects: 1 }, { wasm }).catch((error) => error);
    assert.ok(error instanceof trisap.ModuleError, `${error}`);
    assert.match(error.message, /wasm|inline/);
  }
  const error = await createWorld({ objects: 1 }, { wasm: page() }).catch((error) => error);
  assert.match(error.message, /text\/html/);
});
