// Values of objects, and of the pairs that they are or were.

import assert from "node:assert/strict";
import { test } from "node:test";
import { createWorld, InvalidArgumentError, NoValuesError, slotOf, StaleIdError } from "trisap";
import { bruteForce, move, random, scatter, texts, without } from "./brute.js";

for (const simd of [false, true]) {
  test(`${simd ? "simd128" : "scalar"}: lost pairs have the values of the objects that were the pair`, async () => {
    const next = random(11);
    const world = await createWorld({ objects: 300, pairs: 20000, events: true, values: true }, { simd });
    const living = new Map();
    // By slot, in this step and in the one before.
    let [values, before, pairsBefore] = [new Map(), new Map(), []];
    let [named, serial] = [0, 2n ** 63n];
    for (let step = 0; step < 15; step++) {
      for (const id of [...living.values()].filter(() => next() < 0.3)) {
        world.remove(id);
        living.delete(slotOf(id));
      }
      const ids = world.insertMany(scatter(300 - living.size, next));
      const given = Array.from(ids, () => serial++);
      world.setValues(ids, given);
      ids.forEach((id, i) => living.set(slotOf(id), id));
      [before, values] = [values, new Map([...values].filter(([slot]) => living.has(slot)))];
      ids.forEach((id, i) => values.set(slotOf(id), given[i]));
      move(world.boxes, next, 0.2);
      const expected = bruteForce(world.boxes);
      const { pairs, found, lost } = world.step();
      assert.deepEqual(texts(pairs), expected);
      assert.deepEqual(without(texts(lost), texts(found)), without(pairsBefore, expected));
      const of = (slots, known) => Array.from(slots, (slot) => known.get(slot));
      // Copies: the calls may grow the memory that the views are in.
      const [all, came, went] = [pairs.slice(), found.slice(), lost.slice()];
      assert.deepEqual([...world.pairValues()], of(all, values));
      assert.deepEqual([...world.pairValues("found")], of(came, values));
      assert.deepEqual([...world.pairValues("lost")], of(went, before), `step ${step}`);
      named += went.length;
      pairsBefore = expected;
    }
    assert.ok(named > 100, `${named}`);
    const [first, second] = living.values();
    world.setValue(first, 5n);
    assert.equal(world.value(first), 5n);
    assert.deepEqual([...world.values([second, first])], [values.get(slotOf(second)), 5n]);
    const other = await createWorld(world.config, { simd });
    other.load(world.save());
    assert.equal(other.value(first), 5n);
  });
}

test("values are refused where there are none", async () => {
  const world = await createWorld({ objects: 2 });
  const id = world.insert([0, 0, 0, 1, 1, 1]);
  for (const call of [() => world.setValue(id, 1n), () => world.value(id), () => world.pairValues("found")]) {
    assert.throws(call, NoValuesError);
  }
  assert.throws(() => world.setValues([id], []), InvalidArgumentError);
  assert.throws(() => world.pairValues("all"), InvalidArgumentError);
  const other = await createWorld({ objects: 2, values: true });
  assert.throws(() => other.setValue(id, 1n), StaleIdError);
  assert.equal(other.config.values, true);
});

test("values of a pair that never was are not told", async () => {
  const world = await createWorld({ objects: 4, events: true, values: true });
  const [one, other] = world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2]));
  world.setValues([one, other], [100n, 200n]);
  world.step();
  world.remove(other);
  const newcomer = world.insert([50, 0, 0, 51, 1, 1]);
  world.setValue(newcomer, 300n);
  assert.equal(slotOf(newcomer), slotOf(other));
  assert.deepEqual([...world.pairValues()], []);
  assert.deepEqual([...world.pairValues("found")], []);
  world.step();
  assert.deepEqual([...world.pairValues("lost")], [100n, 200n]);
});
