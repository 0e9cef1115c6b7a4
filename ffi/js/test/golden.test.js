// The hashes of `tests/golden.txt`, by both modules: pairs, found and lost of every frame, in their order, are those of every
// other target.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { createWorld } from "trisap";
import { open } from "../peers/recording.js";

const tests = new URL("../../../tests/", import.meta.url);
const CONFIGS = {
  exact: {},
  margin: { marginPerExtent: 0.1 },
  fat: { marginPerExtent: 0.1, mode: "fat" },
};

/** 64-bit FNV-1a, in two halves. */
class Fnv {
  #low = 0x84222325;
  #high = 0xcbf29ce4;

  /** Four bytes. */
  word(word) {
    let [low, high] = [this.#low, this.#high];
    for (let shift = 0; shift < 32; shift += 8) {
      low = (low ^ (word >>> shift & 0xff)) >>> 0;
      // Times 2^40 + 0x1b3.
      const product = low * 0x1b3;
      high = (Math.imul(high, 0x1b3) + Math.floor(product / 2 ** 32) + (low << 8)) >>> 0;
      low = product % 2 ** 32;
    }
    [this.#low, this.#high] = [low, high];
  }

  pairs(pairs) {
    this.word(pairs.length / 2);
    this.word(0);
    for (const slot of pairs) {
      this.word(slot);
    }
  }

  text() {
    return [this.#high, this.#low].map((half) => half.toString(16).padStart(8, "0")).join("");
  }
}

for (const simd of [false, true]) {
  test(`${simd ? "simd128" : "scalar"}: the hashes of all targets`, async () => {
    const table = readFileSync(new URL("golden.txt", tests), "utf8").trim().split("\n");
    assert.ok(table.length > 0);
    for (const line of table) {
      const [file, name] = line.split(" ");
      const { objects, frames } = open(new URL(`recordings/${file}`, tests).pathname);
      const world = await createWorld(
        { objects, leafRefs: 8 * objects, pairs: 40 * objects, events: true, ...CONFIGS[name] },
        { simd },
      );
      const fnv = new Fnv();
      world.insertMany(frames[0]);
      // The recording forwards alone.
      for (const frame of frames.slice(0, frames.length / 2 + 1)) {
        world.boxes.set(frame);
        const { pairs, found, lost } = world.step();
        [pairs, found, lost].forEach((list) => fnv.pairs(list));
      }
      assert.equal(`${file} ${name} ${fnv.text()}`, line);
    }
  });
}
