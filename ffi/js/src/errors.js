// What can go wrong, as exceptions. Each says which object or which number it is about.


/** `id.js` needs these classes, so it cannot be asked here. */
const slotOf = (id) => Number(BigInt.asUintN(32, id));

/** What every exception of this package is, but a TypeError for an argument of another type. */
export class TrisapError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = new.target.name;
  }
}

/** A field of a configuration, or of an argument, is out of its range. */
export class InvalidArgumentError extends TrisapError {
  constructor(field, what) {
    super(`${field}: ${what}`);
    this.field = field;
  }
}

/** A box has NaN in it or a minimum above its maximum. */
export class BadBoxError extends TrisapError {
  constructor(place, { index = null, id = null, count = 1 }) {
    super(`${place}: the box has NaN in it or a minimum above its maximum`);
    this.index = index;
    this.id = id;
    this.slot = id === null ? null : slotOf(id);
    this.count = count;
  }
}

/** An id names no living object. */
export class StaleIdError extends TrisapError {
  constructor(id) {
    super(`object ${id} (slot ${slotOf(id)}) does not live, or comes twice`);
    this.id = id;
    this.slot = slotOf(id);
  }
}

/** The slot has an object. */
export class SlotTakenError extends TrisapError {
  constructor(id) {
    super(`slot ${slotOf(id)} has the object ${id}`);
    this.id = id;
    this.slot = slotOf(id);
  }
}

/** More objects than the capacity. */
export class ObjectsFullError extends TrisapError {
  constructor(needed, capacity) {
    super(`${needed} objects, but the world was made for ${capacity}`);
    this.needed = needed;
    this.capacity = capacity;
  }
}

/** More pairs than the capacity. The step has happened, and `pairs` holds those that fit. */
export class PairsFullError extends TrisapError {
  constructor(needed, capacity) {
    super(`${needed} pairs, but the world was made for ${capacity}`);
    this.needed = needed;
    this.capacity = capacity;
  }
}

/** The world was made without `filters`. */
export class NoFiltersError extends TrisapError {
  constructor() {
    super("the world was made without filters");
  }
}

/** The world was made without `values`. */
export class NoValuesError extends TrisapError {
  constructor() {
    super("the world was made without values");
  }
}

/** The world was made without a margin. */
export class NoMarginsError extends TrisapError {
  constructor() {
    super("the world was made without margins");
  }
}

/** A class is 32 or more. */
export class BadClassError extends TrisapError {
  constructor(objectClass) {
    super(`class ${objectClass} is not below 32`);
    this.objectClass = objectClass;
  }
}

/** A query has NaN, infinities or negative lengths where they make no sense. */
export class BadQueryError extends TrisapError {}

/** The bytes are no snapshot of a world of this configuration. */
export class BadSnapshotError extends TrisapError {}

/** The host has not given the memory. */
export class OutOfMemoryError extends TrisapError {
  constructor(bytes) {
    super(`the host has no memory of ${bytes} bytes to give`);
    this.bytes = bytes;
  }
}

/** Somebody else has written to the memory of the world. */
export class CorruptError extends TrisapError {}

/** What came is no module of this package, or nothing came. */
export class ModuleError extends TrisapError {}
