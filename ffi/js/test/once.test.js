// Pairs of boxes that are there once.

import assert from "node:assert/strict";
import { test } from "node:test";
import { BadBoxError, createWorld, InvalidArgumentError, pairs, slotOf } from "trisap";
import { bruteForce, overlap, random, scatter, texts } from "./brute.js";

test("pairs are those of brute force, and no room has to be known", async () => {
  for (const simd of [true, false]) {
    for (const [count, edge] of [[0, 1], [1, 1], [50, 4], [700, 10], [300, 0.5]]) {
      const boxes = scatter(count, random(count), edge);
      assert.deepEqual(texts(await pairs(boxes, { simd })), bruteForce(boxes));
      const first = Math.floor(count / 3);
      const between = await pairs(boxes.slice(0, 6 * first), { simd, between: boxes.slice(6 * first) });
      const expected = [];
      for (let a = 0; a < first; a++) {
        for (let b = first; b < count; b++) {
          if (overlap(boxes, a, b)) {
            expected.push(`${a} ${b - first}`);
          }
        }
      }
      assert.deepEqual(texts(between), expected.sort());
    }
  }
});

test("what is left out may be undefined, and numbers may stand in anything like an array", async () => {
  const boxes = [0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2];
  assert.deepEqual([...(await pairs(boxes, { between: undefined }))], [0, 1]);
  assert.deepEqual([...(await pairs(boxes, { between: null }))], [0, 1]);
  const world = await createWorld({ objects: 2, filters: true });
  const [first] = world.insertMany(Float32Array.from(boxes));
  world.setFilter(first, { group: undefined, mask: 0xffff_ffff });
  assert.deepEqual([...world.step().pairs], [0, 1]);
  const [[nearest]] = world.nearestMany({ length: 3, 0: 2, 1: 2, 2: 2.5 }, 1);
  assert.equal(slotOf(nearest.id), 1);
});

test("a bad box is named", async () => {
  const boxes = scatter(9, random(1));
  boxes[6 * 7] = NaN;
  const named = (error) => error instanceof BadBoxError && error.index === 7;
  await assert.rejects(pairs(boxes), named);
  await assert.rejects(pairs(boxes.slice(0, 24), { between: boxes.slice(24) }), named);
  await assert.rejects(pairs([1, 2, 3]), InvalidArgumentError);
});

test("what is between planes, and the nearest of many points", async () => {
  const boxes = scatter(400, random(3));
  const world = await createWorld({ objects: 400, pairs: 30000 });
  const ids = world.insertMany(boxes);
  world.step();
  // x + y <= 9 and z >= 2.
  const inside = Array.from(ids, slotOf).filter((slot) => boxes[6 * slot] + boxes[6 * slot + 1] <= 9 && boxes[6 * slot + 5] >= 2);
  const planes = [1, 1, 0, 9, 0, 0, -1, -2];
  assert.deepEqual(Array.from(world.within(planes), slotOf), inside);
  assert.deepEqual(Array.from(world.within(planes, (id) => id !== ids[inside[0]]), slotOf), inside.slice(1));
  assert.equal(world.within([]).length, 400);
  const points = Array.from({ length: 3 * 500 }, random(4)).map((x) => 10 * x);
  for (const count of [0, 1, 5]) {
    const many = world.nearestMany(points, count);
    assert.equal(many.length, 500);
    many.forEach((near, i) => assert.deepEqual(near, world.nearest(points.slice(3 * i, 3 * i + 3), count)));
  }
  // More than there are take no more room.
  assert.deepEqual(world.nearestMany(points.slice(0, 3), 1e9), [world.nearest(points.slice(0, 3), 1e9)]);
});
