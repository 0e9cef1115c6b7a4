// The memory of one world, in an instance of the module.
//
// From the bottom: the stack and the constants of the module; then for each world structs that calls take and give; the boxes; the
// world; room for what a call takes or answers. All of it is set aside when the world is made, for worlds of one instance before any is
// handed out: memory that grows takes all views of it away.

import { ModuleError, OutOfMemoryError, TrisapError } from "./errors.js";

/** The version of the C ABI whose structs this package knows. */
const ABI_VERSION = 7;
const PAGE = 65536;
/** What the structs of a call take at most. */
const STRUCTS = 1024;
const NO_MEMORY = 0xffff_ffff;
// Fields of `trisap_boxes` on a machine with pointers of four bytes.
const BOXES_FIRST = 8;
const BOXES_COUNT = 16;
/** Calls that a module lacks. */
const ABSENT = new Proxy({}, {
  get(_, name) {
    throw new ModuleError(`${String(name)} is not in the module with pairs alone: make the world without pairsOnly`);
  },
});

export class Memory {
  #view = null;

  constructor(instance, from = instance.exports.__heap_base?.value ?? instance.exports.memory.buffer.byteLength) {
    this.calls = Object.assign(Object.create(ABSENT), instance.exports);
    if (this.calls.trisap_abi_version() !== ABI_VERSION) {
      throw new TrisapError(`the module has ABI version ${this.calls.trisap_abi_version()}, not ${ABI_VERSION}`);
    }
    this.structs = align(from, 64);
    /** Where the boxes, the world and the room of calls begin, and how many bytes that room has. */
    this.boxes = this.structs + STRUCTS;
    this.world = 0;
    this.room = 0;
    this.roomBytes = 0;
    this.#reach(this.boxes);
  }

  get buffer() {
    return this.calls.memory.buffer;
  }

  /** Where it ends, and boxes may begin. */
  get end() {
    return align(this.room + this.roomBytes, 16);
  }

  /** Bytes that the host has given. */
  get bytes() {
    return this.buffer.byteLength;
  }

  /** For structs. */
  get view() {
    if (this.#view?.buffer !== this.buffer) {
      this.#view = new DataView(this.buffer);
    }
    return this.#view;
  }

  /** Sets memory aside from an address on: for the boxes of so many objects, a world of so many bytes, and so many for calls. */
  lay(from, objects, worldBytes, roomBytes) {
    const world = align(from + 24 * objects, this.calls.trisap_world_align());
    const room = align(world + worldBytes, 16);
    this.#reach(room + roomBytes);
    Object.assign(this, { boxes: from, world, room, roomBytes });
  }

  /** Where all that is: to be set to what it was. */
  get place() {
    const { boxes, world, room, roomBytes } = this;
    return { boxes, world, room, roomBytes };
  }

  set place(place) {
    Object.assign(this, place);
  }

  /** Has the room of calls, which is the last of its memory, take so many bytes. */
  widen(roomBytes) {
    this.#reach(this.room + roomBytes);
    this.roomBytes = roomBytes;
  }

  /** Writes a view of boxes for a call to an address. */
  boxesAt(at, first, count) {
    this.calls.trisap_default_boxes(at, first, 0);
    this.view.setUint32(at + BOXES_FIRST, first, true);
    this.view.setUint32(at + BOXES_COUNT, count, true);
    return at;
  }

  /** The text at an address, which ends with a zero. */
  text(at) {
    const bytes = new Uint8Array(this.buffer);
    let text = "";
    for (let i = at; bytes[i] !== 0; i++) {
      text += String.fromCharCode(bytes[i]);
    }
    return text;
  }

  #reach(end) {
    const missing = end - this.buffer.byteLength;
    if (missing <= 0) {
      return;
    }
    if (end >= NO_MEMORY) {
      throw new OutOfMemoryError(end);
    }
    try {
      this.calls.memory.grow(Math.ceil(missing / PAGE));
    } catch (error) {
      if (error instanceof RangeError) {
        throw new OutOfMemoryError(end);
      }
      throw error;
    }
  }
}

function align(at, to) {
  return Math.ceil(at / to) * to;
}
