// Each pair has a number from found to lost, also after going back.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Contacts, createWorld, slotOf } from "trisap";
import { move, random, scatter } from "./brute.js";

const key = (a, b) => `${Math.min(a, b)} ${Math.max(a, b)}`;

/** Tells contacts and a map of a step, and compares them. */
function follow(contacts, model, world) {
  const { lost, found, pairs } = world.step();
  const { ended, began } = contacts.update(world);
  assert.equal(ended.length, lost.length / 2);
  ended.forEach((contact, i) => {
    assert.equal(model.get(key(lost[2 * i], lost[2 * i + 1])), contact);
    model.delete(key(lost[2 * i], lost[2 * i + 1]));
  });
  began.forEach((contact, i) => model.set(key(found[2 * i], found[2 * i + 1]), contact));
  assert.deepEqual([contacts.size, model.size, new Set(model.values()).size], Array(3).fill(pairs.length / 2));
  for (let i = 0; i < pairs.length; i += 2) {
    assert.equal(contacts.get(pairs[i + 1], pairs[i]), model.get(key(pairs[i], pairs[i + 1])));
    assert.notEqual(contacts.get(pairs[i], pairs[i + 1]), undefined);
  }
  for (const slot of new Set(pairs)) {
    for (const [contact, partner] of contacts.of(slot)) {
      assert.equal(model.get(key(slot, partner)), contact);
    }
  }
}

test("numbers stay with their pairs", async () => {
  const next = random(11);
  const world = await createWorld({ objects: 300, events: true, pairs: 20000 });
  const contacts = new Contacts();
  const model = new Map();
  const living = [...world.insertMany(scatter(200, next, 6))];
  let most = 0;
  let kept = null;
  for (let step = 0; step < 40; step++) {
    for (let i = 0; i < 5; i++) {
      world.remove(living.splice(Math.floor(next() * living.length), 1)[0]);
    }
    living.push(...world.insertMany(scatter(5, next, 6)));
    move(world.boxes, next, 0.3);
    follow(contacts, model, world);
    most = Math.max(most, contacts.size);
    if (step === 20) {
      kept = [world.copy(), contacts.copy(), new Map(model)];
    }
  }
  assert.ok(most > 100 && [...model.values()].every((contact) => contact < most));
  const slot = slotOf(living[0]);
  const of = [...contacts.of(slot)].length;
  contacts.removeAll(slot);
  assert.deepEqual([contacts.size, [...contacts.of(slot)]], [model.size - of, []]);
  world.restore(kept[0]);
  contacts.restore(kept[1]);
  follow(contacts, kept[2], world);
  assert.equal(contacts.get(0, 100000), undefined);
  assert.throws(() => contacts.update({ lost: [], found: [1, 1] }), { field: "found" });
});
