// Calls of the C ABI: what they take and answer stands in the memory of one world, and what they refuse is an exception.

import { known, objectsOf, readConfig, writeConfig } from "./config.js";
import * as errors from "./errors.js";
import { checkId } from "./id.js";
import { Memory } from "./memory.js";

/** Numbers of `trisap_status`. */
export const STATUS = {
  OK: 0, MEMORY_TOO_SMALL: 6, CAPACITY_TOO_LARGE: 9, BAD_MARGIN: 10, OBJECTS_FULL: 11, BAD_BOX: 12, STALE_ID: 13, PAIRS_FULL: 14,
  CORRUPT: 15, NO_FILTERS: 16, BAD_CLASS: 17, BAD_QUERY: 18, OUTPUT_FULL: 19, BAD_SNAPSHOT: 20, BAD_SHIFT: 21, OTHER_CONFIG: 23,
  NO_VALUES: 24, NO_MARGINS: 25, SLOT_TAKEN: 26,
};
/** Floats of a box. */
export const BOX = 6;
const BOX_BYTES = 4 * BOX;
const KIND_AABB = 0;
const KIND_SPHERE = 1;
/** What a module for pairs alone cannot do. */
const BEYOND_PAIRS = ["events", "filters", "values", "marginPerExtent", "marginMin", "marginMax"];
const FILTER = { group: 0xffff_ffff, mask: 0xffff_ffff, objectClass: 0 };

// Where the structs of a call stand, from the start of their part of memory on.
const CONFIG = 0;
const BOXES = 128;
const RESULT = 192;
const ARGUMENT = 256;
const ANSWER = 384;
const STATS = 512;
const OUT = 640;

/** A field of `trisap_config`. */
const CONFIG_PAIRS = 12;
/** More cannot be in a lean world. */
const LEAN_OBJECTS = 256;

export class Calls {
  #given;

  /** An empty world in an instance of the module, `from` a place of its memory on. */
  constructor(instance, config, from) {
    const objects = objectsOf(config);
    this.memory = new Memory(instance, from);
    const { calls, structs } = this.memory;
    this.calls = calls;
    this.config = structs + CONFIG;
    this.result = structs + RESULT;
    this.argument = structs + ARGUMENT;
    this.answer = structs + ANSWER;
    this.stats = structs + STATS;
    this.out = structs + OUT;
    // His own object may change before the world grows.
    this.#given = { ...config };
    if (!Object.hasOwn(calls, "trisap_world_save")) {
      const field = BEYOND_PAIRS.find((field) => (config[field] ?? false) !== false);
      if (field !== undefined) {
        throw new errors.InvalidArgumentError(field, "is not in the module with pairs alone");
      }
    }
    const [bytes, room] = this.#configure(objects, {});
    // Where there can be no such world, the call below says why.
    this.memory.lay(this.memory.boxes, bytes === 0 ? 0 : objects, bytes, room);
    this.check(calls.trisap_world_init(this.memory.world, bytes, this.config, this.out), "config");
    this.world = this.memory.world;
    calls.trisap_default_result(this.result);
    calls.trisap_default_stats(this.stats);
    this.#moved();
  }

