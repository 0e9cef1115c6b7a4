// Types of the package trisap.

/**
 * Names an object for as long as it lives. The id of a removed object stays stale when its slot is used again. Made by a world
 * alone: a slot is no id. `idText` makes it a text, for JSON.
 */
export type Id = bigint;

/** Whether a query counts an object. Called between two looks at the world: it may ask the world, but not change it. */
export type Where = (id: Id) => boolean;

/** Six numbers: minimum x, y, z, maximum x, y, z. Closed: boxes that touch overlap. */
export type Box = ArrayLike<number>;

/** Three numbers. */
export type Point = ArrayLike<number>;

/** What a world is made for. Everything but `objects` has a default that suits most scenes. */
export interface Config {
  /** Objects that can live at once. */
  objects: number;
  /** Pairs that a step can return. By default eight an object. */
  pairs?: number;
  /** Boxes that may reach beyond their leaf of the tree. By default half of `objects`. */
  leafRefs?: number;
  /** Steps tell the found and the lost pairs. By default false. */
  events?: boolean;
  /** Objects have a filter. By default false. */
  filters?: boolean;
  /** Objects have a value: 64 bits of yours, an entity or an index. By default false. */
  values?: boolean;
  /** `exact`, the default: the overlaps of the boxes as given. `fat`: those of the boxes with their margins. */
  mode?: "exact" | "fat";
  /** Up to 256 objects are swept without vectors and their memory. A world that grows beyond them is not lean any more. By default false. */
  lean?: boolean;
  /** The margin as a share of an object's largest extent. Any of the three margins turns margins on. */
  marginPerExtent?: number;
  /** The least margin, a length. */
  marginMin?: number;
  /** The largest margin, a length. */
  marginMax?: number;
  /** Margins stay in use however fast objects are. In a `fat` world it changes which pairs are told. By default false. */
  fixedMargins?: boolean;
  /** Objects that go on as they do cost little: their boxes are predicted for some steps. By default true. */
  predictedBoxes?: boolean;
  /**
   * Objects and pairs that do not fit, also those of a snapshot, make the world move to more memory: no error, but all views are taken
   * away in that call. By default false.
   */
  grows?: boolean;
}

export interface Options {
  /** The module with 128-bit vectors, or the one without. By default what this host can run. */
  simd?: boolean;
  /**
   * A smaller module, for pairs alone: no events, filters, values, margins, queries, pairs by id, snapshots, disabled objects or shifts.
   * They are refused. Hosts without vectors get the complete one, and so do programs with the module inlined. By default false.
   */
  pairsOnly?: boolean;
  /** The module, if it does not stand where the package has put it. */
  wasm?: WasmSource | PromiseLike<WasmSource>;
}

/** Bytes, a `WebAssembly.Module`, or what `fetch` answers: written so that programs without the types of browsers can use it. */
export type WasmSource = ArrayBuffer | ArrayBufferView | object;

/** Whom an object meets: two objects make a pair if each one's group is in the other one's mask, and their classes meet. */
export interface Filter {
  /** The groups that the object is in, one bit each. By default all. */
  group?: number;
  /** The groups that it meets. By default all. */
  mask?: number;
  /** Its class, below 32. By default 0. */
  objectClass?: number;
}

/** A closed part of space. */
export type Region = { min: Point; max: Point } | { center: Point; radius: number };

/** A point, or a box, that moves along a line. */
export type Ray = ({ origin: Point } | { box: Box }) & {
  direction: Point;
  /** How far it moves, in units of `direction`. By default without end. */
  distance?: number;
};

export interface Hit {
  id: Id;
  /** For rays in units of the direction, for the nearest objects a length. */
  distance: number;
}

/** What the last step did. */
export interface Stats {
  path: "unchanged" | "lists" | "movers" | "full" | "rebuilt" | "moversByLeaf";
  reason: string;
  objects: number;
  moved: number;
  leaves: number;
  leavesInUse: number;
  fullestLeaf: number;
  large: number;
  rebalanced: number;
  fineLeaves: boolean;
  outran: number;
  copies: number;
  candidates: number;
  tied: number;
  pairs: number;
  found: number;
  lost: number;
  surplus: number;
  /** Pairs of boxes in the same leaf that were not compared, since their filters do not meet. */
  spared: number;
}

