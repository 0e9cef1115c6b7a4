// The configuration of a world and the statistics of a step, as the structs of the C ABI have them. `include/trisap.h` says
// what each field means.

import { InvalidArgumentError } from "./errors.js";

const MODES = ["exact", "fat"];

/** Fields of `trisap_config` by name: where they stand, as which kind. */
const FIELDS = {
  objects: [4, "count"],
  leafRefs: [8, "count"],
  pairs: [12, "count"],
  mode: [16, MODES],
  events: [20, "flag"],
  filters: [24, "flag"],
  lean: [32, "flag"],
  marginPerExtent: [40, "length"],
  marginMin: [44, "length"],
  marginMax: [48, "length"],
  fixedMargins: [52, "flag"],
  values: [56, "flag"],
  predictedBoxes: [60, "flag"],
};
const HAS_MARGIN = 36;
const MARGINS = ["marginPerExtent", "marginMin", "marginMax"];

/** The capacity, checked before the struct is made of it. */
export function objectsOf(config) {
  if (config === null || typeof config !== "object") {
    throw new InvalidArgumentError("config", "is an object with at least `objects`");
  }
  return number("objects", config.objects, "count");
}

/** Refuses an argument that is no object, or has a field that means nothing: a misspelt one would be lost without a word. */
export function known(what, object, fields) {
  if (object === null || typeof object !== "object") {
    throw new InvalidArgumentError(what, `is an object with ${fields.join(", ")}`);
  }
  for (const field of Object.keys(object)) {
    if (!fields.includes(field)) {
      throw new InvalidArgumentError(field, `no such field of ${what}; there are ${fields.join(", ")}`);
    }
  }
}

/** Writes what the caller has set into a struct that has the defaults. */
export function writeConfig(view, at, config) {
  known("config", config, [...Object.keys(FIELDS), "grows"]);
  for (const [field, value] of Object.entries(config)) {
    if (value === undefined) {
      continue;
    }
    if (field === "grows") {
      number(field, value, "flag");
      continue;
    }
    const [offset, kind] = FIELDS[field];
    const raw = number(field, value, kind);
    if (kind === "length") {
      view.setFloat32(at + offset, raw, true);
    } else {
      view.setUint32(at + offset, raw, true);
    }
    if (MARGINS.includes(field)) {
      view.setUint32(at + HAS_MARGIN, 1, true);
    }
  }
}

/** The whole configuration of a world. */
export function readConfig(view, at) {
  const config = {};
  const margins = view.getUint32(at + HAS_MARGIN, true) === 1;
  for (const [field, [offset, kind]] of Object.entries(FIELDS)) {
    // Margins that were set, even to nothing, are not the same as none.
    if (MARGINS.includes(field) && !margins) {
      continue;
    }
    const raw = kind === "length" ? view.getFloat32(at + offset, true) : view.getUint32(at + offset, true);
    config[field] = Array.isArray(kind) ? kind[raw] : kind === "flag" ? raw === 1 : raw;
  }
  return Object.freeze(config);
}

function number(field, value, kind) {
  if (Array.isArray(kind)) {
    if (!kind.includes(value)) {
      throw new InvalidArgumentError(field, `is one of ${kind.join(", ")}, not ${value}`);
    }
    return kind.indexOf(value);
  }
  if (kind === "flag") {
    if (typeof value !== "boolean") {
      throw new InvalidArgumentError(field, `is true or false, not ${value}`);
    }
    return Number(value);
  }
  if (kind === "length") {
    if (typeof value !== "number" || !(value >= 0)) {
      throw new InvalidArgumentError(field, `is a number of at least zero, not ${value}`);
    }
    return value;
  }
  if (!Number.isInteger(value) || value < 0 || value > 0xffff_ffff) {
    throw new InvalidArgumentError(field, `is a whole number from 0 to 4294967295, not ${value}`);
  }
  return value;
}

const PATHS = ["unchanged", "lists", "movers", "full", "rebuilt", "moversByLeaf"];
const REASONS = [
  "no movers", "few objects", "few movers", "many movers", "fixed", "nothing kept", "no room", "outgrown", "out of balance",
  "no room for surplus",
];

/** The statistics, from `trisap_stats`. */
export function readStats(view, at) {
  const word = (offset) => view.getUint32(at + offset, true);
  // Counts of pairs are below 2^53.
  const long = (offset) => Number(view.getBigUint64(at + offset, true));
  return {
    path: PATHS[word(4)],
    reason: REASONS[word(36)] ?? "other",
    objects: word(8),
    moved: word(12),
    leaves: word(16),
    leavesInUse: word(20),
    fullestLeaf: word(24),
    large: word(28),
    rebalanced: word(32),
    fineLeaves: word(40) === 1,
    outran: word(48),
    copies: long(56),
    candidates: long(64),
    tied: long(72),
    pairs: long(80),
    found: long(88),
    lost: long(96),
    surplus: long(104),
    spared: long(112),
  };
}
