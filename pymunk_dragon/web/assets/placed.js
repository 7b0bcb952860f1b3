// Shapes that move with bodies: a page gets them once, and then only the poses of the bodies.

/** @type {ShapesFrame} */
const NO_SHAPES = { calls: new Float64Array(), owners: new Float64Array() };

class PlacedShapes {
  // The calls of the message are in the coordinates of the bodies that own them.
  /** @param {ShapesFrame} message */
  constructor(message) {
    this.message = message;
    this.own = callsOf(message);
    this.calls = callsOf(message);
  }

  // The calls where the bodies are now; those of the last picture are moved.
  /** @type {(poses: Poses) => Call[]} */
  at({ x, y, angle, cos, sin }) {
    this.calls.forEach((call, k) => {
      const { points, angle: own } = this.own[k];
      const body = this.message.owners[k];
      if (call.kind === "circle") call.angle = own + angle[body];
      for (let p = 0; p < points.length; p++) {
        const [along, across] = points[p];
        call.points[p][0] = x[body] + cos[body] * along - sin[body] * across;
        call.points[p][1] = y[body] + sin[body] * along + cos[body] * across;
      }
    });
    return this.calls;
  }
}

// Decodes the frames of a connection, and the shapes that come before those that need them.
class Frames {
  constructor() {
    this.shapes = NO_SHAPES;
    this.placed = new PlacedShapes(NO_SHAPES);
  }

  // A frame without its calls; null for shapes.
  /** @type {(buffer: ArrayBuffer) => LiveFrame | null} */
  decode(buffer) {
    const found = decodeFrame(buffer);
    if (!found.owners) return { ...found, shapes: this.shapes };
    this.shapes = found;
    return null;
  }

  // What Pymunk draws in a frame; a dragon has nothing of it.
  /** @type {(frame: LiveFrame) => Call[]} */
  callsOf(frame) {
    if (!frame.bodies.length) return [];
    if (this.placed.message !== frame.shapes) this.placed = new PlacedShapes(frame.shapes);
    return [...this.placed.at(posesOf(frame.bodies)), ...callsOf(frame)];
  }
}
