// What each way to load a module gives.

import { moduleFor } from "./load.js";
import { find } from "./once.js";
import { World } from "./world.js";

/** The functions that need a module; `read` gives one of a variant. */
export function api(read) {
  /** So many empty worlds of one kind in one memory. */
  const createWorlds = async (count, config, options) => World.instantiate(await moduleFor(read, options), config, count);

  /** An empty world. */
  const createWorld = async (config, options) => (await createWorlds(1, config, options))[0];

  /** The pairs of boxes that are there once. */
  const pairs = async (boxes, { between, ...options } = {}) =>
    find(await moduleFor(read, { ...options, pairsOnly: false }), boxes, between);

  return { createWorld, createWorlds, pairs };
}
