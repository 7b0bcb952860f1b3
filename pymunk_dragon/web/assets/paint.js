// Draws the benches and the curve. Many benches share a path,
// because drawing a path costs more than extending it.

const CURVE_WIDTH = 0.04; // width of the curve over that of a bench, as in the films
const THINNEST_CURVE = 1; // pixels
const CURVE_ERROR_SHOWN = 0.3; // pixels: largest error of the drawn curve
const SMALLEST_HOLE = 2.5; // pixels: smallest hole that is drawn
const OUTLINE_WIDTH = 0.06; // width of outlines over that of a bench
const THINNEST_OUTLINE = 0.5; // pixels
const HEAD_BORDER = 3; // times: border of the head in contact
const THICKEST_OUTLINE = 1.25; // pixels

/** @template {DrawnBenches} [M=any] */
class Painter {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {M} motion
   * @param {View} view
   * @param {Payload} payload
   * @param {ArrayLike<number>} curve
   */
  constructor(canvas, motion, view, payload, curve) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (
      canvas.getContext("2d", { alpha: false })
    );
    this.motion = motion;
    this.view = view;
    this.payload = payload;
    this.curve = curve; // in m: x0, y0, x1, y1, ...
    this.curveError = payload.curve_error;
    this.colours = readColours();
    this.font = fontOf(document.body);
  }

  readColours() {
    this.colours = readColours();
    this.font = fontOf(document.body);
  }

  resize() {
    Object.assign(this.view, fitCanvas(this.canvas, this.context));
  }

  clear() {
    const { context, view, colours } = this;
    context.fillStyle = colours.background;
    context.fillRect(0, 0, view.width, view.height);
    context.lineJoin = context.lineCap = "round";
  }

  // Numbers of the benches in the view, from the tail to the head.
  /** @type {(benches: { poses: Poses }) => number[]} */
  visible({ poses: { x, y } }) {
    const { view, motion } = this;
    const found = [];
    for (let i = motion.benches - 1; i >= 0; i--) {
      if (view.isVisible(x[i], y[i], motion.lengths[i])) found.push(i);
    }
    return found;
  }

  drawCurve() {
    const { context, view, curve } = this;
    // The error of a chord over n intervals is n^2 times that over one.
    const stride = Math.max(
      1,
      Math.floor(Math.sqrt(CURVE_ERROR_SHOWN / (view.scale * this.curveError))),
    );
    const path = new Path2D();
    const last = curve.length / 2 - 1;
    /** @type {number | null} */
    let drawn = null; // the point up to which the curve is drawn
    for (let from = 0; from < last; from += stride) {
      const to = Math.min(from + stride, last);
      const x = curve[2 * from];
      const y = curve[2 * from + 1];
      const nextX = curve[2 * to];
      const nextY = curve[2 * to + 1];
      if (!view.isVisible(x, y, Math.hypot(nextX - x, nextY - y))) continue;
      if (drawn !== from) path.moveTo(...view.toScreen(x, y));
      path.lineTo(...view.toScreen(nextX, nextY));
      drawn = to;
    }
    const width = Math.max(THINNEST_CURVE, CURVE_WIDTH * this.motion.narrowest * view.scale);
    strokeOnce(context, path, this.colours.curve, width);
  }

  /** @type {(path: Path2D, benches: Benches<DrawnBenches>, i: number) => void} */
  outline(path, benches, i) {
    const [first, ...rest] = benches.corners(i);
    path.moveTo(...this.view.toScreen(...first));
    for (const corner of rest) path.lineTo(...this.view.toScreen(...corner));
    path.closePath();
  }

  /** @type {(benches: Benches<DrawnBenches>, visible: number[], inContact: Set<number>) => void} */
  drawBenches(benches, visible, inContact) {
    const { context, colours, motion, view } = this;
    const tail = motion.benches - 1;
    /** @type {(i: number) => boolean} */
    const special = (i) => i === 0 || i === tail || inContact.has(i);
    const thin = Math.min(
      Math.max(OUTLINE_WIDTH * motion.narrowest * view.scale, THINNEST_OUTLINE),
      THICKEST_OUTLINE,
    );
    /** @type {(chosen: number[], border?: string, width?: number) => void} */
    const paint = (chosen, border = colours.ink, width = thin) => {
      if (!chosen.length) return;
      const path = new Path2D();
      for (const i of chosen) this.outline(path, benches, i);
      context.fillStyle = this.colourOf(chosen[0], inContact);
      context.fill(path);
      strokeOnce(context, path, border, width);
    };
    // Only neighbours overlap, so even benches share a path, and odd ones are drawn on top of them.
    for (const parity of [0, 1]) paint(visible.filter((i) => i % 2 === parity && !special(i)));
    for (const i of visible.filter(special)) {
      if (i === 0 && inContact.has(0)) paint([0], colours.contact, HEAD_BORDER * thin);
      else paint([i]);
    }
    const radius = (this.payload.dragon.hole / 2) * view.scale;
    if (2 * radius >= SMALLEST_HOLE) this.drawHoles(benches, visible, radius, colours.ink);
  }

  /**
   * @type {(
   *   benches: Benches<DrawnBenches>,
   *   visible: number[],
   *   radius: number,
   *   colour: string,
   * ) => Path2D}
   */
  drawHoles(benches, visible, radius, colour) {
    const { context, view } = this;
    const path = new Path2D();
    for (const handle of new Set(visible.flatMap((i) => [i, i + 1]))) {
      const [px, py] = view.toScreen(...benches.handles[handle]);
      path.moveTo(px + radius, py);
      path.arc(px, py, radius, 0, TURN);
    }
    context.fillStyle = colour;
    context.fill(path);
    return path;
  }

  // The highlighted bench is drawn on top, with an outline.
  /** @type {(benches: Benches<DrawnBenches>, i: number, inContact: Set<number>) => void} */
  drawPointed(benches, i, inContact) {
    const { context, colours } = this;
    const path = new Path2D();
    this.outline(path, benches, i);
    strokeTwice(context, path, colours.background, colours.text, 5, 2);
    context.fillStyle = this.colourOf(i, inContact);
    context.fill(path);
    this.drawHoles(benches, [i], (this.payload.dragon.hole / 2) * this.view.scale, colours.ink);
  }

  // The head keeps its colour in contact, and gets a border in the colour of the contact.
  /** @type {(i: number, inContact: Set<number>) => string} */
  colourOf(i, inContact) {
    const { contact, head, tail, body } = this.colours;
    return i === 0
      ? head
      : inContact.has(i)
        ? contact
        : i === this.motion.benches - 1
          ? tail
          : body;
  }

  /**
   * @type {(
   *   font: string,
   *   textAlign: CanvasTextAlign,
   *   textBaseline: CanvasTextBaseline,
   * ) => void}
   */
  setFont(font, textAlign, textBaseline) {
    Object.assign(this.context, { font: `${font} ${this.font}`, textAlign, textBaseline });
  }

  // Text with a rim of the background's colour.
  /** @type {(text: string, px: number, py: number) => void} */
  drawText(text, px, py) {
    const { context, colours } = this;
    context.strokeStyle = colours.background;
    context.lineWidth = 4;
    context.strokeText(text, px, py);
    context.fillStyle = colours.text;
    context.fillText(text, px, py);
  }
}

// A line with a rim of the background's colour.
/**
 * @type {(
 *   context: CanvasRenderingContext2D,
 *   path: Path2D,
 *   rim: string,
 *   colour: string,
 *   width: number,
 *   rimWidth?: number,
 * ) => void}
 */
function strokeTwice(context, path, rim, colour, width, rimWidth = 1) {
  strokeOnce(context, path, rim, width + 2 * rimWidth);
  strokeOnce(context, path, colour, width);
}

/**
 * @type {(
 *   context: CanvasRenderingContext2D,
 *   path: Path2D,
 *   colour: string,
 *   width: number,
 * ) => void}
 */
function strokeOnce(context, path, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke(path);
}
