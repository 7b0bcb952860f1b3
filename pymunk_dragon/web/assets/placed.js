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
  /** @type {(poses: Float64Array) => Call[]} */
  at(poses) {
    this.calls.forEach((call, k) => {
      const { points, angle: own } = this.own[k];
      const body = 3 * this.message.owners[k];
      const x = poses[body];
      const y = poses[body + 1];
      const angle = poses[body + 2];
      const cos = Math.cos(angle);
      const sin = Math.sin(angle);
      if (call.kind === "circle") call.angle = own + angle;
      for (let p = 0; p < points.length; p++) {
        const along = points[p][0];
        const across = points[p][1];
        call.points[p][0] = x + cos * along - sin * across;
        call.points[p][1] = y + sin * along + cos * across;
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
    return [...this.placed.at(frame.bodies), ...callsOf(frame)];
  }
}

// Whether two frames look the same: all but their clocks is equal.
/** @type {(one: LiveFrame, two: LiveFrame) => boolean} */
function looksAlike(one, two) {
  if (one.shapes !== two.shapes || one.numbers.length !== two.numbers.length) return false;
  if (one.numbers.some((number, k) => number !== two.numbers[k])) return false;
  const [before, after] = [one, two].map(
    ({ generation, sizes, focus, held, touching, colours, texts }) =>
      JSON.stringify([generation, sizes, focus, held, touching, colours, texts]),
  );
  return before === after;
}
