// Regions, rays, nearest objects and snapshots.

import assert from "node:assert/strict";
import { test } from "node:test";
import { BadQueryError, createWorld, InvalidArgumentError, slotOf } from "trisap";
import { bruteForce, move, random, scatter, texts } from "./brute.js";

async function scene(extra = {}) {
  const next = random(5);
  const world = await createWorld({ objects: 500, pairs: 30000, ...extra });
  const boxes = scatter(500, next);
  const ids = world.insertMany(boxes);
  world.step();
  return { world, boxes, ids, next };
}

test("regions hold what brute force says", async () => {
  const { world, boxes, ids } = await scene();
  const slots = (answer) => Array.from(answer, slotOf);
  const inBox = ({ min, max }) => Array.from(ids, slotOf).filter((slot) =>
    [0, 1, 2].every((axis) => boxes[6 * slot + axis] <= max[axis] && boxes[6 * slot + 3 + axis] >= min[axis]));
  const region = { min: [2, 2, 2], max: [6, 7, 8] };
  assert.ok(inBox(region).length > 64, "the room for answers has to grow");
  assert.deepEqual(slots(world.overlaps(region)), inBox(region));
  const inBall = ({ center, radius }) => Array.from(ids, slotOf).filter((slot) => {
    const gap = [0, 1, 2].map((axis) =>
      Math.max(boxes[6 * slot + axis] - center[axis], center[axis] - boxes[6 * slot + 3 + axis], 0));
    return gap[0] ** 2 + gap[1] ** 2 + gap[2] ** 2 <= radius ** 2;
  });
  const ball = { center: [5, 5, 5], radius: 2 };
  assert.ok(inBall(ball).length > 0);
  assert.deepEqual(slots(world.overlaps(ball)), inBall(ball));
  assert.equal(world.overlaps({ min: [90, 90, 90], max: [91, 91, 91] }).length, 0);
});

test("a ray meets the first object", async () => {
  const world = await createWorld({ objects: 3 });
  const far = world.insert([8, 0, 0, 9, 1, 1]);
  const near = world.insert([4, 0, 0, 5, 1, 1]);
  world.step();
  const ray = { origin: [0, 0.5, 0.5], direction: [2, 0, 0] };
  assert.deepEqual(world.firstHit(ray), { id: near, distance: 2 });
  assert.equal(world.firstHit({ ...ray, distance: 1 }), null);
  assert.deepEqual(world.firstHit({ box: [-1, 0, 0, 0, 1, 1], direction: [1, 0, 0] }), { id: near, distance: 4 });
  assert.deepEqual(world.nearest([7, 0.5, 0.5], 5), [{ id: far, distance: 1 }, { id: near, distance: 2 }]);
});

test("a visit sees the nearest objects first, each once, as far as its visitor says", async () => {
  const { world, boxes, ids } = await scene();
  const point = [4, 5, 6];
  const gap = (slot) => {
    const sides = [0, 1, 2].map((axis) =>
      Math.max(boxes[6 * slot + axis] - point[axis], point[axis] - boxes[6 * slot + 3 + axis], 0));
    return Math.hypot(...sides);
  };
  const near = (a, b) => Math.abs(a - b) <= 1e-12 * (1 + b);
  const all = Array.from(ids, (id) => ({ id, distance: gap(slotOf(id)) }))
    .sort((a, b) => a.distance - b.distance || slotOf(a.id) - slotOf(b.id));
  const seen = (answer, distance) => {
    const hits = [];
    world.visitNearest(point, (hit) => (hits.push(hit), answer?.(hit, hits.length)), distance);
    return hits;
  };
  // All of them: more than are asked for at first, or at the second time.
  const whole = seen();
  assert.equal(whole.length, 500);
  assert.equal(new Set(whole.map(({ id }) => id)).size, 500);
  assert.ok(whole.every((hit, i) => near(hit.distance, all[i].distance) && near(hit.distance, gap(slotOf(hit.id)))));
  assert.deepEqual(whole, world.nearest(point, 500));
  assert.deepEqual(seen(() => Infinity), whole);
  // As far as a distance, and not beyond; those of that distance are seen.
  const some = whole.filter((hit) => hit.distance <= whole[99].distance);
  assert.deepEqual(seen(undefined, whole[99].distance), some);
  // A visitor ends it, or brings it nearer, but never farther.
  for (const last of [1, 7, 8, 9, 64, 65, 500]) {
    assert.equal(seen((_, count) => (count === last ? -1 : Infinity)).length, last);
  }
  assert.deepEqual(seen((hit, count) => (count === 3 ? whole[99].distance : 1e9)), some);
  // The nearest shape is not that of the nearest box.
  const shape = (id) => gap(slotOf(id)) + (slotOf(id) * 7919 % 13) / 4;
  let best = null;
  let visits = 0;
  world.visitNearest(point, ({ id }) => {
    visits++;
    if (slotOf(id) % 2 === 0) {
      return;
    }
    best = best === null || shape(id) < shape(best) ? id : best;
    return shape(best);
  });
  const odd = Array.from(ids).filter((id) => slotOf(id) % 2 === 1);
  assert.equal(best, odd.reduce((a, b) => (shape(b) < shape(a) ? b : a)));
  assert.ok(visits < 500, "it does not see all");
  // An empty world, and what is refused.
  (await createWorld({ objects: 2 })).visitNearest(point, () => assert.fail("there is no object"));
  for (const distance of [NaN, -1, null, "1"]) {
    assert.throws(() => seen(undefined, distance), BadQueryError);
  }
  assert.throws(() => world.visitNearest([NaN, 0, 0], () => {}), BadQueryError);
  assert.throws(() => world.visitNearest([0, 0], () => {}), InvalidArgumentError);
});

test("a snapshot brings everything back, also in another world", async () => {
  const { world, next } = await scene({ events: true });
  const snapshot = world.save();
  const [pairs, boxes] = [texts(world.pairs), world.boxes.slice()];
  move(world.boxes, next);
  world.step();
  assert.notDeepEqual(texts(world.pairs), pairs);
  const other = await createWorld(world.config);
  for (const one of [world, other]) {
    one.load(snapshot);
    assert.equal(one.size, 500);
    assert.deepEqual(texts(one.pairs), pairs);
    assert.deepEqual(one.boxes, boxes);
    move(one.boxes, random(9));
    assert.deepEqual(texts(one.step().pairs), bruteForce(one.boxes));
    assert.ok(one.found.length > 0 && one.lost.length > 0);
  }
  assert.deepEqual(world.pairs, other.pairs);
});

test("the origin moves, and the boxes with it", async () => {
  const { world, boxes } = await scene();
  const pairs = texts(world.pairs);
  assert.equal(world.shiftOrigin([16, -8, 4]), 0);
  assert.deepEqual(world.boxes, boxes.map((bound, i) => bound - [16, -8, 4][i % 3]));
  assert.deepEqual(texts(world.step().pairs), pairs);
});
