// The scene of a live session as view and painter need it: benches and their sizes, or what Pymunk
// draws of any space; and what there is to see in its frames.

// What the first message of the server replaces.
const NOTHING_YET = /** @type {any} */ (null);

class Model {
  /** @param {LiveScene} scene */
  constructor(scene) {
    const { dragon, view } = scene;
    this.scene = scene;
    this.field = view;
    this.free = !dragon;
    this.benches = dragon ? dragon.lengths.length : 0;
    /** @type {number[]} */
    this.lengths = dragon?.lengths ?? [];
    /** @type {number[]} */
    this.spacings = dragon?.spacings ?? [];
    this.widths = dragon?.widths ?? [];
    this.narrowest = Math.min(...this.widths);
    this.up = scene.y_down ? -1 : 1;
    this.hole = dragon?.hole ?? 0;
    /** @type {number[]} */
    this.curve = dragon?.curve ?? [];
    this.curveError = Math.max(dragon?.curve_error ?? 0, Number.EPSILON);
    /** @type {Grid | null} */
    this.grid = null;
    /** @type {NearMiss[]} */
    this.nearMisses = [];
    this.units = scene.units;
    this.unitOf = scene.unit_of; // of a force, torque, impulse, energy
  }

  // Whether the scene has something that others lack.
  /** @type {(ability: string | undefined) => boolean} */
  can(ability) {
    const dragon = this.benches > 0;
    /** @type {Record<string, boolean>} */
    const found = { dancers: dragon, contacts: dragon, exact: dragon, until_contact: !dragon };
    const pointer = this.scene.keys.includes("*");
    const { clicks } = this.scene;
    return { ...found, pointer, clicks, program: pointer || clicks }[ability ?? ""] ?? true;
  }

  // A length as text.
  /** @type {(value: number) => string} */
  lengthText(value) {
    return this.benches ? formatLength(value, 0) : roundLength(value, this.units);
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

  // The area that "whole field" shows: a dragon's own or a window, and otherwise what there is now.
  /** @type {(frame: LiveFrame) => Field} */
  wholeField({ calls }) {
    const fixed = this.benches > 0 || this.can("pointer");
    return (fixed ? null : extentOf(calls)) ?? this.field;
  }

  // What there is to see in a frame; exact benches not included.
  /** @type {(frame: LiveFrame, state: LiveState) => LiveMoment} */
  momentOf(frame, state) {
    const benches = new Benches(this, posesOf(frame.poses));
    return {
      time: frame.time,
      benches,
      inContact: new Set(frame.touching),
      freeFrom: state.free_from,
      calls: this.benches ? state.obstacles.map(obstacleCall) : frame.calls,
      texts: frame.texts ?? [],
      joints: this.joints(frame, benches, state.cuts),
      cuts: state.cuts,
      contacts: frame.contacts,
    };
  }

  // Exact benches, of which those with visible errors are drawn.
  /** @type {(frame: LiveFrame) => Ghosts} */
  ghostsOf({ exact, errors }) {
    return { benches: new Benches(this, posesOf(exact)), errors };
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

  // The joints of a frame with their two ends, without cut ones. Those of a dragon are the holes
  // that two benches share.
  /** @type {(frame: LiveFrame, benches: Benches<DrawnModel>, cuts: number[]) => Joint[]} */
  joints(frame, benches, cuts) {
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
    const { handles } = benches;
    /** @type {Joint[]} */
    const joints = efforts.map((joint, j) => ({
      ...joint,
      ends: [handles[j + 1], handles[j + 1]],
    }));
    return joints.filter(({ number }) => !cuts.includes(number));
  }
}