/**
 * Objects with boxes, and the pairs of those that overlap.
 *
 * Arrays that a world hands out as properties are views of its memory: they cost nothing. `boxes` holds for as long as the
 * world, pairs until the next `step`, `load`, `restore` or `sortResults`; no other call takes them away, so a loop over pairs may call what it likes.
 * Only where a world `grows`, the `insert`, `insertMany`, `step` or `load` that makes it do so gives new views, and a `restore` to
 * other room. All other answers are copies.
 */
export class World {
  private constructor();
  /** What the world was made for, the defaults included. Margins are there if it has any. */
  readonly config: Readonly<Config & Required<Omit<Config, "marginPerExtent" | "marginMin" | "marginMax">>>;
  /** Which module it runs in. */
  readonly variant: "simd128" | "scalar" | "pairs" | "given";
  /** The instructions that its kernels use. */
  readonly instructionSet: string;
  /**
   * Whether floats are too coarse for some box at its place, so that boxes may have lost their shape: shift the origin. Looks at all
   * objects: ask now and then.
   */
  isCoarse(): boolean;
  /** Bytes of its memory, which `createWorlds` shares among its worlds. */
  readonly memoryBytes: number;
  /** Living objects. */
  readonly size: number;
  /** The boxes that `step` reads, six numbers a slot. Write to them what moves. */
  readonly boxes: Float32Array;
  /** The overlapping pairs of the last step, two slots each, the lower one first; each pair once. */
  readonly pairs: Uint32Array;
  /** With events: pairs that the last step has and the one before had not. */
  readonly found: Uint32Array;
  /** With events: pairs that the step before had and the last one has not. */
  readonly lost: Uint32Array;

