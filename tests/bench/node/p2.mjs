/** p2-es, with numbers of 64 bits, and stiff equations as its author advises for chains. */
import { readFileSync } from "node:fs";

globalThis.P2_ARRAY_TYPE = Array;
const p2 = await import("p2-es");
const { version } = JSON.parse(readFileSync("node_modules/p2-es/package.json", "utf8"));

export const about = {
  name: `p2-es ${version}`,
  settings: "stiffness 1e9, 50 iterations",
  substep: 1 / 240,
};

export class Engine {
  constructor(scene) {
    this.scene = scene;
    this.world = new p2.World({ gravity: [0, 0] });
    this.world.solver.iterations = scene.iterations || 50;
    this.world.on("beginContact", ({ bodyA, bodyB }) => {
      this.touched.push([bodyA.number, bodyB.number]);
    });
    this.benches = scene.poses.map(([x, y, angle], index) => {
      const [u, v, spin] = scene.velocities[index];
      const [width, height] = [scene.lengths[index], scene.widths[index]];
      const share = 1 - Math.exp(-scene.drag);
      const body = new p2.Body({
        mass: index && scene.density * width * height,
        type: index ? p2.Body.DYNAMIC : p2.Body.KINEMATIC,
        position: [x, y],
        angle,
        velocity: [u, v],
        angularVelocity: spin,
        damping: share,
        angularDamping: share,
      });
      body.number = index;
      body.addShape(new p2.Box({ width, height, collisionResponse: false }));
      this.world.addBody(body);
      return body;
    });
    this.anchors = scene.anchors[0].map((position) => {
      const body = new p2.Body({ type: p2.Body.KINEMATIC, position });
      this.world.addBody(body);
      return body;
    });
    for (let index = 1; index < this.benches.length; index++) this.join(index);
    this.world.setGlobalStiffness(1e9);
  }

  /** Add the constraints of a bench. */
  join(index) {
    const { rail, spacings } = this.scene;
    const body = this.benches[index];
    const rear = [-spacings[index] / 2, 0];
    const ends = {
      localPivotA: [-spacings[index - 1] / 2, 0],
      localPivotB: [spacings[index] / 2, 0],
    };
    const hinge = { ...ends, collideConnected: false };
    this.world.addConstraint(new p2.RevoluteConstraint(this.benches[index - 1], body, hinge));
    const anchor = this.anchors[index - 1];
    if (!anchor) return;
    const held = rail
      ? new p2.DistanceConstraint(anchor, body, { distance: rail, localAnchorB: rear })
      : new p2.RevoluteConstraint(anchor, body, { localPivotA: [0, 0], localPivotB: rear });
    this.world.addConstraint(held);
  }

  move(number) {
    const { head, anchors, step } = this.scene;
    const body = this.benches[0];
    const [x, y, angle] = head[number];
    body.velocity = [(x - body.position[0]) / step, (y - body.position[1]) / step];
    body.angularVelocity = (angle - body.angle) / step;
    this.anchors.forEach((anchor, index) => {
      const [x, y] = anchors[number][index];
      anchor.velocity = [(x - anchor.position[0]) / step, (y - anchor.position[1]) / step];
    });
  }

  step() {
    this.world.step(this.scene.step);
  }

  poses() {
    return this.benches.map(({ position, angle }) => [...position, angle]);
  }
}
