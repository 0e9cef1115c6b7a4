// A world: objects with boxes, and the pairs of those that overlap.

import { objectsOf, readConfig, readStats, writeConfig } from "./config.js";
import * as errors from "./errors.js";
import { slotOf } from "./id.js";
import { Memory } from "./memory.js";

/** Numbers of `trisap_status`. */
const STATUS = {
  OK: 0, CORRUPT: 15, OBJECTS_FULL: 11, BAD_BOX: 12, STALE_ID: 13, PAIRS_FULL: 14, NO_FILTERS: 16, BAD_CLASS: 17,
  BAD_QUERY: 18, OUTPUT_FULL: 19, BAD_SNAPSHOT: 20, NO_VALUES: 24,
};
/** Floats of a box. */
const BOX = 6;
const BOX_BYTES = 24;

// Where the structs of a call stand, from the start of their part of memory on.
const CONFIG = 0;
const BOXES = 128;
const RESULT = 192;
const ARGUMENT = 256;
const ANSWER = 384;
const STATS = 512;
const OUT = 640;

// Fields of `trisap_boxes` and `trisap_result` on a machine with pointers of four bytes.
const BOXES_FIRST = 8;
const BOXES_COUNT = 16;
const RESULT_REJECTED = 4;
const RESULT_FIRST_REJECTED = 8;
const RESULT_PAIRS = 16;
const RESULT_FOUND = 24;
const RESULT_LOST = 32;

/** The nearest objects that a visit asks for first, and how many times as many it asks for each further time. */
const FEW = 8;
const MORE = 8;

/** What `trisap_world_pair_values` is asked for. */
const PAIRS = { pairs: 0, found: 1, lost: 2 };

const KIND_AABB = 0;
const KIND_SPHERE = 1;
const NONE = new Uint32Array(0);

export class World {
  #memory;
  #world;
  #objects;
  /** No living object has a slot from this one on. */
  #slots = 0;
  #boxes = null;
  /** Views of the arrays of the last step, by where it tells of them. */
  #results = new Map();

  /** Through `createWorld`: the instance is a fresh one. */
  constructor(instance, config, variant) {
    const objects = objectsOf(config);
    const memory = new Memory(instance);
    const { calls, structs } = memory;
    this.#memory = memory;
    calls.trisap_default_config(structs + CONFIG, objects);
    writeConfig(memory.view, structs + CONFIG, config);
    const bytes = calls.trisap_world_size(structs + CONFIG) >>> 0;
    // Where there can be no such world, the call below says why.
    memory.lay(bytes === 0 ? 0 : objects, bytes);
    this.#check(calls.trisap_world_init(memory.world, bytes, structs + CONFIG, structs + OUT), "config");
    this.#world = memory.world;
    this.#objects = objects;
    calls.trisap_default_boxes(structs + BOXES, memory.boxes, 0);
    calls.trisap_default_result(structs + RESULT);
    calls.trisap_default_stats(structs + STATS);
    this.#check(calls.trisap_world_result(this.#world, structs + RESULT), "config");
    this.config = readConfig(memory.view, structs + CONFIG);
    this.variant = variant;
    this.instructionSet = memory.text(calls.trisap_instruction_set());
  }

  /** An instance of its own for each world: its memory is given back with it, and no other world's growth moves its views. */
  static async instantiate({ module, variant }, config) {
    objectsOf(config);
    return new World(await WebAssembly.instantiate(module, {}), config, variant);
  }

  get boxes() {
    if (this.#boxes?.buffer !== this.#memory.buffer) {
      this.#boxes = new Float32Array(this.#memory.buffer, this.#memory.boxes, BOX * this.#objects);
    }
    return this.#boxes;
  }

  get size() {
    return this.#memory.calls.trisap_world_len(this.#world);
  }

  get memoryBytes() {
    return this.#memory.bytes;
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
    const at = this.#box(box, "insert");
    const { calls, structs } = this.#memory;
    this.#check(calls.trisap_world_insert(this.#world, at, structs + OUT), "insert");
    const id = this.#memory.view.getBigUint64(structs + OUT, true);
    this.#keep(id, box, 0);
    return id;
  }

