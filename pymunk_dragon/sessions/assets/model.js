// The scene as the view and the painter need it: benches and their sizes,
// or what Pymunk draws of any space.

class Model {
  /** @param {LiveScene} scene */
  constructor(scene) {
    const { dragon, field } = scene;
    this.scene = scene;
    this.field = field;
    this.benches = dragon ? dragon.lengths.length : 0;
    /** @type {number[]} */
    this.lengths = dragon?.lengths ?? [];
    /** @type {number[]} */
    this.spacings = dragon?.spacings ?? [];
    const side = Math.min(...field.size);
    this.widths = dragon?.widths ?? [side / 20];
    this.narrowest = dragon
      ? Math.min(...this.widths)
      : Math.max(side, Math.max(...field.size) / 10) / 50;
    this.up = scene.y_down ? -1 : 1;
    this.units = scene.units;
    this.unitOf = scene.unit_of; // of a force, torque, impulse, energy
  }

  // Whether the scene has something that others lack.
  /** @type {(ability: string | undefined) => boolean} */
  can(ability) {
    const dragon = this.benches > 0;
    /** @type {Record<string, boolean>} */
    const found = { dancers: dragon, contacts: dragon, ghost: dragon, until_contact: !dragon };
    return { ...found, pointer: this.scene.keys.includes("*") }[ability ?? ""] ?? true;
  }

  // A length as text.
  /** @type {(value: number) => string} */
  lengthText(value) {
    return this.units === "m"
      ? formatLength(value, 0)
      : `${Number(value.toPrecision(3))} ${this.units}`;
  }

  // The force or torque in a joint as text.
  /** @type {(joint: Effort) => string} */
  effortText({ kind, effort }) {
    if (!(effort >= 0)) return "–";
    if (this.units === "m" && effort >= 1000) {
      return `${(effort / 1000).toFixed(1)} k${this.unitOf[kind]}`;
    }
    return `${numberText(effort)} ${this.unitOf[kind]}`;
  }

  // What a hand takes at a point, as the server does: a bench, or the shape with the best grip that
  // is drawn last there, or else the nearest within `slip`; and its point closest to that point.
  // Null if there is none.
  /**
   * @type {(
   *   point: Numbers,
   *   slip: number,
   *   frame: LiveFrame,
   *   poses: Poses,
   * ) => (Target & { point: Numbers }) | null}
   */
  bodyAt(point, slip, { calls }, poses) {
    if (this.benches) {
      const benches = new Benches(this, poses);
      const bench = benches.at(point, slip);
      return bench === null ? null : { bench, ...benches.nearestPoint(bench, point) };
    }
    const near = calls
      .filter(({ grip }) => grip > 0)
      .map((call) => ({ call, ...nearestOnShape(call, point) }))
      .filter(({ distance }) => distance <= slip)
      .reverse();
    const best = Math.max(...near.map(({ call }) => call.grip));
    return nearestWithin(
      slip,
      near.filter(({ call }) => call.grip === best),
      ({ distance }) => distance,
    );
  }

  // Number and effort of each joint of a frame. The kind of an effort is "force" or "torque";
  // a step of 0 s has none.
  /** @type {(frame: LiveFrame) => Effort[]} */
  efforts({ joints, forces }) {
    if (this.benches) {
      return Array.from(forces, (effort, number) => ({ number, effort, kind: "force" }));
    }
    return Array.from(rowsOf(joints, JOINT_SIZE), ([, , , , effort, rotary], number) => ({
      number,
      effort,
      kind: rotary ? "torque" : "force",
    }));
  }

  // The same with the two ends of each joint. Those of a
  // dragon are the holes that two benches share.
  /** @type {(frame: LiveFrame, poses: Poses, cuts: number[]) => Joint[]} */
  joints(frame, poses, cuts) {
    const efforts = this.efforts(frame);
    if (!this.benches) {
      const rows = [...rowsOf(frame.joints, JOINT_SIZE)];
      return efforts.map((joint, j) => ({
        ...joint,
        ends: [
          [rows[j][0], rows[j][1]],
          [rows[j][2], rows[j][3]],
        ],
      }));
    }
    const { handles } = new Benches(this, poses);
    /** @type {Joint[]} */
    const joints = efforts.map((joint, j) => ({
      ...joint,
      ends: [handles[j + 1], handles[j + 1]],
    }));
    return joints.filter(({ number }) => !cuts.includes(number));
  }

  // The joint whose line passes within `slip` of a point; null if there is none.
  /** @type {(point: Numbers, slip: number, joints: Joint[]) => Joint | null} */
  jointAt(point, slip, joints) {
    return nearestWithin(slip, joints, ({ ends }) => nearestOnSegment(...ends, point).distance);
  }
}

// ---- distances of points from drawn shapes, in the units of the space

/** @type {(one: Numbers, two: Numbers, point: Numbers) => { point: Point, distance: number }} */
function nearestOnSegment([ax, ay], [bx, by], [px, py]) {
  const dx = bx - ax;
  const dy = by - ay;
  const share = Math.min(
    Math.max(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1), 0),
    1,
  );
  /** @type {Point} */
  const point = [ax + share * dx, ay + share * dy];
  return { point, distance: Math.hypot(px - point[0], py - point[1]) };
}

// Whether a point is inside a convex polygon, whose corners may have either direction.
/** @type {(corners: Point[], point: Numbers) => boolean} */
function isInside(corners, [px, py]) {
  const signs = corners.map(([ax, ay], i) => {
    const [bx, by] = corners[(i + 1) % corners.length];
    return Math.sign((bx - ax) * (py - ay) - (by - ay) * (px - ax));
  });
  return corners.length > 2 && !(signs.includes(1) && signs.includes(-1));
}

// Point of a shape that is closest to a point, and the distance; 0 within the shape.
/**
 * @type {(
 *   shape: { points: Point[], radius: number },
 *   given: Numbers,
 * ) => { point: Numbers, distance: number }}
 */
function nearestOnShape({ points, radius }, given) {
  if (isInside(points, given)) return { point: given, distance: 0 };
  const sides = points.map((corner, i) =>
    nearestOnSegment(corner, points[(i + 1) % points.length], given),
  );
  const { point, distance } = sides.reduce((one, two) => (two.distance < one.distance ? two : one));
  if (distance <= radius) return { point: given, distance: 0 };
  /** @type {(value: number, axis: number) => number} */
  const shift = (value, axis) => value + (radius / distance) * (given[axis] - value);
  return { point: point.map(shift), distance: distance - radius };
}
