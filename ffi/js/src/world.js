// A world: objects with boxes, and the pairs of those that overlap.

import { BOX, Calls, STATUS } from "./calls.js";
import { objectsOf, readStats } from "./config.js";
import * as errors from "./errors.js";
import { checkId, slotOf } from "./id.js";

const BOX_BYTES = 4 * BOX;
const FILTER_BYTES = 12;
const HIT_BYTES = 16;
const PAIR_BYTES = 16;
const CLASSES = 32;
/** Growth ends with room for so many objects at least. */
const FIRST = 64;

// Fields of `trisap_result` on a machine with pointers of four bytes.
const RESULT_REJECTED = 4;
const RESULT_FIRST_REJECTED = 8;
const RESULT_PAIRS = 16;
const RESULT_FOUND = 24;
const RESULT_LOST = 32;

/** The nearest objects that a visit asks for first, and how many times as many it asks for each further time. */
const FEW = 8;
const MORE = 8;

/** What `trisap_world_pair_ids` and `trisap_world_pair_values` are asked for. */
const PAIRS = { pairs: 0, found: 1, lost: 2 };
const NONE = new Uint32Array(0);

/** A copy of a world: its boxes, and behind them, from `world` on, its memory. */
export class WorldCopy {
  constructor(bytes) {
    this.bytes = bytes;
  }

  get byteLength() {
    return this.bytes.length;
  }
}

export class World {
  #calls;
  /** The functions of the module, and where the world is. */
  #module;
  /** No living object has a slot from this one on. */
  #slots = 0;
  #boxes = null;
  /** Views of the arrays of the last step, by where it tells of them. */
  #results = new Map();

  /** Through `createWorld`: `from` which place on the memory of the instance is free, the bottom if not given. */
  constructor(instance, config, variant, from) {
    this.#calls = new Calls(instance, config, from);
    this.#module = this.#calls.calls;
    this.variant = variant;
    this.instructionSet = this.#calls.memory.text(this.#module.trisap_instruction_set());
  }

  /** So many worlds in an instance of their own, whose memory is given back with them. */
  static async instantiate({ module, variant }, config, count = 1) {
    objectsOf(config);
    if (!Number.isInteger(count) || count < 0) {
      throw new errors.InvalidArgumentError("count", `is a whole number, not ${count}`);
    }
    if (count > 1 && config.grows) {
      throw new errors.InvalidArgumentError("grows", "is for a world that has its memory for itself: it would take the views of the others away");
    }
    const instance = await WebAssembly.instantiate(module, {});
    const worlds = [];
    for (let from; worlds.length < count; from = worlds.at(-1).#calls.memory.end) {
      worlds.push(new World(instance, config, variant, from));
    }
    return worlds;
  }

  get config() {
    return this.#calls.capacity;
  }

