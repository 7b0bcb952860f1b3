/** Rapier, with its default settings; it has no joint for rails. */
import RAPIER from "@dimforge/rapier2d-compat";

await RAPIER.init();

export const about = {
  name: `rapier2d ${RAPIER.version()}`,
  settings: "4 iterations",
  substep: 1 / 60,
  drives: ["head", "pinned"],
};

export class Engine {
  constructor(scene) {
    this.scene = scene;
    this.world = new RAPIER.World({ x: 0, y: 0 });
    this.world.timestep = scene.step;
    this.events = new RAPIER.EventQueue(true);
    this.numbers = new Map();
    this.benches = scene.poses.map((pose, index) => this.bench(pose, index));
    this.anchors = scene.anchors[0].map(([x, y]) => {
      const kinematic = RAPIER.RigidBodyDesc.kinematicPositionBased();
      return this.world.createRigidBody(kinematic.setTranslation(x, y));
    });
    for (let index = 1; index < this.benches.length; index++) this.join(index);
  }

  /** Add a bench. */
  bench([x, y, angle], index) {
    const [u, v, spin] = this.scene.velocities[index];
    const { drag, lengths, widths, density } = this.scene;
    const { dynamic, kinematicPositionBased } = RAPIER.RigidBodyDesc;
    const described = (index ? dynamic : kinematicPositionBased)()
      .setTranslation(x, y)
      .setRotation(angle)
      .setLinearDamping(drag)
      .setAngularDamping(drag)
      .setCanSleep(false);
    const body = this.world.createRigidBody(described);
    if (index) {
      body.setLinvel({ x: u, y: v }, true);
      body.setAngvel(spin, true);
    }
    const box = RAPIER.ColliderDesc.cuboid(lengths[index] / 2, widths[index] / 2)
      .setDensity(density)
      .setSolverGroups(0)
      .setActiveEvents(RAPIER.ActiveEvents.COLLISION_EVENTS);
    this.numbers.set(this.world.createCollider(box, body).handle, index);
    return body;
  }

  /** Add the joints of a bench. */
  join(index) {
    const { spacings } = this.scene;
    const body = this.benches[index];
    const point = (x) => ({ x, y: 0 });
    const half = spacings[index] / 2;
    const hinge = RAPIER.JointData.revolute(point(-spacings[index - 1] / 2), point(half));
    this.world
      .createImpulseJoint(hinge, this.benches[index - 1], body, true)
      .setContactsEnabled(false);
    const anchor = this.anchors[index - 1];
    if (!anchor) return;
    const pin = RAPIER.JointData.revolute(point(0), point(-half));
    this.world.createImpulseJoint(pin, anchor, body, true);
  }

  move(number) {
    const [x, y, angle] = this.scene.head[number];
    this.benches[0].setNextKinematicTranslation({ x, y });
    this.benches[0].setNextKinematicRotation(angle);
    this.anchors.forEach((anchor, index) => {
      const [x, y] = this.scene.anchors[number][index];
      anchor.setNextKinematicTranslation({ x, y });
    });
  }

  step() {
    this.world.step(this.events);
    this.events.drainCollisionEvents((first, second, started) => {
      if (started) this.touched.push([this.numbers.get(first), this.numbers.get(second)]);
    });
  }

  poses() {
    return this.benches.map((body) => {
      const { x, y } = body.translation();
      return [x, y, body.rotation()];
    });
  }
}
