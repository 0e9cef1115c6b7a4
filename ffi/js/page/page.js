// Boxes that drift over a plane, as many as the slider says. Whoever overlaps another one is lit.

import { createWorld } from "../src/web.js";

const canvas = document.querySelector("#canvas");
const slider = document.querySelector("#number");
const paper = canvas.getContext("2d");
const { width, height } = canvas;
/** Of the canvas, what boxes cover. */
const COVERED = 0.12;
const STEPS_SHOWN = 60;
const simd = new URLSearchParams(location.search).has("scalar") ? false : undefined;

/** What runs now. Tests read it. */
export const scene = { world: null, count: 0, frames: 0 };

let speeds = new Float32Array(0);
let times = [];

/** A world of so many boxes; together they always cover as much. */
async function begin(count) {
  // On a plane there are few pairs more than boxes; clusters may have some.
  const world = await createWorld({ objects: count, pairs: 16 * count, events: true }, { simd });
  if (count !== Number(slider.value)) {
    // The slider has moved on in the meantime.
    return;
  }
  const edge = Math.sqrt((COVERED * width * height) / count);
  const boxes = new Float32Array(6 * count);
  speeds = new Float32Array(2 * count);
  for (let i = 0; i < count; i++) {
    const [wide, high] = [edge * (0.5 + Math.random()), edge * (0.5 + Math.random())];
    const [x, y] = [Math.random() * (width - wide), Math.random() * (height - high)];
    boxes.set([x, y, 0, x + wide, y + high, 1], 6 * i);
    const angle = Math.random() * 2 * Math.PI;
    speeds.set([Math.cos(angle) * 0.06 * edge, Math.sin(angle) * 0.06 * edge], 2 * i);
  }
  world.insertMany(boxes);
  times = [];
  Object.assign(scene, { world, count });
}

/** Moves the boxes where they stand, in the memory of the world. */
function move({ boxes }, count) {
  for (let i = 0; i < count; i++) {
    for (let axis = 0; axis < 2; axis++) {
      const [low, high] = [6 * i + axis, 6 * i + 3 + axis];
      if (boxes[low] < 0 || boxes[high] > (axis === 0 ? width : height)) {
        speeds[2 * i + axis] = Math.abs(speeds[2 * i + axis]) * (boxes[low] < 0 ? 1 : -1);
      }
      boxes[low] += speeds[2 * i + axis];
      boxes[high] += speeds[2 * i + axis];
    }
  }
}

function draw({ boxes, pairs }, count) {
  const lit = new Uint8Array(count);
  for (const slot of pairs) {
    lit[slot] = 1;
  }
  paper.clearRect(0, 0, width, height);
  for (const [state, colour] of [[0, "#3d6fa8"], [1, "#ff9f3f"]]) {
    paper.fillStyle = colour;
    for (let i = 0; i < count; i++) {
      if (lit[i] === state) {
        const at = 6 * i;
        paper.fillRect(boxes[at], boxes[at + 1], boxes[at + 3] - boxes[at], boxes[at + 4] - boxes[at + 1]);
      }
    }
  }
  // The overlaps themselves.
  paper.fillStyle = "#fff3d6";
  for (let i = 0; i < pairs.length; i += 2) {
    const [a, b] = [6 * pairs[i], 6 * pairs[i + 1]];
    const [x, y] = [Math.max(boxes[a], boxes[b]), Math.max(boxes[a + 1], boxes[b + 1])];
    paper.fillRect(x, y, Math.min(boxes[a + 3], boxes[b + 3]) - x, Math.min(boxes[a + 4], boxes[b + 4]) - y);
  }
}

function show({ pairs, found, lost, variant }, count) {
  const say = (name, value) => {
    document.querySelector(`#${name}`).textContent = value;
  };
  say("boxes", count);
  // The mean: clocks of browsers are coarse.
  say("time", (times.reduce((sum, time) => sum + time, 0) / times.length).toFixed(2));
  say("pairs", pairs.length / 2);
  say("found", found.length / 2);
  say("lost", lost.length / 2);
  say("variant", variant);
}

function frame() {
  const { world, count } = scene;
  if (world !== null) {
    move(world, count);
    const start = performance.now();
    world.step();
    times.push(performance.now() - start);
    times.splice(0, times.length - STEPS_SHOWN);
    draw(world, count);
    show(world, count);
    scene.frames++;
  }
  requestAnimationFrame(frame);
}

slider.addEventListener("input", () => begin(Number(slider.value)));
await begin(Number(slider.value));
frame();
