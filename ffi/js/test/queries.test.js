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

test("boxes that were written move with the origin", async () => {
  const world = await createWorld({ objects: 3 });
  const ids = world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 10, 0, 0, 11, 1, 1, 20, 0, 0, 21, 1, 1]));
  world.step();
  world.setResting([ids[2]]);
  world.boxes.set([100, 0, 0, 101, 1, 1, 100.5, 0, 0, 101.5, 1, 1, 100, 0.1, 0, 101, 1, 1]);
  world.shiftOrigin([100, 0, 0]);
  assert.deepEqual([...world.step().pairs], [0, 1]);
  assert.deepEqual([...world.box(ids[0])], [0, 0, 0, 1, 1, 1]);
  // That of an object at rest waits until it wakes, as without a shift.
  assert.deepEqual([...world.box(ids[2])], [-80, 0, 0, -79, 1, 1]);
  world.wake([ids[2]]);
  assert.deepEqual(texts(world.step().pairs), ["0 1", "0 2", "1 2"]);
  assert.equal(world.box(ids[2])[1], Math.fround(0.1));
  // Rounded outward, so that no pair is lost, and bad boxes stay bad.
  world.boxes.set([1e-3, 0, 0, 1e-3, 1, 1, NaN, 0, 0, 1, 1, 1]);
  world.shiftOrigin([-1e6, 0, 0]);
  assert.ok(world.boxes[0] <= 1e6 + 1e-3 && world.boxes[3] >= 1e6 + 1e-3);
  assert.throws(() => world.step(), (error) => error.id === ids[1]);
});

test("what was written is in a snapshot, and is seen by queries once it is committed", async () => {
  const world = await createWorld({ objects: 3, events: true });
  const ids = world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 10, 0, 0, 11, 1, 1, 20, 0, 0, 21, 1, 1]));
  world.step();
  world.boxes.set([10.5, 0, 0, 11.5, 1, 1]);
  assert.deepEqual([...world.overlaps({ center: [10.5, 0.5, 0.5], radius: 0.1 })], [ids[1]]);
  const snapshot = world.save();
  assert.deepEqual([...world.overlaps({ center: [10.5, 0.5, 0.5], radius: 0.1 })], [ids[0], ids[1]]);
  world.boxes.set([90, 0, 0, 91, 1, 1]);
  world.load(snapshot);
  assert.equal(world.boxes[0], 10.5);
  assert.deepEqual([...world.step().found], [0, 1]);
  world.boxes[12] = 19;
  world.boxes[6] = NaN;
  assert.throws(() => world.commit(), (error) => error.id === ids[1] && error.count === 1 && /commit/.test(error.message));
  assert.equal(world.box(ids[2])[0], 19);
  assert.equal(world.box(ids[1])[0], 10);
  world.boxes[6] = 10;
  world.commit();
  assert.equal(world.stats().pairs, 1);
});

test("a world that is only asked needs no step and no room for pairs", async () => {
  const count = 2000;
  const world = await createWorld({ objects: count, pairs: 0 });
  const boxes = Float32Array.from({ length: 6 * count }, (_, at) => Math.floor(at / 6) * 0.5 + (at % 6 < 3 ? 0 : 1));
  const ids = world.insertMany(boxes);
  world.boxes.set([-9, -9, -9, -8, -8, -8], 6 * 7);
  world.refresh();
  assert.deepEqual([...world.overlaps({ min: [-9, -9, -9], max: [-8.5, -8.5, -8.5] })], [ids[7]]);
  assert.deepEqual([...world.overlaps({ min: [500, 500, 500], max: [500, 500, 500] })], [...ids.slice(998, 1001)]);
  world.boxes[0] = NaN;
  assert.throws(() => world.refresh(), (error) => error.id === ids[0] && /refresh/.test(error.message));
  assert.throws(() => world.step());
});

test("who falls asleep in the frame of a move sleeps where it moved to", async () => {
  const world = await createWorld({ objects: 2, events: true });
  const [, ball] = world.insertMany(new Float32Array([0, 0, 0, 9, 1, 9, 1, 3, 1, 2, 4, 2]));
  world.step();
  world.boxes.set([1, 1, 1, 2, 2, 2], 6);
  world.setResting([ball]);
  assert.deepEqual([...world.step().found], [0, 1]);
  assert.ok(world.isResting(ball));
  assert.deepEqual([...world.awakePairs()], [0, 1]);
  world.setResting([world.idAt(0)]);
  assert.equal(world.step().pairs.length, 2);
  assert.equal(world.awakePairs().length, 0);
  world.wake([ball]);
  assert.ok(!world.isResting(ball));
});

test("disabled objects are in no pair and in no answer", async () => {
  const world = await createWorld({ objects: 2, events: true });
  const [floor, ball] = world.insertMany(new Float32Array([0, 0, 0, 9, 1, 9, 1, 3, 1, 2, 4, 2]));
  world.boxes.set([1, 1, 1, 2, 2, 2], 6);
  world.setEnabled([floor], false);
  assert.equal(world.step().pairs.length, 0);
  assert.deepEqual([...world.overlaps({ min: [-9, -9, -9], max: [9, 9, 9] })], [ball]);
  assert.ok(!world.isEnabled(floor) && world.isEnabled(ball) && world.has(floor));
  world.setEnabled([floor]);
  assert.deepEqual([...world.step().found], [0, 1]);
});

