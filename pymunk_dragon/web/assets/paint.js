// Draws a moment of a run or of a live session: the benches, the curve, and what is chosen to be
// seen with them. Many benches share a path, because drawing a path costs more than extending it.

const CURVE_WIDTH = 0.04; // width of the curve over that of a bench, as in the films
const THINNEST_CURVE = 1; // pixels
const CURVE_ERROR_SHOWN = 0.3; // pixels: largest error of the drawn curve
const SMALLEST_HOLE = 2.5; // pixels: smallest hole that is drawn
const OUTLINE_WIDTH = 0.06; // width of outlines over that of a bench
const THINNEST_OUTLINE = 0.5; // pixels
const HEAD_BORDER = 3; // times: border of the head in contact
const THICKEST_OUTLINE = 1.25; // pixels
const PALE = 0.55; // weight of the background in the colour of benches whose dancers let go

// Draws pictures of a model, the dragon of a recording or the scene of a live session, in layers:
// each draws a part of the picture on those before it.
/** @template {Picture} [P=any] */
class Painter {
  /**
   * @param {Surface} surface
   * @param {View} view
   * @param {DrawnModel} model
   * @param {Layer<P>[]} layers
   */
  constructor(surface, view, model, layers) {
    this.surface = surface;
    this.view = view;
    this.model = model;
    this.layers = layers;
  }

  get context() {
    return this.surface.context;
  }

  get colours() {
    return this.surface.colours;
  }

  get font() {
    return this.surface.font;
  }

  /** @type {(picture: P) => void} */
  draw(picture) {
    const visible = this.visible(picture.benches);
    this.surface.clear();
    this.context.lineCap = "round";
    for (const layer of this.layers) layer(this, picture, visible);
  }

  // Numbers of the benches in the view, from the tail to the head.
  /** @type {(benches: { poses: Poses }) => number[]} */
  visible({ poses: { x, y } }) {
    const { view, model } = this;
    const found = [];
    for (let i = model.benches - 1; i >= 0; i--) {
      if (view.isVisible(x[i], y[i], model.lengths[i])) found.push(i);
    }
    return found;
  }

  /** @type {(path: Path2D, benches: Benches<DrawnModel>, i: number) => void} */
  outline(path, benches, i) {
    addPolygon(path, this.view, benches.corners(i));
  }

  /**
   * @type {(
   *   benches: Benches<DrawnModel>,
   *   visible: number[],
   *   inContact: Set<number>,
   *   pale?: boolean,
   * ) => void}
   */
  drawBenches(benches, visible, inContact, pale = false) {
    const { context, colours, model, view } = this;
    const tail = model.benches - 1;
    /** @type {(i: number) => boolean} */
    const special = (i) => i === 0 || i === tail || inContact.has(i);
    const thin = Math.min(
      Math.max(OUTLINE_WIDTH * model.narrowest * view.scale, THINNEST_OUTLINE),
      THICKEST_OUTLINE,
    );
    /** @type {(chosen: number[], border?: string, width?: number) => void} */
    const paint = (chosen, border = colours.ink, width = thin) => {
      if (!chosen.length) return;
      const path = new Path2D();
      for (const i of chosen) this.outline(path, benches, i);
      context.fillStyle = this.colourOf(chosen[0], inContact, pale);
      context.fill(path);
      strokeOnce(context, path, border, width);
    };
    // Only neighbours overlap, so even benches share a path, and odd ones are drawn on top of them.
    for (const parity of [0, 1]) paint(visible.filter((i) => i % 2 === parity && !special(i)));
    for (const i of visible.filter(special)) {
      if (i === 0 && inContact.has(0)) paint([0], colours.contact, HEAD_BORDER * thin);
      else paint([i]);
    }
    const radius = (this.model.hole / 2) * view.scale;
    if (2 * radius >= SMALLEST_HOLE) this.drawHoles(benches, visible, radius, colours.ink);
  }

  /**
   * @type {(
   *   benches: Benches<DrawnModel>,
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
  /** @type {(benches: Benches<DrawnModel>, i: number, inContact: Set<number>) => void} */
  drawPointed(benches, i, inContact) {
    const { context, colours } = this;
    const path = new Path2D();
    this.outline(path, benches, i);
    strokeTwice(context, path, colours.background, colours.text, 5, 2);
    context.fillStyle = this.colourOf(i, inContact);
    context.fill(path);
    this.drawHoles(benches, [i], (this.model.hole / 2) * this.view.scale, colours.ink);
  }

  // The head keeps its colour in contact, and gets a border in the colour of the contact.
  /** @type {(i: number, inContact: Set<number>, pale?: boolean) => string} */
  colourOf(i, inContact, pale = false) {
    const { contact, head, tail, body, background } = this.colours;
    let colour = body;
    if (i === this.model.benches - 1) colour = tail;
    if (inContact.has(i)) colour = contact;
    if (i === 0) colour = head;
    return pale ? mixed(colour, background, PALE) : colour;
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

// ---- the first layers

/** @type {(painter: Painter, picture: Picture) => void} */
function drawCurve(painter, { show }) {
  if (!show.curve) return;
  const { context, view, model } = painter;
  const { curve } = model;
  // The error of a chord over n intervals is n^2 times that over one.
  const stride = Math.max(
    1,
    Math.floor(Math.sqrt(CURVE_ERROR_SHOWN / (view.scale * model.curveError))),
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
  const width = Math.max(THINNEST_CURVE, CURVE_WIDTH * model.narrowest * view.scale);
  strokeOnce(context, path, painter.colours.curve, width);
}

// Benches whose dancers let go are pale; the others are above them.
/** @type {(painter: Painter, picture: Picture, visible: number[]) => void} */
function drawDragon(painter, { benches, inContact, freeFrom, pointed }, visible) {
  const free = visible.filter((i) => freeFrom !== null && i >= freeFrom);
  const others = visible.filter((i) => freeFrom === null || i < freeFrom);
  painter.drawBenches(benches, free, inContact, true);
  painter.drawBenches(benches, others, inContact);
  if (pointed !== null) painter.drawPointed(benches, pointed, inContact);
}
