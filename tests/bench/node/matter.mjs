/** matter.js, with stiff constraints and as many iterations as its author advises for chains. */
import { readFileSync } from "node:fs";

import Matter from "matter-js";

const { Bodies, Body, Composite, Constraint, Engine: Core, Events } = Matter;
const { version } = JSON.parse(readFileSync("node_modules/matter-js/package.json", "utf8"));
const ITERATIONS = 60;
// A metre. Where lengths are about 1, a force at a point turns a body too little.
const PIXELS = 100;

export const about = {
  name: `matter-js ${version}`,
  settings: `${ITERATIONS} iterations; 0.4 stiff head only`,
  substep: 1 / 60,
};

/** The scene with lengths in pixels. */
function inPixels(scene) {
  const place = ([x, y, ...angle]) => [PIXELS * x, PIXELS * y, ...angle];
  const sizes = (values) => values.map((value) => PIXELS * value);
  return {
    ...scene,
    rail: PIXELS * scene.rail,
    lengths: sizes(scene.lengths),
    widths: sizes(scene.widths),
    spacings: sizes(scene.spacings),
    poses: scene.poses.map(place),
    velocities: scene.velocities.map(place),
    head: scene.head.map(place),
    anchors: scene.anchors.map((places) => places.map(place)),
  };
}

export class Engine {
  constructor(given) {
    const scene = inPixels(given);
    this.scene = scene;
    // Joints of a stiffness of 1 need four times the inertia.
    this.stiffness = scene.rail || !scene.drag ? 1 : 0.4;
    this.core = Core.create({
      constraintIterations: scene.iterations || ITERATIONS,
      gravity: { x: 0, y: 0 },
    });
    Events.on(this.core, "collisionStart", ({ pairs }) => {
      for (const pair of pairs) this.touched.push([pair.bodyA.number, pair.bodyB.number]);
    });
    const world = this.core.world;
    this.benches = scene.poses.map(([x, y, angle], index) => {
      // The drag is the share of the velocity that is lost in 1/60 s.
      const body = Bodies.rectangle(x, y, scene.lengths[index], scene.widths[index], {
        angle,
        density: scene.density,
        frictionAir: 1 - Math.exp(-scene.drag / 60),
        isSensor: true,
        number: index,
      });
      // A rectangle comes with four times the moment of inertia that it has, which matters where
      // the motion is not that of the rails.
      if (this.stiffness < 1) Body.setInertia(body, body.inertia / 4);
      const [u, v, spin] = scene.velocities[index];
      Body.setVelocity(body, { x: u / 60, y: v / 60 });
      Body.setAngularVelocity(body, spin / 60);
      if (!index) Body.setStatic(body, true);
      Composite.add(world, body);
      return body;
    });
    this.held = [];
    for (let index = 1; index < this.benches.length; index++) this.join(index);
  }

  /** Add the constraints of a bench. */
  join(index) {
    const { anchors, rail, spacings } = this.scene;
    const body = this.benches[index];
    const half = spacings[index] / 2;
    const front = {
      bodyB: body,
      pointB: this.turned(index, half),
      length: 0,
      stiffness: this.stiffness,
    };
    if (index === 1) {
      // Points of a static body do not turn with it.
      this.hinge = Constraint.create({ pointA: this.rearHole(0), ...front });
      Composite.add(this.core.world, this.hinge);
    } else {
      const bodyA = this.benches[index - 1];
      const pointA = this.turned(index - 1, -spacings[index - 1] / 2);
      Composite.add(this.core.world, Constraint.create({ bodyA, pointA, ...front }));
    }
    if (!anchors[0].length) return;
    const [x, y] = anchors[0][index - 1];
    const rear = this.turned(index, -half);
    const joint = {
      pointA: { x, y },
      bodyB: body,
      pointB: rear,
      length: rail,
      stiffness: this.stiffness,
    };
    this.held.push(Constraint.create(joint));
    Composite.add(this.core.world, this.held.at(-1));
  }

  /** The rear hole of the head at a number of its places. */
  rearHole(number) {
    const [x, y, angle] = this.scene.head[number];
    const half = this.scene.spacings[0] / 2;
    return { x: x - half * Math.cos(angle), y: y - half * Math.sin(angle) };
  }

  /** A point on the axis of a bench, from its centre, in the directions of the world. */
  turned(index, along) {
    const angle = this.scene.poses[index][2];
    return { x: along * Math.cos(angle), y: along * Math.sin(angle) };
  }

  move(number) {
    const [x, y, angle] = this.scene.head[number];
    Body.setPosition(this.benches[0], { x, y }, true);
    Body.setAngle(this.benches[0], angle, true);
    this.hinge.pointA = this.rearHole(number);
    this.held.forEach((joint, index) => {
      [joint.pointA.x, joint.pointA.y] = this.scene.anchors[number][index];
    });
  }

  step() {
    Core.update(this.core, 1000 * this.scene.step);
  }

  poses() {
    return this.benches.map(({ position, angle }) => [
      position.x / PIXELS,
      position.y / PIXELS,
      angle,
    ]);
  }
}