  /** Adds an object. In a world that has not lost any, slots are given out from 0 upwards. */
  insert(box: Box): Id;
  /** The same in a slot that you name, which has to be free: so worlds agree on slots, as those of a server and its clients. */
  insertAt(slot: number, box: Box): Id;
  /** Adds objects, all or none. Ids in the order of the boxes. */
  insertMany(boxes: Float32Array): BigUint64Array;
  /** Gives an object another box, checked at once. */
  update(id: Id, box: Box): void;
  /** Gives objects other boxes, all or none; as many as ids. */
  updateMany(ids: ArrayLike<Id>, boxes: Float32Array): void;
  remove(id: Id): void;
  /** Removes objects, all or none. */
  removeMany(ids: ArrayLike<Id>): void;
  /** Removes all objects: their pairs are lost at the next step. */
  clear(): void;
  has(id: Id): boolean;
  /** The object in a slot, if one lives there. */
  idAt(slot: number): Id | null;
  /** All living objects, by ascending slot. */
  ids(): BigUint64Array;
  /** The box of an object as the world knows it: what was written to `boxes` counts from the next step or `refresh` on. A copy. */
  box(id: Id): Float32Array;
  /**
   * Takes in what was written to `boxes` since the last step, but for objects at rest, and brings the tree up to date: queries and `box`
   * see it then, and queries are as fast as after a step. A world that is only asked needs no step, and `pairs` can be 0. The pairs of
   * the last step stay, and the next one has those, and the events, that it would have had. O(slots).
   *
   * @throws BadBoxError after all others were taken in: objects whose box is refused have kept theirs.
   */
  refresh(): void;
  /** The same. */
  commit(): void;
  /**
   * Finds all pairs of the boxes as they are now. Returns the world, whose `pairs`, `found` and `lost` are those of this step.
   *
   * @throws BadBoxError after the step: objects whose box is refused have kept theirs.
   * @throws PairsFullError after the step: `pairs` holds those that fit.
   */
  step(): this;
  stats(): Stats;
  setFilter(id: Id, filter?: Filter): void;
  /** Sets whom objects meet, all or none: one filter for each, or one for all. */
  setFilters(ids: ArrayLike<Id>, filters: readonly Filter[] | Filter): void;
  /** Which classes meet: bit `b` of number `a`, and bit `a` of number `b`. 32 numbers. */
  setClasses(meets: ArrayLike<number>): void;
  /** Sets how far an object may move before it counts as moved. */
  setMargin(id: Id, length: number): void;
  /** Gives an object a value. A new one has 0. */
  setValue(id: Id, value: bigint): void;
  /** Gives objects values, all or none; as many as ids. */
  setValues(ids: ArrayLike<Id>, values: ArrayLike<bigint>): void;
  value(id: Id): bigint;
  /** The values of objects: of those that `overlaps` has found, for instance. */
  values(ids: ArrayLike<Id>): BigUint64Array;
  /**
   * `pairs`, `found` or `lost` by value, two values each. Lost pairs have those that the objects of the pair had last, also where these
   * are no more and others have their slots.
   * Other pairs of objects that were removed since the step are left out.
   */
  pairValues(of?: "pairs" | "found" | "lost"): BigUint64Array;
  /** `pairs`, `found` or `lost` by id, two each, as `pairValues` tells them by value. */
  pairIds(of?: "pairs" | "found" | "lost"): BigUint64Array;
  /**
   * Puts objects to rest where they are, what was written to `boxes` before included: steps do not read their boxes until they
   * wake.
   */
  setResting(ids: ArrayLike<Id>): void;
  wake(ids: ArrayLike<Id>): void;
  /**
   * Disables objects, or enables them again. Disabled ones are in no pair and in no answer, and cost a step nothing. They keep id, box,
   * margin, filter and value, and can be given others. Boxes that were written before are taken in; what is written while an object is
   * disabled waits until it is enabled. It counts as resting until it is woken or updated, and is awake when it is enabled.
   */
  setEnabled(ids: ArrayLike<Id>, enabled?: boolean): void;
  isEnabled(id: Id): boolean;
  /** Whether an object was put to rest and has not been woken since. */
  isResting(id: Id): boolean;
  /** The pairs of the last step with at least one object that does not rest, as `pairs`. A copy. */
  awakePairs(): Uint32Array;
  /** The objects whose boxes overlap a region, by ascending slot. */
  overlaps(region: Region, where?: Where): BigUint64Array;
  /** The first object that a ray meets. */
  firstHit(ray: Ray, where?: Where): Hit | null;
  /** All objects that a ray meets, the nearest first, equally near ones by ascending slot. */
  hits(ray: Ray, where?: Where): Hit[];
  /** The nearest objects, the nearest first. */
  nearest(position: Point, count: number, where?: Where): Hit[];
  /** `nearest` of each point, three numbers each. */
  nearestMany(points: ArrayLike<number>, count: number): Hit[][];
  /**
   * The objects on the inner side of planes, by ascending slot: what is in a frustum. A plane is four numbers: a normal that points
   * outward, and its distance along that. Near edges and corners some boxes that are not quite inside count.
   */
  within(planes: ArrayLike<number>, where?: Where): BigUint64Array;
  /**
   * Visits the objects whose boxes are at most so far from a point, each once, the nearest first. The visitor says how far to look
   * on: nothing or infinity to refuse an object and look as far as before, a number to see only what is not farther, less than zero
   * to stop. It must not change the world.
   */
  visitNearest(position: Point, visit: (hit: Hit) => number | void, distance?: number): void;
  /**
   * Subtracts a point from all boxes, also from what was written to `boxes` since the last step. How many boxes of the world had
   * to be rounded outward.
   */
  shiftOrigin(by: readonly [number, number, number]): number;
  /**
   * A snapshot: bytes that any world of the same kind can load that has as much room or grows, for files and for those who join late. It
   * goes on with the same pairs and events; their order may be another one. What was written to `boxes` is taken in first, as by
   * `commit`; a box that is refused stays for the next step to tell.
   */
  save(): Uint8Array;
  /** Goes back to a snapshot. `boxes` says what it says: what was written since is gone, as all else is. */
  load(snapshot: Uint8Array): void;
  /**
   * A copy of the world, to go back to: it takes what copying its bytes takes, and the world goes on from it byte for byte, order
   * and statistics included. `into` an earlier copy of this world, whose memory is used again.
   */
  copy(into?: WorldCopy): WorldCopy;
  /** Goes back to a copy of this world, with what was written to `boxes` then; also where it has grown since. */
  restore(copy: WorldCopy): void;
  /**
   * Puts `pairs`, `found` and `lost` into an order that depends on them alone, whatever the room and the past of the world are:
   * persisting pairs in ascending order, behind them the found ones in ascending order; lost ones ascend, too.
   */
  sortResults(): this;
}

/** A copy of a world: see `World.copy`. */
export class WorldCopy {
  private constructor();
  /** How many bytes it has. */
  readonly byteLength: number;
}

