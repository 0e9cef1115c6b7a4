// Ids: 64 bits, a slot and a generation.

import { InvalidArgumentError } from "./errors.js";

/** The index under which an object stands in pairs and in `World.boxes`. */
export function slotOf(id) {
  return Number(BigInt.asUintN(32, checkId(id)));
}

/** The id as a text that JSON can hold. */
export function idText(id) {
  return String(checkId(id));
}

/** The id of a text that `idText` made. */
export function idOf(text) {
  if (typeof text !== "string" || !/^\d{1,20}$/.test(text)) {
    throw new InvalidArgumentError("text", `is what idText has made of an id, not ${text}`);
  }
  return checkId(BigInt(text));
}

/** Refuses what cannot be an id, before it is taken for that of another object. */
export function checkId(id) {
  if (typeof id !== "bigint" || id < 0n || id >= 2n ** 64n) {
    const hint = typeof id === "number" ? " (of a slot, `idAt` tells the id)" : "";
    throw new InvalidArgumentError("id", `is a bigint that a world has given out, not ${typeof id} ${String(id)}${hint}`);
  }
  return id;
}
