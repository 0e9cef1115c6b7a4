// What the tests compare with: every two boxes.

/** A world of numbers that are the same on every machine. */
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** The boxes of so many objects in a cube. Some are large, and some touch. */
export function scatter(count, next, edge = 10) {
  const boxes = new Float32Array(6 * count);
  for (let i = 0; i < count; i++) {
    const size = next() < 0.02 ? 4 : 0.2 + next() * 0.6;
    for (let axis = 0; axis < 3; axis++) {
      // On a coarse grid, so that faces meet.
      const low = Math.round(next() * edge * 4) / 4;
      boxes[6 * i + axis] = low;
      boxes[6 * i + 3 + axis] = low + Math.round(size * 4) / 4;
    }
  }
  return boxes;
}

/** Moves every box by some quarters. */
export function move(boxes, next, share = 1) {
  for (let i = 0; i < boxes.length / 6; i++) {
    if (next() >= share) {
      continue;
    }
    for (let axis = 0; axis < 3; axis++) {
      const by = Math.round(next() * 4 - 2) / 4;
      boxes[6 * i + axis] += by;
      boxes[6 * i + 3 + axis] += by;
    }
  }
}

export function overlap(boxes, a, b) {
  for (let axis = 0; axis < 3; axis++) {
    if (boxes[6 * a + axis] > boxes[6 * b + 3 + axis] || boxes[6 * b + axis] > boxes[6 * a + 3 + axis]) {
      return false;
    }
  }
  return true;
}

/** All pairs of the slots that live, as sorted texts. */
export function bruteForce(boxes, lives = () => true, meet = () => true) {
  const pairs = [];
  for (let a = 0; a < boxes.length / 6; a++) {
    for (let b = a + 1; lives(a) && b < boxes.length / 6; b++) {
      if (lives(b) && overlap(boxes, a, b) && meet(a, b)) {
        pairs.push(`${a} ${b}`);
      }
    }
  }
  return pairs.sort();
}

/** The pairs of a view, as sorted texts. A pair that comes twice stays twice. */
export function texts(pairs) {
  const all = [];
  for (let i = 0; i < pairs.length; i += 2) {
    all.push(`${pairs[i]} ${pairs[i + 1]}`);
  }
  return all.sort();
}

/** Those of one list that another one does not have. */
export function without(some, others) {
  const known = new Set(others);
  return some.filter((pair) => !known.has(pair));
}