/**
 * A number for each pair, from the step that finds it to the step that loses it: what is kept for a pair (a manifold, a sound,
 * damage) stands in an array at that place. Numbers are given again, the one that became free last first. Beside a world with
 * `events`; grows by itself.
 */
export class Contacts {
  /** How many pairs have a number. */
  readonly size: number;
  /**
   * To be called with each step: takes back the numbers of `lost`, then gives those of `found` numbers. `ended` and `began` are these, in
   * the order of `lost` and `found`; 0xffffffff for a lost pair that had none. In a world that has pairs already,
   * `update({ lost: [], found: world.pairs })` comes first.
   */
  update(step: { readonly lost: ArrayLike<number>; readonly found: ArrayLike<number> }): { ended: Uint32Array; began: Uint32Array };
  /** The number of a pair of slots, in any order. */
  get(a: number, b: number): number | undefined;
  /** The contacts of an object: number and partner's slot. */
  of(slot: number): IterableIterator<[contact: number, partner: number]>;
  /** Takes back all numbers of an object, for those who cannot wait for the lost pairs of the next step. */
  removeAll(slot: number): void;
  /** A copy, to go back to with a copy or a snapshot of the world: each pair has the number again that it had. */
  copy(): Contacts;
  restore(copy: Contacts): void;
}

/** An empty world. */
export function createWorld(config: Config, options?: Options): Promise<World>;
/**
 * So many empty worlds of one kind in one memory, as for the rooms of a server: hosts set aside addresses for each memory, and run out of
 * them. They cannot grow. Their memory goes when all of them are gone; a room that closes can be cleared and used again.
 */
export function createWorlds(count: number, config: Config, options?: Options): Promise<World[]>;
/**
 * The pairs of boxes that are there once, six numbers each, by their positions, the lower one first; with `between`, pairs of a box
 * of one and a box of the other. Two numbers a pair, in no order. No world has to be made, and none is kept.
 */
export function pairs(boxes: ArrayLike<number>, options?: Options & { between?: ArrayLike<number> }): Promise<Uint32Array>;
/** The index under which an object stands in pairs and in `World.boxes`. */
export function slotOf(id: Id): number;
/** An id as a text, for JSON, and back. */
export function idText(id: Id): string;
export function idOf(text: string): Id;
/** Whether this host has 128-bit vectors. */
export function hasVectors(): boolean;

/** What every exception of this package is. */
export class TrisapError extends Error {}
/** A field of a configuration, or an argument, is out of its range. */
export class InvalidArgumentError extends TrisapError {
  readonly field: string;
}
/** A box has NaN in it or a minimum above its maximum. */
export class BadBoxError extends TrisapError {
  /** Its place in the batch, if it was a batch. */
  readonly index: number | null;
  /** Whose it is, if it is an object's. */
  readonly id: Id | null;
  readonly slot: number | null;
  /** How many boxes were refused. */
  readonly count: number;
}
/** The slot has an object. */
export class SlotTakenError extends TrisapError {
  readonly id: Id;
  readonly slot: number;
}
/** An id names no living object, or comes twice in `removeMany`. */
export class StaleIdError extends TrisapError {
  readonly id: Id;
  readonly slot: number;
}
/** More objects than the capacity. */
export class ObjectsFullError extends TrisapError {
  readonly needed: number;
  readonly capacity: number;
}
/** More pairs than the capacity. */
export class PairsFullError extends TrisapError {
  readonly needed: number;
  readonly capacity: number;
}
/** The world was made without `filters`. */
export class NoFiltersError extends TrisapError {}
/** The world was made without `values`. */
export class NoValuesError extends TrisapError {}
/** The world was made without a margin. */
export class NoMarginsError extends TrisapError {}
/** A class is 32 or more. */
export class BadClassError extends TrisapError {
  readonly objectClass: number;
}
/** A query has NaN, infinities or negative lengths where they make no sense. */
export class BadQueryError extends TrisapError {}
/** The bytes are no snapshot of a world of this configuration. */
export class BadSnapshotError extends TrisapError {}
/** The host has not given the memory. */
export class OutOfMemoryError extends TrisapError {
  readonly bytes: number;
}
/** Somebody else has written to the memory of the world. */
export class CorruptError extends TrisapError {}
/** What came is no module of this package, or nothing came: the message says what, and what to pass instead. */
export class ModuleError extends TrisapError {}