  /** Moves the world to more memory behind its own: with so many objects and pairs at least. Takes all views away. */
  grow(objects, pairs) {
    const { memory, calls, world, capacity } = this;
    const [boxes, count] = [memory.boxes, BOX * capacity.objects];
    const more = Math.max(objects, capacity.objects);
    const [bytes, room] = this.#configure(more, {
      leafRefs: Math.max(capacity.leafRefs, Math.floor(more / 2)),
      pairs: Math.min(Math.max(pairs, capacity.pairs, 8 * more), 0xffff_ffff),
      lean: capacity.lean && more <= LEAN_OBJECTS,
    });
    if (bytes === 0) {
      throw new errors.OutOfMemoryError(2 ** 32);
    }
    memory.lay(memory.end, more, bytes, room);
    this.array(Float32Array, memory.boxes, count).set(this.array(Float32Array, boxes, count));
    this.check(calls.trisap_world_move(world, memory.world, bytes, this.config, this.out), "growth");
    this.world = memory.world;
    this.#moved();
  }

  /** Goes back to a copy of this world, also to where it was then: the memory behind it is there to grow into again. */
  restore({ bytes, world, capacity, place }) {
    const { memory, calls } = this;
    const worldBytes = bytes.length - world;
    memory.place = place;
    this.world = memory.world;
    this.array(Uint8Array, memory.boxes, world).set(bytes.subarray(0, world));
    this.array(Uint8Array, memory.world, worldBytes).set(bytes.subarray(world));
    this.check(calls.trisap_world_open(memory.world, worldBytes, this.out), "restore");
    this.check(calls.trisap_world_result(memory.world, this.result), "restore");
    this.capacity = capacity;
  }

  /** Writes the configuration that the caller wants, with some fields in place of his; the bytes of the world and of what calls need. */
  #configure(objects, instead) {
    const { calls, view } = this.memory;
    calls.trisap_default_config(this.config, objects);
    writeConfig(view, this.config, { ...this.#given, ...instead, objects });
    const bytes = calls.trisap_world_size(this.config) >>> 0;
    // Ids and boxes of all objects, all pairs by id, or a snapshot, which is smaller than the world.
    const pairs = this.word(this.config + CONFIG_PAIRS);
    return [bytes, bytes === 0 ? 0 : Math.max((8 + BOX_BYTES) * objects, 16 * pairs, bytes)];
  }

  #moved() {
    this.capacity = Object.freeze({ ...readConfig(this.memory.view, this.config), grows: this.#given.grows ?? false });
    this.check(this.calls.trisap_world_result(this.world, this.result), "config");
  }

  /** A `Float32Array`, a `BigUint64Array` and so on of the memory. */
  array(Type, at, length) {
    return new Type(this.memory.buffer, at, length);
  }

  word(at) {
    return this.memory.view.getUint32(at, true);
  }

  id(at) {
    return this.memory.view.getBigUint64(at, true);
  }

  /** Where a call may write so many bytes. */
  room(bytes, what) {
    if (bytes > this.memory.roomBytes) {
      throw new errors.InvalidArgumentError(what, "is more than the world has room for");
    }
    return this.memory.room;
  }

  /** The view of boxes for a call. */
  boxes(first, count) {
    return this.memory.boxesAt(this.memory.structs + BOXES, first, count);
  }

  /** Writes one box for a call. */
  box(box, place) {
    if (box?.length !== BOX) {
      throw new errors.InvalidArgumentError(place, "a box has six numbers: minimum x, y, z, maximum x, y, z");
    }
    this.array(Float32Array, this.argument, BOX).set(box);
    return this.argument;
  }

  /** Writes one id for a call of many, so that the module has no other one. */
  one(id) {
    this.memory.view.setBigUint64(this.answer, checkId(id), true);
    return this.answer;
  }

  /** Writes ids for a call. */
  ids(ids) {
    if (ids.buffer !== this.memory.buffer) {
      Array.prototype.forEach.call(ids, checkId);
    }
    const at = this.room(8 * ids.length, "ids");
    this.array(BigUint64Array, at, ids.length).set(ids);
    return at;
  }

  /** Writes a filter to an address. */
  filter(at, filter) {
    known("filter", filter, Object.keys(FILTER));
    Object.entries(FILTER).forEach(([field, usual], i) => {
      this.memory.view.setUint32(at + 4 * i, filter[field] === undefined ? usual : filter[field], true);
    });
  }

  point(at, point) {
    if (point?.length !== 3) {
      throw new errors.InvalidArgumentError("point", "has three numbers");
    }
    this.array(Float32Array, at, 3).set(point);
  }

  /** Writes a region for a call. */
  region(region) {
    const sphere = region?.center !== undefined;
    known("region", region, sphere ? ["center", "radius"] : ["min", "max"]);
    this.memory.view.setUint32(this.argument, sphere ? KIND_SPHERE : KIND_AABB, true);
    this.memory.view.setFloat32(this.argument + 4, sphere ? region.radius : 0, true);
    this.point(this.argument + 8, sphere ? region.center : region.min);
    this.point(this.argument + 20, sphere ? region.center : region.max);
    return this.argument;
  }

  /** Writes a ray for a call. */
  ray(ray) {
    known("ray", ray, [ray?.box === undefined ? "origin" : "box", "direction", "distance"]);
    const { origin, box, direction, distance = Infinity } = ray;
    if (box !== undefined) {
      this.box(box, "box");
    } else {
      this.point(this.argument, origin);
      this.point(this.argument + 12, origin);
    }
    this.point(this.argument + 24, direction);
    this.memory.view.setFloat32(this.argument + 36, distance, true);
    return this.argument;
  }

  hit(at) {
    return { id: this.id(at), distance: this.memory.view.getFloat64(at + 8, true) };
  }

  /** Where the answers of a call stand and how many they are: never more than there is room for. */
  answers(place, most, bytes, ask) {
    const at = this.room(most * bytes, place);
    this.check(ask(at, most), place);
    return [at, this.word(this.out)];
  }

  /** Throws what a status says. `id` is the object that the call is about. */
  check(status, place, id = null) {
    if (status === STATUS.OK) {
      return;
    }
    const detail = this.world === undefined ? 0n : BigInt.asUintN(64, this.calls.trisap_world_error_detail(this.world));
    const text = this.memory.text(this.calls.trisap_status_text(status));
    switch (status) {
      case STATUS.CAPACITY_TOO_LARGE:
        throw new errors.InvalidArgumentError("objects", "need more memory, or their pairs do, than a module can have");
      case STATUS.BAD_MARGIN:
        throw new errors.InvalidArgumentError("margins", "are finite, and their bounds in order");
      case STATUS.BAD_BOX:
        throw new errors.BadBoxError(id === null ? `${place}, box ${detail}` : `${place} of object ${id}`, {
          index: id === null ? Number(detail) : null,
          id,
        });
      case STATUS.STALE_ID:
        throw new errors.StaleIdError(id ?? detail);
      case STATUS.SLOT_TAKEN:
        throw new errors.SlotTakenError(detail);
      case STATUS.OBJECTS_FULL:
        throw new errors.ObjectsFullError(Number(detail), this.capacity.objects);
      case STATUS.PAIRS_FULL:
        throw new errors.PairsFullError(Number(detail), this.capacity.pairs);
      case STATUS.NO_FILTERS:
        throw new errors.NoFiltersError();
      case STATUS.NO_VALUES:
        throw new errors.NoValuesError();
      case STATUS.NO_MARGINS:
        throw new errors.NoMarginsError();
      case STATUS.BAD_CLASS:
        throw new errors.BadClassError(Number(detail));
      case STATUS.BAD_QUERY:
        throw new errors.BadQueryError(`${place}: ${text}`);
      case STATUS.BAD_SHIFT:
        throw new errors.InvalidArgumentError("by", "has three finite numbers");
      case STATUS.BAD_SNAPSHOT:
      case STATUS.OTHER_CONFIG:
        throw new errors.BadSnapshotError(`${place}: ${text}`);
      case STATUS.CORRUPT:
        throw new errors.CorruptError(`${place}: ${text}`);
      default:
        throw new errors.TrisapError(`${place}: ${text}`);
    }
  }
}