test("what is written to the box of a disabled object waits, also where that was woken or got another one", async () => {
  for (const rouse of [() => {}, (world, id) => world.wake([id]), (world, id) => world.update(id, [2, 2, 2, 3, 3, 3])]) {
    const world = await createWorld({ objects: 8 });
    const id = world.insert([2, 2, 2, 3, 3, 3]);
    world.setEnabled([id], false);
    rouse(world, id);
    for (const call of ["save", "refresh", "step", "setResting", "setEnabled"]) {
      world.boxes.set([7, 7, 7, 8, 8, 8]);
      world[call]([id], false);
      assert.deepEqual([...world.box(id)], [2, 2, 2, 3, 3, 3], call);
      // Nor is it refused.
      world.boxes[0] = NaN;
      world[call]([id], false);
      rouse(world, id);
    }
    world.boxes.set([7, 7, 7, 8, 8, 8]);
    world.setEnabled([id]);
    world.refresh();
    assert.deepEqual([...world.box(id)], [7, 7, 7, 8, 8, 8]);
  }
});

test("queries among those for which a condition holds", async () => {
  const { world, boxes, ids } = await scene();
  const where = (id) => slotOf(id) % 3 !== 1;
  const region = { min: [2, 2, 2], max: [6, 7, 8] };
  assert.deepEqual(world.overlaps(region, where), world.overlaps(region).filter(where));
  const ray = { box: [-2, 4, 4, -1, 6, 6], direction: [1, 0.01, 0.02] };
  const all = world.hits(ray);
  assert.ok(all.length > 3 && all.every(({ distance }, i) => i === 0 || distance >= all[i - 1].distance));
  const met = Array.from(ids).filter((id) => world.hits({ ...ray, distance: 100 }).some((hit) => hit.id === id));
  assert.equal(met.length, all.length);
  assert.deepEqual(world.hits(ray, where), all.filter(({ id }) => where(id)));
  assert.deepEqual(world.firstHit(ray), all[0]);
  assert.deepEqual(world.firstHit(ray, (id) => id !== all[0].id && id !== all[1].id), all[2]);
  assert.equal(world.firstHit(ray, () => false), null);
  const near = world.nearest([5, 5, 5], 500).filter(({ id }) => where(id));
  assert.deepEqual(world.nearest([5, 5, 5], 7, where), near.slice(0, 7));
  assert.deepEqual(world.nearest([5, 5, 5], 500, where), near);
  assert.deepEqual(world.nearest([5, 5, 5], 0, where), []);
  assert.equal(boxes.length, 3000);
});

test("pairs by id, bulk calls, and a world that is cleared", async () => {
  const world = await createWorld({ objects: 300, pairs: 20000, events: true, filters: true, marginPerExtent: 0.1 });
  const boxes = scatter(300, random(8), 6);
  const ids = world.insertMany(boxes);
  assert.deepEqual(world.ids(), ids);
  const { pairs } = world.step();
  assert.deepEqual([...world.pairIds()], Array.from(pairs, (slot) => ids[slot]));
  assert.deepEqual(world.pairIds("found"), world.pairIds());
  // A removed object is in no pair any more, and a newcomer in its slot in none yet.
  const [gone] = pairs;
  world.remove(ids[gone]);
  const newcomer = world.insert([0, 0, 0, 1, 1, 1]);
  assert.equal(slotOf(newcomer), gone);
  const left = world.pairIds();
  assert.ok(left.length < 2 * pairs.length && !left.includes(newcomer) && !left.includes(ids[gone]));
  world.remove(newcomer);
  const living = world.ids();
  assert.equal(living.length, 299);
  const even = (id) => slotOf(id) % 2 === 0;
  world.setFilters(living, Array.from(living, (id) => (even(id) ? { group: 1, mask: 1 } : { group: 2, mask: 2 })));
  const meet = (a, b) => a % 2 === b % 2;
  assert.deepEqual(texts(world.step().pairs), bruteForce(boxes, (slot) => slot !== gone, meet));
  assert.ok(Array.from(world.pairIds("lost")).includes(ids[gone]));
  world.setFilters(living, { group: 1 });
  const moved = scatter(299, random(9), 6);
  world.updateMany(living, moved);
  world.setMargin(living[0], 0.5);
  const at = (slot) => Array.from(living).findIndex((id) => slotOf(id) === slot);
  const now = Float32Array.from({ length: 1800 }, (_, i) => moved[6 * at(Math.floor(i / 6)) + (i % 6)] ?? NaN);
  assert.deepEqual(texts(world.step().pairs), bruteForce(now, (slot) => slot !== gone));
  assert.throws(() => world.updateMany(living, moved.subarray(6)), InvalidArgumentError);
  world.clear();
  assert.equal(world.size, 0);
  assert.equal(world.ids().length, 0);
  assert.ok(world.step().lost.length > 0 && world.pairs.length === 0);
});
