// Sort and sweep along one axis in plain JavaScript, as well as it can be written: typed arrays, the order kept from step to
// step, the bounds copied in that order, so that the inner loop reads memory from front to back.

export class Sweep {
  constructor(count) {
    this.order = Uint32Array.from({ length: count }, (_, i) => i);
    this.low = new Float32Array(count);
    this.high = new Float32Array(count);
    this.rest = new Float32Array(4 * count);
    this.pairs = new Uint32Array(1024);
    this.count = 0;
    this.axis = 0;
  }

  /** Takes the axis on which the boxes are spread most, once. */
  begin(boxes) {
    const spread = [0, 1, 2].map((axis) => {
      let [sum, squares] = [0, 0];
      for (let i = axis; i < boxes.length; i += 6) {
        const middle = (boxes[i] + boxes[i + 3]) / 2;
        sum += middle;
        squares += middle * middle;
      }
      return squares - (sum * sum * 6) / boxes.length;
    });
    this.axis = spread.indexOf(Math.max(...spread));
    this.order.sort((a, b) => boxes[6 * a + this.axis] - boxes[6 * b + this.axis]);
  }

  step(boxes) {
    const { order, low, high, rest, axis } = this;
    const count = order.length;
    const [second, third] = [(axis + 1) % 3, (axis + 2) % 3];
    // Nearly sorted from the step before.
    for (let i = 0; i < count; i++) {
      const object = order[i];
      const key = boxes[6 * object + axis];
      let at = i;
      while (at > 0 && low[at - 1] > key) {
        low[at] = low[at - 1];
        order[at] = order[at - 1];
        at--;
      }
      low[at] = key;
      order[at] = object;
    }
    for (let i = 0; i < count; i++) {
      const from = 6 * order[i];
      high[i] = boxes[from + axis + 3];
      rest[4 * i] = boxes[from + second];
      rest[4 * i + 1] = boxes[from + second + 3];
      rest[4 * i + 2] = boxes[from + third];
      rest[4 * i + 3] = boxes[from + third + 3];
    }
    let found = 0;
    for (let i = 0; i < count; i++) {
      const end = high[i];
      const [low2, high2, low3, high3] = [rest[4 * i], rest[4 * i + 1], rest[4 * i + 2], rest[4 * i + 3]];
      for (let j = i + 1; j < count && low[j] <= end; j++) {
        const at = 4 * j;
        if (rest[at] <= high2 && rest[at + 1] >= low2 && rest[at + 2] <= high3 && rest[at + 3] >= low3) {
          if (2 * found + 2 > this.pairs.length) {
            const more = new Uint32Array(2 * this.pairs.length);
            more.set(this.pairs);
            this.pairs = more;
          }
          this.pairs[2 * found] = order[i];
          this.pairs[2 * found + 1] = order[j];
          found++;
        }
      }
    }
    this.count = found;
    return found;
  }
}
