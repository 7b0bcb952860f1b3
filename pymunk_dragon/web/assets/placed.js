// Shapes that move with bodies: a page gets them once, and then only the poses of the bodies.

/** @type {ShapesFrame} */
const NO_SHAPES = { calls: new Float32Array(), owners: new Float32Array() };

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