  get boxes() {
    const { memory, capacity } = this.#calls;
    return (this.#boxes ??= new Float32Array(memory.buffer, memory.boxes, BOX * capacity.objects));
  }

  get size() {
    return this.#module.trisap_world_len(this.#world);
  }

  isCoarse() {
    return this.#module.trisap_world_is_coarse(this.#world) === 1;
  }

  get memoryBytes() {
    return this.#calls.memory.bytes;
  }

  get pairs() {
    return this.#result(RESULT_PAIRS);
  }

  get found() {
    return this.#result(RESULT_FOUND);
  }

  get lost() {
    return this.#result(RESULT_LOST);
  }

  insert(box) {
    const insert = this.#module.trisap_world_insert;
    return this.#insert(box, "insert", (at, out) => insert(this.#world, at, out));
  }

  insertAt(slot, box) {
    if (slot >>> 0 !== slot) {
      throw new errors.InvalidArgumentError("slot", "must be a whole number from 0 on");
    }
    const insert = this.#module.trisap_world_insert_at;
    return this.#insert(box, "insertAt", (at, out) => insert(this.#world, slot, at, out));
  }

  #insert(box, place, ask) {
    const calls = this.#calls;
    // A view of the memory is of no use any more once it has grown.
    const own = box?.buffer === calls.memory.buffer ? box.slice() : box;
    calls.check(this.#fitting(() => ask(calls.box(own, place), calls.out)), place);
    const id = calls.id(calls.out);
    this.#keep(id, own, 0);
    return id;
  }

  insertMany(boxes) {
    const count = this.#count(boxes);
    const calls = this.#calls;
    const needed = this.size + count;
    if (needed > this.config.objects) {
      if (!this.config.grows) {
        throw new errors.ObjectsFullError(needed, this.config.objects);
      }
      // A view of the old memory is of no use any more afterwards.
      boxes = boxes.buffer === calls.memory.buffer ? boxes.slice() : boxes;
      this.#grow(Math.max(needed, 2 * this.config.objects), 0);
    }
    const [ids, at] = this.#beside(boxes, count);
    calls.check(this.#module.trisap_world_insert_many(this.#world, calls.boxes(at, count), ids), "insertMany");
    return this.#kept(ids, at, count);
  }

  update(id, box) {
    checkId(id);
    const calls = this.#calls;
    calls.check(this.#module.trisap_world_update(this.#world, id, calls.box(box, `update of object ${id}`)), "update", id);
    this.#keep(id, box, 0);
  }

  updateMany(ids, boxes) {
    const count = this.#count(boxes);
    if (ids.length !== count) {
      throw new errors.InvalidArgumentError("boxes", "are as many as ids");
    }
    Array.prototype.forEach.call(ids, checkId);
    const calls = this.#calls;
    const [first, at] = this.#beside(boxes, count);
    calls.array(BigUint64Array, first, count).set(ids);
    calls.check(this.#module.trisap_world_update_many(this.#world, first, calls.boxes(at, count)), "updateMany");
    this.#kept(first, at, count);
  }

  remove(id) {
    this.#calls.check(this.#module.trisap_world_remove_many(this.#world, this.#calls.one(id), 1), "remove", id);
  }

  removeMany(ids) {
    if (ids.length > this.config.objects) {
      // More than there is room for, so that one is stale or comes twice.
      this.#check(ids);
      const seen = new Set();
      const again = (id) => seen.has(id) || !seen.add(id);
      throw new errors.StaleIdError(Array.prototype.find.call(ids, again));
    }
    this.#calls.check(this.#module.trisap_world_remove_many(this.#world, this.#calls.ids(ids), ids.length), "removeMany");
  }

  clear() {
    this.removeMany(this.ids());
  }

  has(id) {
    return this.#module.trisap_world_contains(this.#world, checkId(id)) === STATUS.OK;
  }

  idAt(slot) {
    if (slot >>> 0 !== slot) {
      return null;
    }
    const id = BigInt.asUintN(64, this.#module.trisap_world_id_at(this.#world, slot));
    return id === 0n ? null : id;
  }

  ids() {
    const ids = new BigUint64Array(this.size);
    let count = 0;
    for (let slot = 0; count < ids.length; slot++) {
      const id = this.#module.trisap_world_id_at(this.#world, slot);
      if (id !== 0n) {
        ids[count++] = id;
      }
    }
    return ids;
  }

  box(id) {
    const calls = this.#calls;
    calls.check(this.#module.trisap_world_aabb(this.#world, checkId(id), calls.answer), "box", id);
    return calls.array(Float32Array, calls.answer, BOX).slice();
  }

  commit() {
    this.#refresh("commit");
  }

  refresh() {
    this.#refresh("refresh");
  }

  #refresh(place) {
    const refused = this.#commit();
    // Only queries need the tree, and the module with pairs alone has none.
    if ("trisap_world_refresh" in this.#module) {
      this.#calls.check(this.#module.trisap_world_refresh(this.#world, 0), place);
    }
    this.#refuse(refused, place);
  }

  step() {
    const calls = this.#calls;
    this.#results.clear();
    const ask = () => {
      const boxes = calls.boxes(calls.memory.boxes, this.#slots);
      return this.#module.trisap_world_step_over(this.#world, boxes, 0, calls.result);
    };
    calls.check(this.#fitting(ask), "step");
    const count = calls.word(calls.result + RESULT_REJECTED);
    this.#refuse({ count, id: count === 0 ? null : calls.id(calls.result + RESULT_FIRST_REJECTED) }, "step");
    return this;
  }

  stats() {
    const calls = this.#calls;
    calls.check(this.#module.trisap_world_stats(this.#world, calls.stats), "stats");
    return readStats(calls.memory.view, calls.stats);
  }

  setFilter(id, filter = {}) {
    const calls = this.#calls;
    calls.filter(calls.argument, filter);
    const status = this.#module.trisap_world_set_filter_many(this.#world, calls.one(id), calls.argument, 0, 1);
    calls.check(status, "setFilter", id);
  }

  setFilters(ids, filters) {
    const calls = this.#calls;
    const each = Array.isArray(filters);
    if (each && filters.length !== ids.length) {
      throw new errors.InvalidArgumentError("filters", "are as many as ids, or one for all");
    }
    const [last, own] = this.#last(ids, each ? filters : []);
    const at = calls.ids(last);
    const [first, stride] = [at + 8 * last.length, each ? FILTER_BYTES : 0];
    (each ? own : [filters]).forEach((filter, i) => calls.filter(first + FILTER_BYTES * i, filter));
    calls.check(this.#module.trisap_world_set_filter_many(this.#world, at, first, stride, last.length), "setFilters");
  }

  setClasses(meets) {
    if (meets.length !== CLASSES) {
      throw new errors.InvalidArgumentError("meets", "has 32 numbers");
    }
    const calls = this.#calls;
    calls.array(Uint32Array, calls.argument, CLASSES).set(meets);
    calls.check(this.#module.trisap_world_set_classes(this.#world, calls.argument), "setClasses");
  }

  setMargin(id, length) {
    this.#calls.check(this.#module.trisap_world_set_margin(this.#world, checkId(id), length), "setMargin", id);
  }

  setValue(id, value) {
    const calls = this.#calls;
    const at = calls.one(id);
    calls.memory.view.setBigUint64(calls.argument, value, true);
    calls.check(this.#module.trisap_world_set_value_many(this.#world, at, calls.argument, 8, 1), "setValue", id);
  }

  setValues(ids, values) {
    if (ids.length !== values.length) {
      throw new errors.InvalidArgumentError("values", "are as many as ids");
    }
    const calls = this.#calls;
    const [last, own] = this.#last(ids, values);
    const at = calls.ids(last);
    const first = at + 8 * last.length;
    calls.array(BigUint64Array, first, last.length).set(own);
    calls.check(this.#module.trisap_world_set_value_many(this.#world, at, first, 8, last.length), "setValues");
  }

  value(id) {
    const calls = this.#calls;
    calls.check(this.#module.trisap_world_values(this.#world, calls.one(id), 8, 1, calls.out), "value", id);
    return calls.id(calls.out);
  }

  values(ids) {
    const calls = this.#calls;
    const values = new BigUint64Array(ids.length);
    // An object may come any number of times: so many at once as there is room for.
    const most = Math.max(this.config.objects, 1);
    const all = ids instanceof BigUint64Array ? ids : BigUint64Array.from(ids, checkId);
    for (let from = 0; from < all.length; from += most) {
      const some = all.subarray(from, from + most);
      const at = calls.ids(some);
      calls.check(this.#module.trisap_world_values(this.#world, at, 8, some.length, at), "values");
      values.set(calls.array(BigUint64Array, at, some.length), from);
    }
    return values;
  }

  pairIds(of = "pairs") {
    return this.#pairsBy("trisap_world_pair_ids", "pairIds", of);
  }

  pairValues(of = "pairs") {
    return this.#pairsBy("trisap_world_pair_values", "pairValues", of);
  }

  setResting(ids) {
    // Steps do not read the box of an object that rests: what was written to it before would be lost.
    const [last] = this.#last(ids);
    this.#commitOf(last);
    this.#calls.check(this.#module.trisap_world_set_resting(this.#world, this.#calls.ids(last), last.length), "setResting");
  }

  wake(ids) {
    const [last] = this.#last(ids);
    this.#calls.check(this.#module.trisap_world_wake(this.#world, this.#calls.ids(last), last.length), "wake");
  }

  setEnabled(ids, enabled = true) {
    // Steps do not read the box of a disabled object: what was written to it before would be lost.
    const [last] = this.#last(ids);
    this.#commitOf(last);
    const at = this.#calls.ids(last);
    this.#calls.check(this.#module.trisap_world_set_enabled(this.#world, at, last.length, enabled ? 1 : 0), "setEnabled");
  }

  isEnabled(id) {
    return this.#module.trisap_world_is_enabled(this.#world, checkId(id)) === 1;
  }

  isResting(id) {
    return this.#module.trisap_world_is_resting(this.#world, checkId(id)) === 1;
  }

  awakePairs() {
    const calls = this.#calls;
    const [at, count] = calls.answers("awakePairs", this.config.pairs, PAIR_BYTES / 2, (at, room) =>
      this.#module.trisap_world_awake_pairs(this.#world, at, room, calls.out));
    return calls.array(Uint32Array, at, 2 * count).slice();
  }

  overlaps(region, where) {
    const calls = this.#calls;
    const [at, count] = calls.answers("overlaps", this.size, 8, (at, room) =>
      this.#module.trisap_world_overlaps(this.#world, calls.region(region), 0, 0, at, room, calls.out));
    const ids = calls.array(BigUint64Array, at, count).slice();
    return where === undefined ? ids : ids.filter((id) => where(id));
  }

  firstHit(ray, where) {
    const calls = this.#calls;
    const at = calls.ray(ray);
    calls.check(this.#module.trisap_world_first_hit(this.#world, at, 0, 0, calls.answer), "firstHit");
    const hit = calls.hit(calls.answer);
    if (hit.id === 0n) {
      return null;
    }
    return where === undefined || where(hit.id) ? hit : (this.hits(ray).find(({ id }) => id !== hit.id && where(id)) ?? null);
  }

  hits(ray, where) {
    const calls = this.#calls;
    const [at, count] = calls.answers("hits", this.size, HIT_BYTES, (at, room) =>
      this.#module.trisap_world_hits(this.#world, calls.ray(ray), 0, 0, at, room, calls.out));
    const hits = Array.from({ length: count }, (_, i) => calls.hit(at + HIT_BYTES * i));
    return where === undefined ? hits : hits.filter(({ id }) => where(id));
  }

  nearest(position, count, where) {
    if (!Number.isInteger(count) || count < 0) {
      throw new errors.InvalidArgumentError("count", `is a whole number, not ${count}`);
    }
    if (where === undefined) {
      return this.#nearest(position, count, 0, "nearest");
    }
    const hits = [];
    this.visitNearest(position, (hit) => {
      if (hits.length < count && where(hit.id)) {
        hits.push(hit);
      }
      return hits.length < count ? Infinity : -1;
    });
    return hits;
  }

  nearestMany(points, count) {
    if (points.length % 3 !== 0 || !Number.isInteger(count) || count < 0) {
      throw new errors.InvalidArgumentError("points", "have three numbers each, and count is a whole number");
    }
    const { memory } = this.#calls;
    const all = points.length / 3;
    const numbers = ArrayBuffer.isView(points) ? points : Float32Array.from(points);
    const answers = [];
    // There are no more.
    count = Math.min(count, this.size);
    // As many at once as there is room for.
    const most = Math.max(1, Math.floor(memory.roomBytes / (16 + HIT_BYTES * count)));
    for (let from = 0; from < all; from += most) {
      const some = Math.min(most, all - from);
      const hits = this.#calls.room(HIT_BYTES * count * some + 12 * some, "points");
      const at = hits + HIT_BYTES * count * some;
      this.#calls.array(Float32Array, at, 3 * some).set(numbers.subarray(3 * from, 3 * (from + some)));
      const status = this.#module.trisap_world_nearest_many(this.#world, at, 12, some, 0, 0, 0, hits, count);
      this.#calls.check(status, "nearestMany");
      for (let i = 0; i < some; i++) {
        const near = Array.from({ length: count }, (_, k) => this.#calls.hit(hits + HIT_BYTES * (count * i + k)));
        answers.push(near.filter(({ id }) => id !== 0n));
      }
    }
    return answers;
  }

  within(planes, where) {
    if (planes.length % 4 !== 0) {
      throw new errors.InvalidArgumentError("planes", "have four numbers each");
    }
    const calls = this.#calls;
    const bytes = 8 * planes.length;
    const at = calls.room(bytes + 8 * this.size, "within");
    calls.array(Float64Array, at, planes.length).set(planes);
    const [ids, room] = [at + bytes, this.size];
    calls.check(this.#module.trisap_world_within(this.#world, at, planes.length / 4, 0, 0, ids, room, calls.out), "within");
    const found = calls.array(BigUint64Array, ids, calls.word(calls.out)).slice();
    return where === undefined ? found : found.filter((id) => where(id));
  }

  visitNearest(position, visit, distance = Infinity) {
    if (typeof distance !== "number" || !(distance >= 0)) {
      throw new errors.BadQueryError(`visitNearest: the distance is zero or more, not ${distance}`);
    }
    // A module imports nothing, so it cannot call back: more and more of the nearest objects, of which the first are known.
    for (let [seen, count] = [0, FEW]; ; [seen, count] = [count, MORE * count]) {
      const hits = this.#nearest(position, count, seen, "visitNearest");
      for (const hit of hits) {
        if (hit.distance > distance) {
          return;
        }
        const far = visit(hit);
        distance = far < distance ? far : distance;
      }
      if (hits.length < count - seen) {
        return;
      }
    }
  }

  shiftOrigin(by) {
    if (by?.length !== 3) {
      throw new errors.InvalidArgumentError("by", "has three numbers");
    }
    const calls = this.#calls;
    const written = this.#written().map((slot) => [slot, this.boxes.slice(BOX * slot, BOX * (slot + 1))]);
    const point = calls.array(Float64Array, calls.argument, 3);
    point.set(by);
    calls.check(this.#module.trisap_world_shift_origin(this.#world, calls.argument, calls.out), "shiftOrigin");
    const rounded = calls.word(calls.out);
    this.#reread();
    // What was written since the last step is shifted, too, rounded as the world rounds.
    const corners = calls.array(Float64Array, calls.argument + 24, BOX);
    for (const [slot, box] of written) {
      corners.set(box);
      this.#module.trisap_aabb_from_f64(calls.answer, calls.argument + 24, calls.argument + 48, calls.argument);
      this.boxes.set(calls.array(Float32Array, calls.answer, BOX), BOX * slot);
    }
    return rounded;
  }

  save() {
    const calls = this.#calls;
    this.#commit();
    const size = this.#module.trisap_world_snapshot_size(this.#world) >>> 0;
    const [at, bytes] = calls.answers("save", size, 1, (at, room) =>
      this.#module.trisap_world_save(this.#world, at, room, calls.out));
    return calls.array(Uint8Array, at, bytes).slice();
  }

  load(snapshot) {
    const calls = this.#calls;
    const ask = () => {
      if (snapshot.length > calls.memory.roomBytes) {
        if (!this.config.grows) {
          throw new errors.BadSnapshotError("load: the snapshot is of a larger world");
        }
        calls.memory.widen(snapshot.length);
        this.#anew();
      }
      calls.array(Uint8Array, calls.memory.room, snapshot.length).set(snapshot);
      return this.#module.trisap_world_load(this.#world, calls.memory.room, snapshot.length);
    };
    calls.check(this.#fitting(ask), "load");
    this.#results.clear();
    calls.check(this.#module.trisap_world_result(this.#world, calls.result), "load");
    this.#slots = this.config.objects;
    this.#reread();
  }

  copy(into) {
    const calls = this.#calls;
    const { memory, capacity } = calls;
    const [world, worldBytes] = [BOX_BYTES * capacity.objects, this.#module.trisap_world_bytes(this.#world)];
    const fits = into instanceof WorldCopy && into.bytes.length === world + worldBytes;
    const copy = fits ? into : new WorldCopy(new Uint8Array(world + worldBytes));
    copy.bytes.set(calls.array(Uint8Array, memory.boxes, world));
    copy.bytes.set(calls.array(Uint8Array, memory.world, worldBytes), world);
    return Object.assign(copy, { calls, world, capacity, place: memory.place, slots: this.#slots });
  }

  restore(copy) {
    const calls = this.#calls;
    if (!(copy instanceof WorldCopy) || copy.calls !== calls) {
      throw new errors.InvalidArgumentError("copy", "is a copy of this world");
    }
    calls.restore(copy);
    this.#anew();
    this.#slots = copy.slots;
  }

  sortResults() {
    const calls = this.#calls;
    calls.check(this.#module.trisap_world_sort_results(this.#world, calls.result), "sortResults");
    this.#results.clear();
    return this;
  }

  get #world() {
    return this.#calls.world;
  }

  #result(field) {
    const calls = this.#calls;
    const known = this.#results.get(field);
    if (known !== undefined) {
      return known;
    }
    const at = calls.result + field;
    const count = calls.word(at + 4);
    const pairs = count === 0 ? NONE : calls.array(Uint32Array, calls.word(at), 2 * count);
    this.#results.set(field, pairs);
    return pairs;
  }

  /** Asks, and in a world that grows once more after each growth where something did not fit. */
  #fitting(ask) {
    let status = ask();
    while (this.config.grows && (status === STATUS.OBJECTS_FULL || status === STATUS.PAIRS_FULL)) {
      const needed = Number(this.#module.trisap_world_error_detail(this.#world));
      if (status === STATUS.OBJECTS_FULL) {
        this.#grow(Math.max(FIRST, needed, 2 * this.config.objects), 0);
      } else {
        // A quarter more, so that a growing scene does not move in each step.
        this.#grow(0, Math.min(needed + Math.ceil(needed / 4), 0xffff_ffff));
      }
      status = ask();
    }
    return status;
  }

  #grow(objects, pairs) {
    this.#calls.grow(objects, pairs);
    this.#anew();
  }

  /** After the world has moved, or the memory has grown, which takes views away. */
  #anew() {
    this.#boxes = null;
    this.#results.clear();
  }

  /** How many boxes there are in an argument. */
  #count(boxes) {
    if (!(boxes instanceof Float32Array) || boxes.length % BOX !== 0) {
      throw new errors.InvalidArgumentError("boxes", "is a Float32Array of six numbers a box");
    }
    return boxes.length / BOX;
  }

  /** Writes boxes for a call, with room for as many ids before them: where both begin. */
  #beside(boxes, count) {
    const ids = this.#calls.room((8 + BOX_BYTES) * count, "boxes");
    this.#calls.array(Float32Array, ids + 8 * count, BOX * count).set(boxes);
    return [ids, ids + 8 * count];
  }

  /** Writes boxes that a call has taken to where steps read them. A copy of the ids. */
  #kept(ids, at, count) {
    const answer = this.#calls.array(BigUint64Array, ids, count).slice();
    const boxes = this.#calls.array(Float32Array, at, BOX * count);
    answer.forEach((id, i) => this.#keep(id, boxes, BOX * i));
    return answer;
  }

  /** Writes an object's box, `from` which place on, to where steps read it. */
  #keep(id, box, from) {
    const slot = slotOf(id);
    const { boxes } = this;
    for (let i = 0; i < BOX; i++) {
      boxes[BOX * slot + i] = box[from + i];
    }
    this.#slots = Math.max(this.#slots, slot + 1);
  }

  /**
   * Ids for a call that takes an object any number of times, and what it gives them. Of more than there can be each object once, as
   * it comes last: for those there is room.
   */
  #last(ids, given = []) {
    if (ids.length <= this.config.objects) {
      return [ids, given];
    }
    this.#check(ids);
    const last = new Map(Array.from(ids, (id, i) => [id, given[i]]));
    return [[...last.keys()], [...last.values()]];
  }

  /** Refuses ids of which one names no living object. */
  #check(ids) {
    const stale = Array.prototype.find.call(ids, (id) => !this.has(id));
    if (stale !== undefined) {
      throw new errors.StaleIdError(stale);
    }
  }

  /** Has the boxes that steps read say what the world says. */
  #reread() {
    const { boxes } = this.#calls.memory;
    for (let slot = 0; slot < this.#slots; slot++) {
      const id = this.#module.trisap_world_id_at(this.#world, slot);
      if (id !== 0n) {
        this.#calls.check(this.#module.trisap_world_aabb(this.#world, id, boxes + BOX_BYTES * slot), "box", id);
      }
    }
  }

  /** Those of some slots whose box in `boxes` is not that of the world, in order. */
  #written(slots) {
    const [calls, { boxes }] = [this.#calls, this];
    const known = calls.array(Float32Array, calls.answer, BOX);
    const differs = (slot) => {
      const id = slot < this.#slots ? this.#module.trisap_world_id_at(this.#world, slot) : 0n;
      if (id === 0n || this.#module.trisap_world_aabb(this.#world, id, calls.answer) !== STATUS.OK) {
        return false;
      }
      const at = BOX * slot;
      return known.some((bound, i) => bound !== boxes[at + i]);
    };
    return (slots ?? Array.from({ length: this.#slots }, (_, slot) => slot)).filter(differs);
  }

  /** Takes in the boxes of some objects before a call that is not refused. */
  #commitOf(ids) {
    this.#check(ids);
    this.#commit(Array.prototype.map.call(ids, slotOf));
  }

  /** Takes in the boxes of some slots, or of all, as a step would; which it refuses. */
  #commit(slots) {
    const [calls, { boxes }] = [this.#calls, this];
    const refused = { count: 0, id: null };
    for (const slot of this.#written(slots)) {
      const id = BigInt.asUintN(64, this.#module.trisap_world_id_at(this.#world, slot));
      // One that is disabled may not rest. The module with pairs alone disables none.
      if (this.isResting(id) || ("trisap_world_is_enabled" in this.#module && !this.isEnabled(id))) {
        continue;
      }
      const status = this.#module.trisap_world_update(this.#world, id, calls.box(boxes.subarray(BOX * slot, BOX * (slot + 1)), "box"));
      if (status === STATUS.BAD_BOX) {
        refused.id ??= id;
        refused.count++;
      } else {
        calls.check(status, "commit", id);
      }
    }
    return refused;
  }

  #refuse({ count, id }, place) {
    if (count > 0) {
      const which = `${place}: object ${id} in slot ${slotOf(id)}, the first of ${count}`;
      throw new errors.BadBoxError(which, { id, count });
    }
  }

  #pairsBy(call, place, of) {
    if (!Object.hasOwn(PAIRS, of)) {
      throw new errors.InvalidArgumentError("of", `is one of ${Object.keys(PAIRS).join(", ")}, not ${of}`);
    }
    const calls = this.#calls;
    const [at, count] = calls.answers(place, this[of].length / 2, PAIR_BYTES, (at, room) =>
      this.#module[call](this.#world, PAIRS[of], at, room, calls.out));
    return calls.array(BigUint64Array, at, 2 * count).slice();
  }

  /** The nearest objects but for the first ones. */
  #nearest(position, count, skipped, place) {
    const calls = this.#calls;
    calls.point(calls.argument, position);
    const [at, told] = calls.answers(place, Math.min(count, this.size), HIT_BYTES, (at, room) =>
      this.#module.trisap_world_nearest(this.#world, calls.argument, 0, 0, at, room, calls.out));
    return Array.from({ length: Math.max(told - skipped, 0) }, (_, i) => calls.hit(at + HIT_BYTES * (skipped + i)));
  }
}
