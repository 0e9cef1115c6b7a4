// Ids: 64 bits, a slot and a generation.

/** The index under which an object stands in pairs and in `World.boxes`. */
export function slotOf(id) {
  return Number(BigInt.asUintN(32, id));
}
