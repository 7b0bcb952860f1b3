/** planck.js, a port of Box2D 2, with the numbers of iterations of its manual. */
import { readFileSync } from "node:fs";

import { Box, DistanceJoint, RevoluteJoint, World } from "planck";

const { version } = JSON.parse(readFileSync("node_modules/planck/package.json", "utf8"));

export const about = {
  name: `planck ${version}`,
  settings: "10 and 8 iterations",
  substep: 1 / 60,
};

export class Engine {
  constructor(scene) {
    this.scene = scene;
    this.world = new World({ gravity: { x: 0, y: 0 }, allowSleep: false });
    this.world.on("begin-contact", (contact) => {
      const bodies = [contact.getFixtureA().getBody(), contact.getFixtureB().getBody()];
      this.touched.push(bodies.map((body) => body.getUserData()));
    });
    this.world.on("pre-solve", (contact) => contact.setEnabled(false));
    this.benches = scene.poses.map(([x, y, angle], index) => {
      const [u, v, spin] = scene.velocities[index];
      const body = this.world.createBody({
        type: index ? "dynamic" : "kinematic",
        position: { x, y },
        angle,
        linearVelocity: { x: u, y: v },
        angularVelocity: spin,
        linearDamping: scene.drag,
        angularDamping: scene.drag,
        userData: index,
      });
      const box = new Box(scene.lengths[index] / 2, scene.widths[index] / 2);
      body.createFixture({ shape: box, density: scene.density });
      return body;
    });
    this.anchors = scene.anchors[0].map(([x, y]) =>
      this.world.createBody({ type: "kinematic", position: { x, y } }),
    );
    for (let index = 1; index < this.benches.length; index++) this.join(index);
  }

  /** Add the joints of a bench. */
  join(index) {
    const { spacings, rail } = this.scene;
    const body = this.benches[index];
    const half = spacings[index] / 2;
    const ends = {
      localAnchorA: { x: -spacings[index - 1] / 2, y: 0 },
      localAnchorB: { x: half, y: 0 },
    };
    this.world.createJoint(
      new RevoluteJoint({ bodyA: this.benches[index - 1], bodyB: body, ...ends }),
    );
    const bodyA = this.anchors[index - 1];
    if (!bodyA) return;
    const held = {
      bodyA,
      bodyB: body,
      localAnchorA: { x: 0, y: 0 },
      localAnchorB: { x: -half, y: 0 },
    };
    const joint = rail ? new DistanceJoint({ ...held, length: rail }) : new RevoluteJoint(held);
    this.world.createJoint(joint);
  }

  move(number) {
    const { head, anchors, step } = this.scene;
    const [x, y, angle] = head[number];
    const body = this.benches[0];
    const here = body.getPosition();
    body.setLinearVelocity({ x: (x - here.x) / step, y: (y - here.y) / step });
    body.setAngularVelocity((angle - body.getAngle()) / step);
    this.anchors.forEach((anchor, index) => {
      const [x, y] = anchors[number][index];
      const here = anchor.getPosition();
      anchor.setLinearVelocity({ x: (x - here.x) / step, y: (y - here.y) / step });
    });
  }

  step() {
    const iterations = this.scene.iterations || 10;
    this.world.step(this.scene.step, iterations, Math.ceil(0.8 * iterations));
  }

  poses() {
    return this.benches.map((body) => [
      body.getPosition().x,
      body.getPosition().y,
      body.getAngle(),
    ]);
  }
}
