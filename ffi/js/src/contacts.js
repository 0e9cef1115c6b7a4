// A number for each pair, from the step that finds it to the step that loses it: as `Contacts` of the core keeps them.

import { InvalidArgumentError } from "./errors.js";

const NONE = 0xffff_ffff;
/** Words of a contact: the slots of its pair, and what is next to it in the lists of its two objects. */
const NEXT = 2;
const BEFORE = 4;
const EACH = 6;

export class Contacts {
  /** By slot: the first contact of an object. */
  #first = new Uint32Array(0);
  #links = new Uint32Array(0);
  #size = 0;
  /** Numbers from here on were never given. */
  #used = 0;
  /** The number that became free last; `NEXT` of it leads on. */
  #free = NONE;

  get size() {
    return this.#size;
  }

  update({ lost, found }) {
    const ended = new Uint32Array(lost.length / 2);
    const began = new Uint32Array(found.length / 2);
    let slots = this.#first.length;
    for (let i = 0; i < found.length; i += 2) {
      if (found[i] === found[i + 1]) {
        throw new InvalidArgumentError("found", "pairs of two objects");
      }
      slots = Math.max(slots, found[i] + 1, found[i + 1] + 1);
    }
    this.#first = grown(this.#first, slots);
    this.#links = grown(this.#links, EACH * (this.#size + began.length));
    for (let i = 0; i < ended.length; i++) {
      ended[i] = this.get(lost[2 * i], lost[2 * i + 1]) ?? NONE;
      if (ended[i] !== NONE) {
        this.#remove(ended[i]);
      }
    }
    for (let i = 0; i < began.length; i++) {
      const [a, b] = [found[2 * i], found[2 * i + 1]];
      began[i] = this.get(a, b) ?? this.#insert(Math.min(a, b), Math.max(a, b));
    }
    return { ended, began };
  }

  get(a, b) {
    const slots = [a, b];
    const contacts = slots.map((slot) => this.#first[slot] ?? NONE);
    for (let turn = 0; ; turn ^= 1) {
      const contact = contacts[turn];
      if (contact === NONE) {
        return undefined;
      }
      if (this.#partner(contact, slots[turn]) === slots[turn ^ 1]) {
        return contact;
      }
      contacts[turn] = this.#links[EACH * contact + NEXT + this.#side(contact, slots[turn])];
    }
  }

  *of(slot) {
    for (let contact = this.#first[slot] ?? NONE; contact !== NONE;) {
      const next = this.#links[EACH * contact + NEXT + this.#side(contact, slot)];
      yield [contact, this.#partner(contact, slot)];
      contact = next;
    }
  }

  removeAll(slot) {
    for (const [contact] of this.of(slot)) {
      this.#remove(contact);
    }
  }

  copy() {
    const copy = new Contacts();
    copy.restore(this);
    return copy;
  }

  restore(copy) {
    this.#first = copy.#first.slice();
    this.#links = copy.#links.slice();
    [this.#size, this.#used, this.#free] = [copy.#size, copy.#used, copy.#free];
  }

  #insert(a, b) {
    const links = this.#links;
    const contact = this.#free === NONE ? this.#used++ : this.#free;
    if (this.#free !== NONE) {
      this.#free = links[EACH * contact + NEXT];
    }
    this.#size += 1;
    [a, b].forEach((slot, side) => {
      const next = this.#first[slot];
      links[EACH * contact + side] = slot;
      links[EACH * contact + NEXT + side] = next;
      links[EACH * contact + BEFORE + side] = NONE;
      this.#lead(next, slot, BEFORE, contact);
      this.#first[slot] = contact;
    });
    return contact;
  }

  #remove(contact) {
    const links = this.#links;
    for (const side of [0, 1]) {
      const slot = links[EACH * contact + side];
      const next = links[EACH * contact + NEXT + side];
      const before = links[EACH * contact + BEFORE + side];
      this.#lead(next, slot, BEFORE, before);
      if (before === NONE) {
        this.#first[slot] = next;
      } else {
        this.#lead(before, slot, NEXT, next);
      }
    }
    links[EACH * contact + NEXT] = this.#free;
    this.#free = contact;
    this.#size -= 1;
  }

  /** Lets a contact of a slot, if it is one, lead to another. */
  #lead(from, slot, word, to) {
    if (from !== NONE) {
      this.#links[EACH * from + word + this.#side(from, slot)] = to;
    }
  }

  /** Which of the two objects a slot is. */
  #side(contact, slot) {
    return this.#links[EACH * contact + 1] === slot ? 1 : 0;
  }

  #partner(contact, slot) {
    return this.#links[EACH * contact + 1 - this.#side(contact, slot)];
  }
}

/** The words, in an array that has room for so many, twice as much as before where it has to grow. */
function grown(words, length) {
  if (length <= words.length) {
    return words;
  }
  const more = new Uint32Array(Math.max(length, 2 * words.length)).fill(NONE);
  more.set(words);
  return more;
}
