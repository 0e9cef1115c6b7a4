// The types as a program uses them. `tsc -p test` checks this file; nothing runs it.

import { BadBoxError, createWorld, createWorlds, hasVectors, idOf, idText, pairs as pairsOf, slotOf, StaleIdError, TrisapError, World } from "trisap";
declare const console: { log(...what: unknown[]): void };
import type { Config, Filter, Hit, Id, Region, Stats } from "trisap";

const config: Config = { objects: 100, events: true, values: true, mode: "exact" };
const world: World = await createWorld(config, { simd: hasVectors(), wasm: Promise.resolve(new Uint8Array(8)) });
const rooms: World[] = await createWorlds(3, config);
const id: Id = world.insert([0, 0, 0, 1, 1, 1]);
const ids: BigUint64Array = world.insertMany(new Float32Array(12));
world.boxes[6 * slotOf(id)] = 2;
const { pairs, found, lost }: { pairs: Uint32Array; found: Uint32Array; lost: Uint32Array } = world.step();
const regions: Region[] = [{ min: [0, 0, 0], max: [1, 1, 1] }, { center: [0, 0, 0], radius: 1 }];
const hit: Hit | null = world.firstHit({ origin: [0, 0, 0], direction: [1, 0, 0] });
world.visitNearest([0, 0, 0], (near: Hit) => near.distance, 10);
world.visitNearest([0, 0, 0], (near) => console.log(near.id));
const once: Uint32Array = await pairsOf([0, 0, 0, 1, 1, 1], { between: new Float32Array(6), simd: false });
const near: [Hit[][], BigUint64Array] = [world.nearestMany(new Float32Array(6), 2), world.within([1, 0, 0, 5], () => once.length > 0)];
const others = (one: Id) => one !== id;
const all: Hit[] = world.hits({ box: [0, 0, 0, 1, 1, 1], direction: [1, 0, 0] }, others);
const some: [BigUint64Array, Hit | null, Hit[]] = [
  world.overlaps(regions[0], others), world.firstHit({ origin: [0, 0, 0], direction: [1, 0, 0] }, others), world.nearest([0, 0, 0], 2, others),
];
const by: [BigUint64Array, Uint32Array, boolean, Id] = [world.pairIds("lost"), world.awakePairs(), world.isResting(id), idOf(idText(id))];
world.setFilters(ids, [{ group: 1 }, {}]);
world.setFilters(world.ids(), { mask: 1 });
world.updateMany(ids, world.boxes.subarray(0, 12));
world.commit();
world.clear();
const filter: Filter = { group: 1 };
const stats: Stats = world.stats();
world.setValue(id, 7n);
world.setValues(ids, [1n, 2n]);
const values: BigUint64Array = world.values(world.overlaps(regions[0]));
const gone: [bigint, BigUint64Array] = [world.value(id), world.pairValues("lost")];
try {
  world.update(id, new Float64Array(6));
} catch (error) {
  if (error instanceof StaleIdError || error instanceof BadBoxError) {
    const slot: number | null = error.slot;
    console.log(slot);
  } else if (error instanceof TrisapError) {
    console.log(error.message);
  }
}
console.log(ids, pairs, found, lost, regions.map((region) => world.overlaps(region)), hit, filter, stats.path, values, gone, all, some, by);

// @ts-expect-error: no such field
await createWorld({ objects: 1, event: true });
// @ts-expect-error: made by createWorld alone
new World();
// @ts-expect-error: an id is a bigint
world.remove(1);
// @ts-expect-error: and so is a value
world.setValue(id, 1);
// @ts-expect-error: a view can be written to, not replaced
world.boxes = new Float32Array(6);
