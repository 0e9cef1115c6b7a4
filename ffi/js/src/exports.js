// What all ways to load a module export alike.

export { Contacts } from "./contacts.js";
export * from "./errors.js";
export { idOf, idText, slotOf } from "./id.js";
export { hasVectors } from "./load.js";
export { World, WorldCopy } from "./world.js";