  insertMany(boxes) {
    if (!(boxes instanceof Float32Array) || boxes.length % BOX !== 0) {
      throw new errors.InvalidArgumentError("boxes", "is a Float32Array of six numbers a box");
    }
    const count = boxes.length / BOX;
    // Views of this memory are of no use any more once it has grown: what they held is still where it was.
    const own = boxes.buffer === this.#memory.buffer ? boxes.byteOffset : null;
    const ids = this.#memory.temporary((8 + BOX_BYTES) * count);
    const at = ids + 8 * count;
    const source = own === null ? boxes : new Float32Array(this.#memory.buffer, own, BOX * count);
    new Float32Array(this.#memory.buffer, at, BOX * count).set(source);
    const { calls } = this.#memory;
    this.#check(calls.trisap_world_insert_many(this.#world, this.#view(at, count), ids), "insertMany");
    const answer = new BigUint64Array(this.#memory.buffer, ids, count).slice();
    const copy = new Float32Array(this.#memory.buffer, at, BOX * count);
    answer.forEach((id, i) => this.#keep(id, copy, BOX * i));
    return answer;
  }

  update(id, box) {
    const at = this.#box(box, `update of object ${id}`);
    this.#check(this.#memory.calls.trisap_world_update(this.#world, id, at), "update", id);
    this.#keep(id, box, 0);
  }

  remove(id) {
    this.#check(this.#memory.calls.trisap_world_remove(this.#world, id), "remove", id);
  }

  removeMany(ids) {
    const at = this.#ids(ids);
    this.#check(this.#memory.calls.trisap_world_remove_many(this.#world, at, ids.length), "removeMany");
  }

  has(id) {
    return this.#memory.calls.trisap_world_contains(this.#world, id) === STATUS.OK;
  }

  idAt(slot) {
    const id = BigInt.asUintN(64, this.#memory.calls.trisap_world_id_at(this.#world, slot));
    return id === 0n ? null : id;
  }

  box(id) {
    const { calls, structs, buffer } = this.#memory;
    this.#check(calls.trisap_world_aabb(this.#world, id, structs + ANSWER), "box", id);
    return new Float32Array(buffer, structs + ANSWER, BOX).slice();
  }

  step() {
    const { calls, structs } = this.#memory;
    this.#results.clear();
    const boxes = this.#view(this.#memory.boxes, this.#slots);
    const status = calls.trisap_world_step_over(this.#world, boxes, 0, structs + RESULT);
    this.#check(status, "step");
    const rejected = this.#memory.view.getUint32(structs + RESULT + RESULT_REJECTED, true);
    if (rejected !== 0) {
      const id = this.#memory.view.getBigUint64(structs + RESULT + RESULT_FIRST_REJECTED, true);
      const place = `step: object ${id} in slot ${slotOf(id)}, the first of ${rejected}`;
      throw new errors.BadBoxError(place, { id, count: rejected });
    }
    return this;
  }

  stats() {
    const { calls, structs } = this.#memory;
    this.#check(calls.trisap_world_stats(this.#world, structs + STATS), "stats");
    return readStats(this.#memory.view, structs + STATS);
  }

  setFilter(id, { group = 0xffff_ffff, mask = 0xffff_ffff, objectClass = 0 } = {}) {
    const { calls, structs, view } = this.#memory;
    [group, mask, objectClass].forEach((word, i) => view.setUint32(structs + ARGUMENT + 4 * i, word, true));
    this.#check(calls.trisap_world_set_filter(this.#world, id, structs + ARGUMENT), "setFilter", id);
  }

  setClasses(meets) {
    if (meets.length !== 32) {
      throw new errors.InvalidArgumentError("meets", "has 32 numbers");
    }
    const { calls, structs, view } = this.#memory;
    Array.from(meets).forEach((word, i) => view.setUint32(structs + ARGUMENT + 4 * i, word, true));
    this.#check(calls.trisap_world_set_classes(this.#world, structs + ARGUMENT), "setClasses");
  }

  setValue(id, value) {
    this.#check(this.#memory.calls.trisap_world_set_value(this.#world, id, value), "setValue", id);
  }

  setValues(ids, values) {
    if (ids.length !== values.length) {
      throw new errors.InvalidArgumentError("values", "are as many as ids");
    }
    const count = ids.length;
    // Both stand in the memory that is free for a moment.
    const at = this.#ids([...ids, ...values]);
    const { calls } = this.#memory;
    this.#check(calls.trisap_world_set_value_many(this.#world, at, at + 8 * count, 8, count), "setValues");
  }

  value(id) {
    const { calls, structs } = this.#memory;
    this.#check(calls.trisap_world_value(this.#world, id, structs + OUT), "value", id);
    return this.#memory.view.getBigUint64(structs + OUT, true);
  }

  values(ids) {
    const at = this.#ids(ids);
    this.#check(this.#memory.calls.trisap_world_values(this.#world, at, 8, ids.length, at), "values");
    return new BigUint64Array(this.#memory.buffer, at, ids.length).slice();
  }

  pairValues(of = "pairs") {
    if (!Object.hasOwn(PAIRS, of)) {
      throw new errors.InvalidArgumentError("of", `is one of ${Object.keys(PAIRS).join(", ")}, not ${of}`);
    }
    const { calls, structs } = this.#memory;
    return this.#answers(this[of].length / 2, 16, "pairValues", (at, room) =>
      calls.trisap_world_pair_values(this.#world, PAIRS[of], at, room, structs + OUT),
    );
  }

  setResting(ids) {
    this.#check(this.#memory.calls.trisap_world_set_resting(this.#world, this.#ids(ids), ids.length), "setResting");
  }

  wake(ids) {
    this.#check(this.#memory.calls.trisap_world_wake(this.#world, this.#ids(ids), ids.length), "wake");
  }

  overlaps(region) {
    const { calls, structs, view } = this.#memory;
    const sphere = region.center !== undefined;
    view.setUint32(structs + ARGUMENT, sphere ? KIND_SPHERE : KIND_AABB, true);
    view.setFloat32(structs + ARGUMENT + 4, sphere ? region.radius : 0, true);
    this.#point(structs + ARGUMENT + 8, sphere ? region.center : region.min);
    this.#point(structs + ARGUMENT + 20, sphere ? region.center : region.max);
    return this.#answers(64, 8, "overlaps", (at, room) =>
      calls.trisap_world_overlaps(this.#world, structs + ARGUMENT, 0, 0, at, room, structs + OUT),
    );
  }

  firstHit(ray) {
    const { calls, structs } = this.#memory;
    this.#ray(ray);
    this.#check(calls.trisap_world_first_hit(this.#world, structs + ARGUMENT, 0, 0, structs + ANSWER), "firstHit");
    const hit = this.#hit(structs + ANSWER);
    return hit.id === 0n ? null : hit;
  }

  nearest(position, count) {
    if (!Number.isInteger(count) || count < 0) {
      throw new errors.InvalidArgumentError("count", `is a whole number, not ${count}`);
    }
    return this.#nearest(position, count, 0, "nearest");
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
    const { calls, structs, view } = this.#memory;
    by.forEach((part, axis) => view.setFloat64(structs + ARGUMENT + 8 * axis, part, true));
    this.#check(calls.trisap_world_shift_origin(this.#world, structs + ARGUMENT, structs + OUT), "shiftOrigin");
    const rounded = this.#memory.view.getUint32(structs + OUT, true);
    this.#reread();
    return rounded;
  }

  save() {
    const { calls } = this.#memory;
    const size = calls.trisap_world_snapshot_size(this.#world) >>> 0;
    const at = this.#memory.temporary(size);
    const out = this.#memory.structs + OUT;
    this.#check(calls.trisap_world_save(this.#world, at, size, out), "save");
    return new Uint8Array(this.#memory.buffer, at, this.#memory.view.getUint32(out, true)).slice();
  }

  load(snapshot) {
    const { calls, structs } = this.#memory;
    const at = this.#memory.temporary(snapshot.length);
    new Uint8Array(this.#memory.buffer, at, snapshot.length).set(snapshot);
    this.#results.clear();
    this.#check(calls.trisap_world_load(this.#world, at, snapshot.length), "load");
    this.#check(calls.trisap_world_result(this.#world, structs + RESULT), "load");
    this.#slots = this.#objects;
    this.#reread();
  }

  /** The view of boxes for a call. */
  #view(first, count) {
    const at = this.#memory.structs + BOXES;
    this.#memory.view.setUint32(at + BOXES_FIRST, first, true);
    this.#memory.view.setUint32(at + BOXES_COUNT, count, true);
    return at;
  }

  #result(field) {
    const { buffer, structs, view } = this.#memory;
    const known = this.#results.get(field);
    if (known?.buffer === buffer) {
      return known;
    }
    const at = structs + RESULT + field;
    const count = view.getUint32(at + 4, true);
    const pairs = count === 0 ? NONE : new Uint32Array(buffer, view.getUint32(at, true), 2 * count);
    this.#results.set(field, pairs);
    return pairs;
  }

  /** Writes one box for a call. */
  #box(box, place) {
    if (box?.length !== BOX) {
      throw new errors.InvalidArgumentError(place, "a box has six numbers: minimum x, y, z, maximum x, y, z");
    }
    const at = this.#memory.structs + ARGUMENT;
    new Float32Array(this.#memory.buffer, at, BOX).set(box);
    return at;
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

  /** Has the boxes that steps read say what the world says. */
  #reread() {
    const { calls, boxes } = this.#memory;
    for (let slot = 0; slot < this.#slots; slot++) {
      const id = calls.trisap_world_id_at(this.#world, slot);
      if (id !== 0n) {
        this.#check(calls.trisap_world_aabb(this.#world, id, boxes + BOX_BYTES * slot), "box", id);
      }
    }
  }

  /** Writes ids for a call. */
  #ids(ids) {
    const own = ids.buffer === this.#memory.buffer ? ids.slice() : ids;
    const at = this.#memory.temporary(8 * own.length);
    new BigUint64Array(this.#memory.buffer, at, own.length).set(own);
    return at;
  }

  #point(at, point) {
    if (point?.length !== 3) {
      throw new errors.InvalidArgumentError("point", "has three numbers");
    }
    new Float32Array(this.#memory.buffer, at, 3).set(point);
  }

  #ray({ origin, box, direction, distance = Infinity }) {
    const at = this.#memory.structs + ARGUMENT;
    if (box !== undefined) {
      this.#box(box, "box");
    } else {
      this.#point(at, origin);
      this.#point(at + 12, origin);
    }
    this.#point(at + 24, direction);
    this.#memory.view.setFloat32(at + 36, distance, true);
  }

  /** The nearest objects but for the first ones. */
  #nearest(position, count, skipped, place) {
    const { calls, structs } = this.#memory;
    this.#point(structs + ARGUMENT, position);
    const room = Math.min(count, this.size);
    const at = this.#memory.temporary(16 * room);
    this.#check(calls.trisap_world_nearest(this.#world, structs + ARGUMENT, 0, 0, at, room, structs + OUT), place);
    const told = this.#memory.view.getUint32(structs + OUT, true);
    return Array.from({ length: Math.max(told - skipped, 0) }, (_, i) => this.#hit(at + 16 * (skipped + i)));
  }

  #hit(at) {
    const { view } = this.#memory;
    return { id: view.getBigUint64(at, true), distance: view.getFloat64(at + 8, true) };
  }

  /** Asks with more room until there is enough; the answers of so many bytes as words of eight. */
  #answers(room, bytes, place, ask) {
    for (;;) {
      const at = this.#memory.temporary(bytes * room);
      const status = ask(at, room);
      const count = this.#memory.view.getUint32(this.#memory.structs + OUT, true);
      if (status === STATUS.OUTPUT_FULL && count > room) {
        room = count;
        continue;
      }
      this.#check(status, place);
      return new BigUint64Array(this.#memory.buffer, at, (bytes / 8) * count).slice();
    }
  }

  /** Throws what a status says. `id` is the object that the call is about. */
  #check(status, place, id = null) {
    if (status === STATUS.OK) {
      return;
    }
    const { calls } = this.#memory;
    const detail = this.#world === undefined ? 0n : BigInt.asUintN(64, calls.trisap_world_error_detail(this.#world));
    const text = this.#memory.text(calls.trisap_status_text(status));
    switch (status) {
      case STATUS.BAD_BOX:
        throw new errors.BadBoxError(id === null ? `${place}, box ${detail}` : `${place} of object ${id}`, {
          index: id === null ? Number(detail) : null,
          id,
        });
      case STATUS.STALE_ID:
        throw new errors.StaleIdError(id ?? detail);
      case STATUS.OBJECTS_FULL:
        throw new errors.ObjectsFullError(Number(detail), this.#objects);
      case STATUS.PAIRS_FULL:
        throw new errors.PairsFullError(Number(detail), this.config.pairs);
      case STATUS.NO_FILTERS:
        throw new errors.NoFiltersError();
      case STATUS.NO_VALUES:
        throw new errors.NoValuesError();
      case STATUS.BAD_CLASS:
        throw new errors.BadClassError(Number(detail));
      case STATUS.BAD_QUERY:
        throw new errors.BadQueryError(`${place}: ${text}`);
      case STATUS.BAD_SNAPSHOT:
        throw new errors.BadSnapshotError(`${place}: ${text}`);
      case STATUS.CORRUPT:
        throw new errors.CorruptError(`${place}: ${text}`);
      default:
        throw new errors.TrisapError(`${place}: ${text}`);
    }
  }
}
