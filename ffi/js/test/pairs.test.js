// Pairs, found and lost, against brute force.

import assert from "node:assert/strict";
import { test } from "node:test";
import { createWorld, slotOf } from "trisap";
import { bruteForce, move, random, scatter, texts, without } from "./brute.js";

for (const simd of [false, true]) {
  const variant = simd ? "simd128" : "scalar";

  for (const [count, share, steps] of [[3, 1, 10], [60, 1, 10], [200, 0.5, 10], [1000, 1, 6], [1500, 0.05, 8]]) {
    test(`${variant}: ${count} objects of which ${share} move`, async () => {
      const next = random(count);
      const edge = Math.cbrt(count);
      const world = await createWorld({ objects: count, events: true, pairs: 40 * count }, { simd });
      assert.deepEqual([world.variant, world.instructionSet], [variant, variant]);
      world.insertMany(scatter(count, next, edge));
      let [before, all] = [[], 0];
      for (let step = 0; step < steps; step++) {
        const { pairs, found, lost } = world.step();
        const expected = bruteForce(world.boxes);
        assert.deepEqual(texts(pairs), expected, `step ${step}`);
        assert.deepEqual(texts(found), without(expected, before), `step ${step}`);
        assert.deepEqual(texts(lost), without(before, expected), `step ${step}`);
        assert.equal(world.stats().pairs, expected.length);
        before = expected;
        all += expected.length;
        move(world.boxes, next, share);
      }
      assert.ok(all > 0, "no pair was ever there");
    });
  }

  test(`${variant}: boxes far from the origin are too fine for floats`, async () => {
    const world = await createWorld({ objects: 2 }, { simd });
    world.insert([0, 0, 0, 1, 1, 1]);
    assert.equal(world.isCoarse(), false);
    world.insert([1e9, 0, 0, 1e9 + 64, 1, 1]);
    assert.equal(world.isCoarse(), true);
  });

  test(`${variant}: objects come and go`, async () => {
    const next = random(7);
    const world = await createWorld({ objects: 400, events: true, pairs: 20000 }, { simd });
    const living = new Map();
    let before = [];
    for (let step = 0; step < 20; step++) {
      for (const id of [...living.values()].filter(() => next() < 0.2)) {
        world.remove(id);
        living.delete(slotOf(id));
        assert.equal(world.has(id), false);
      }
      const more = scatter(Math.min(60, 400 - living.size), next);
      for (const id of world.insertMany(more)) {
        living.set(slotOf(id), id);
      }
      for (const id of living.values()) {
        if (next() < 0.1) {
          world.update(id, scatter(1, next));
        }
      }
      assert.equal(world.size, living.size);
      const expected = bruteForce(world.boxes, (slot) => living.has(slot));
      world.step();
      assert.deepEqual(texts(world.pairs), expected, `step ${step}`);
      // Two objects in the slots of two others are another pair, under the same name: it may be found and lost at once.
      const found = without(texts(world.found), texts(world.lost));
      const lost = without(texts(world.lost), texts(world.found));
      assert.deepEqual(found, without(expected, before), `step ${step}`);
      assert.deepEqual(lost, without(before, expected), `step ${step}`);
      before = expected;
    }
    assert.ok(before.length > 0);
  });
}

test("the choices of a configuration change no pair", async () => {
  const boxes = scatter(600, random(3));
  const expected = bruteForce(boxes);
  for (const extra of [{ mode: "exact" }, { marginPerExtent: 0.1 }, { fixedMargins: true, marginMin: 0.5 }]) {
    const world = await createWorld({ objects: 600, pairs: 30000, ...extra });
    const [field] = Object.keys(extra);
    assert.ok(Math.abs(Number(world.config[field]) - extra[field]) < 1e-6 || world.config[field] === extra[field]);
    world.insertMany(boxes);
    for (let step = 0; step < 3; step++) {
      assert.deepEqual(texts(world.step().pairs), expected, JSON.stringify(extra));
    }
  }
});

test("filters and classes decide who meets", async () => {
  const next = random(11);
  const boxes = scatter(300, next);
  const world = await createWorld({ objects: 300, pairs: 30000, filters: true });
  const ids = world.insertMany(boxes);
  const filters = Array.from(ids, () => ({ group: 1 << (next() * 3), mask: Math.floor(next() * 8), objectClass: Math.floor(next() * 2) }));
  ids.forEach((id, i) => world.setFilter(id, filters[i]));
  const classes = new Uint32Array(32).fill(0xffff_ffff);
  classes[0] = 0xffff_fffe;
  world.setClasses(classes);
  const meet = (a, b) => {
    const [one, other] = [filters[a], filters[b]];
    const groups = (one.group & other.mask) !== 0 && (other.group & one.mask) !== 0;
    return groups && (one.objectClass !== 0 || other.objectClass !== 0);
  };
  const expected = bruteForce(boxes, undefined, meet);
  assert.ok(expected.length > 0 && expected.length < bruteForce(boxes).length);
  assert.deepEqual(texts(world.step().pairs), expected);
});

test("objects at rest keep their pairs", async () => {
  const next = random(12);
  const world = await createWorld({ objects: 300, pairs: 30000, events: true });
  const ids = world.insertMany(scatter(300, next));
  world.step();
  world.setResting(ids.subarray(0, 150));
  for (let step = 0; step < 4; step++) {
    move(world.boxes.subarray(6 * 150), next);
    assert.deepEqual(texts(world.step().pairs), bruteForce(world.boxes));
  }
  world.wake(ids.subarray(0, 150));
  move(world.boxes, next);
  assert.deepEqual(texts(world.step().pairs), bruteForce(world.boxes));
});

test("a step says why its pairs were found as they were", async () => {
  // Without room for the pairs of boxes with margins those without are found, too: of all reasons the last one.
  const world = await createWorld({ objects: 400, pairs: 1, marginMin: 3 });
  world.insertMany(Float32Array.from({ length: 6 * 400 }, (_, i) => 2 * Math.floor(i / 6) + (i % 6 < 3 ? 0 : 1)));
  assert.equal(world.step().stats().reason, "no room for surplus");
});
