// A part of a canvas with coordinates of its own, y up: lines, dots and texts in them,
// and the axes of a chart.

const CHART_MARGINS = { left: 52, right: 22, above: 26, below: 36 }; // pixels
const TICKS_ACROSS = 80; // pixels: least distance of values along the axis

// Names of the colours of the canvas, as in the films' `Palette`, and of further ones of the page.
const CANVAS_COLOURS = [
  "background",
  "curve",
  "head",
  "body",
  "tail",
  "contact",
  "ink",
  "motion",
  "force",
  "grid",
];
const PAGE_COLOURS = ["quiet", "rule", "any"];

// The colours by name; `text` is that of the page's texts.
/** @type {() => Colours} */
function readColours() {
  const { style } = document.body;
  const names = [...CANVAS_COLOURS.map((name) => `canvas-${name}`), ...PAGE_COLOURS, "ink"];
  const values = names.map((name) => {
    // A colour for each scheme is resolved where it is used.
    style.color = `var(--${name})`;
    return getComputedStyle(document.body).color;
  });
  style.color = "";
  return Object.fromEntries(
    [...CANVAS_COLOURS, ...PAGE_COLOURS, "text"].map((name, k) => [name, values[k]]),
  );
}

/** @type {(element: Element) => string} */
const fontOf = (element) => getComputedStyle(element).fontFamily;

// Match a canvas to the pixels of the screen; returns its size in those of the page,
// in which one draws then.
/**
 * @type {(
 *   canvas: HTMLCanvasElement,
 *   context: CanvasRenderingContext2D,
 * ) => { width: number, height: number }}
 */
function fitCanvas(canvas, context) {
  const { width, height } = canvas.getBoundingClientRect();
  const ratio = window.devicePixelRatio || 1;
  const wide = Math.max(1, Math.round(width * ratio));
  const high = Math.max(1, Math.round(height * ratio));
  if (canvas.width !== wide || canvas.height !== high) {
    Object.assign(canvas, { width: wide, height: high });
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width: Math.max(1, width), height: Math.max(1, height) };
}

// `look` has `colours` by their names, and a `font`. The pane reaches from `top` down over `width`
// and `height`; there the point (x0, y0) is at the pixel (left, ceiling), and a unit is `sx` and
// `sy` pixels along the axes. Texts have `size` pixels.
class Pane {
  /** @param {CanvasRenderingContext2D} context @param {Look} look */
  constructor(context, look) {
    this.context = context;
    this.look = look;
    this.size = 13;
    this.top = 0;
    this.width = 1;
    this.height = 1;
    this.x0 = 0;
    this.y0 = 0;
    this.sx = 1;
    this.sy = 1;
    this.left = 0;
    this.ceiling = 0;
  }

  // Axes of a chart with the ranges `across` and `up`; what is drawn next is clipped to them.
  // `tick` writes a value, and those of the vertical axis are at least `apart` pixels apart, or
  // left out; `tickAcross` and `apartAcross` are those of the horizontal axis, which has no values
  // by default if the chart has no name.
  /** @type {(axes: ChartAxes) => void} */
  axes({
    across: [x0, x1],
    up: [y0, y1],
    name,
    tick = signed,
    tickAcross = name ? tick : undefined,
    apart = 32,
    apartAcross = TICKS_ACROSS,
    margins = CHART_MARGINS,
  }) {
    const { left, right, above, below } = margins;
    const wide = this.width - left - right;
    const high = this.height - above - below;
    this.x0 = x0;
    this.y0 = y1;
    this.sx = wide / (x1 - x0);
    this.sy = high / (y1 - y0);
    this.left = left;
    this.ceiling = this.top + above;
    for (const x of tickAcross ? ticks(x0, x1, this.sx / apartAcross) : []) {
      const value = tickAcross?.(x);
      if (!value) continue;
      this.line(
        [
          [x, y0],
          [x, y1],
        ],
        { colour: "rule" },
      );
      this.text([x, y0], value, { dy: 15, colour: "quiet" });
    }
    for (const y of apart < Infinity ? ticks(y0, y1, this.sy / apart) : []) {
      this.line(
        [
          [x0, y],
          [x1, y],
        ],
        { colour: "rule" },
      );
      this.text([x0, y], tick(y), { dx: -8, align: "right", colour: "quiet" });
    }
    if (name) this.text([x0, y1], name, { dx: -44, dy: -14, align: "left" });
    this.context.beginPath();
    this.context.rect(left, this.top + above, wide, high);
    this.context.clip();
  }

