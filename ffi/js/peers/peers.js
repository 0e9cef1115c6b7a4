// The peers under one interface: `step` is timed, and says how many pairs there are; `prepare` is not timed.

import RAPIER from "@dimforge/rapier3d-compat";
import boxIntersect from "box-intersect";
import { createWorld } from "trisap";
import { Sweep } from "./sweep.js";

async function trisap(simd, objects, pairs) {
  const world = await createWorld({ objects, pairs }, { simd });
  return {
    begin: (frame) => world.insertMany(frame),
    prepare: () => {},
    // The copy into the world's memory counts, though a program of one's own would compute its boxes there.
    step(frame) {
      world.boxes.set(frame);
      return world.step().pairs.length / 2;
    },
  };
}

function sweep(objects) {
  const own = new Sweep(objects);
  return { begin: (frame) => own.begin(frame), prepare: () => {}, step: (frame) => own.step(frame) };
}

/** A list of lists is what it takes; pairs go to a typed array by its visitor, which is faster than its list of lists. */
function boxIntersectPeer(objects, room) {
  const boxes = Array.from({ length: objects }, () => [0, 0, 0, 0, 0, 0]);
  const pairs = new Uint32Array(2 * room);
  let count = 0;
  const visit = (a, b) => {
    pairs[2 * count] = a;
    pairs[2 * count + 1] = b;
    count++;
  };
  return {
    begin: () => {},
    prepare(frame) {
      boxes.forEach((box, i) => {
        for (let k = 0; k < 6; k++) {
          box[k] = frame[6 * i + k];
        }
      });
    },
    step() {
      count = 0;
      boxIntersect(boxes, visit);
      return count;
    },
  };
}

/**
 * Its broad phase is not to be had alone: a step of a world of sensors on kinematic bodies, which tells the time of its broad phase
 * itself. Setting the boxes and asking for the pairs are not timed.
 */
function rapier(objects) {
  const world = new RAPIER.World({ x: 0, y: 0, z: 0 });
  world.profilerEnabled = true;
  const sensor = RAPIER.ColliderDesc.cuboid(1, 1, 1).setSensor(true).setActiveCollisionTypes(RAPIER.ActiveCollisionTypes.ALL);
  const bodies = Array.from({ length: objects }, () => world.createRigidBody(RAPIER.RigidBodyDesc.kinematicPositionBased()));
  const colliders = bodies.map((body) => world.createCollider(sensor, body));
  const set = (frame) =>
    colliders.forEach((collider, i) => {
      const at = (k) => frame[6 * i + k];
      collider.setHalfExtents({ x: (at(3) - at(0)) / 2, y: (at(4) - at(1)) / 2, z: (at(5) - at(2)) / 2 });
      bodies[i].setTranslation({ x: (at(3) + at(0)) / 2, y: (at(4) + at(1)) / 2, z: (at(5) + at(2)) / 2 }, true);
    });
  return {
    begin: set,
    prepare: set,
    step() {
      world.step();
      return null;
    },
    /** What it says itself, in milliseconds. */
    own: () => world.timingBroadPhase(),
    count() {
      let count = 0;
      colliders.forEach((collider) => world.intersectionPairsWith(collider, () => count++));
      return count / 2;
    },
  };
}

export async function peers(objects, pairs) {
  await RAPIER.init();
  return {
    "trisap, simd128": await trisap(true, objects, pairs),
    "trisap, scalar": await trisap(false, objects, pairs),
    "box-intersect": boxIntersectPeer(objects, pairs),
    "sweep in JavaScript": sweep(objects),
    "rapier3d, whole step": rapier(objects),
  };
}