  /** @type {(x: number, y: number) => Point} */
  toScreen(x, y) {
    return [this.left + (x - this.x0) * this.sx, this.ceiling + (this.y0 - y) * this.sy];
  }

  /** @type {(px: number, py: number) => Point} */
  toWorld(px, py) {
    return [this.x0 + (px - this.left) / this.sx, this.y0 - (py - this.ceiling) / this.sy];
  }

  /** @type {(name: string) => string} */
  colour(name) {
    return this.look.colours[name] ?? name;
  }

  // A path through points; one that is not finite interrupts it.
  /** @type {(points: Iterable<Numbers>) => Path2D} */
  path(points) {
    const path = new Path2D();
    /** @type {"moveTo" | "lineTo"} */
    let next = "moveTo";
    for (const point of points) {
      const [px, py] = this.toScreen(point[0], point[1]);
      const valid = Number.isFinite(px + py);
      if (valid) path[next](px, py);
      next = valid ? "lineTo" : "moveTo";
    }
    return path;
  }

  /**
   * @type {(
   *   points: Iterable<Numbers>,
   *   look?: { colour?: string, width?: number, dash?: number[] },
   * ) => void}
   */
  line(points, { colour = "text", width = 1, dash = [] } = {}) {
    const { context } = this;
    Object.assign(context, { strokeStyle: this.colour(colour), lineWidth: width });
    context.setLineDash(dash);
    context.stroke(this.path(points));
    context.setLineDash([]);
  }

  /** @type {(points: Iterable<Numbers>, look: { colour: string, alpha?: number }) => void} */
  fill(points, { colour, alpha = 1 }) {
    const { context } = this;
    Object.assign(context, { fillStyle: this.colour(colour), globalAlpha: alpha });
    context.fill(this.path(points));
    context.globalAlpha = 1;
  }

  // A dot with a radius in pixels.
  /** @type {(point: Numbers, look?: { colour?: string, radius?: number }) => void} */
  dot(point, { colour = "text", radius = 4 } = {}) {
    const { context } = this;
    context.beginPath();
    context.arc(...this.toScreen(point[0], point[1]), radius, 0, TURN);
    Object.assign(context, {
      fillStyle: this.colour(colour),
      strokeStyle: this.colour("background"),
      lineWidth: 1,
    });
    context.fill();
    context.stroke();
  }

  // A text with a rim, moved by pixels.
  /**
   * @type {(
   *   point: Numbers,
   *   text: string,
   *   look?: { dx?: number, dy?: number, align?: CanvasTextAlign, colour?: string },
   * ) => void}
   */
  text(point, text, { dx = 0, dy = 0, align = "center", colour = "text" } = {}) {
    const { context } = this;
    const [px, py] = this.toScreen(point[0], point[1]);
    Object.assign(context, {
      font: `${this.size}px ${this.look.font}`,
      textAlign: align,
      textBaseline: "middle",
    });
    Object.assign(context, {
      strokeStyle: this.colour("background"),
      fillStyle: this.colour(colour),
      lineWidth: 4,
    });
    context.strokeText(text, px + dx, py + dy);
    context.fillText(text, px + dx, py + dy);
  }
}

// A mixture of two colours: the second has the weight `share`.
/** @type {(one: string, two: string, share: number) => string} */
const mixed = (one, two, share) => `color-mix(in srgb, ${one}, ${two} ${100 * share}%)`;

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

// Add a polygon to a path; `plane` is a pane or a view.
/** @type {(path: Path2D, plane: Plane, corners: Point[]) => void} */
function addPolygon(path, plane, corners) {
  const [first, ...others] = corners;
  path.moveTo(...plane.toScreen(...first));
  for (const corner of others) path.lineTo(...plane.toScreen(...corner));
  path.closePath();
}

// Round numbers between two limits, not more than `density` for each 1.
/** @type {(first: number, last: number, density: number) => number[]} */
function ticks(first, last, density) {
  const step = roundUp(1 / density);
  const from = Math.ceil(first / step - 1e-9);
  const to = Math.floor(last / step + 1e-9);
  return range(from, to, to - from).map((each) => Number((each * step).toPrecision(12)));
}
