// Many small circles: copied pixel by pixel, which takes a browser without a graphics card a third
// of the time of as many paths.

const SHAPE_OUTLINE = 1; // pixels
const LEAST_DISCS = 300; // fewer are drawn as paths
const LARGEST_DISC = 16; // pixels of the screen: radius, so that a copy is small
const MOST_PIXELS = 4e6; // of the canvas: its copy takes longer than the paths on a larger one
const PARTS = 4; // of a pixel along each axis, to which centres are rounded
const ROUNDED = 8; // parts of a pixel, to which radii are rounded
const MOST_STAMPS = 500; // kinds of circles that are remembered

/**
 * @typedef {object} Stamp
 * @property {number} side
 * @property {Uint32Array} pixels
 */

class Discs {
  constructor() {
    this.canvas = created("canvas");
    this.context = newContext(this.canvas);
    // Browsers that hide which computer this is return other pixels than were drawn.
    this.context.fillRect(0, 0, 1, 1);
    this.works = this.context.getImageData(0, 0, 2, 1).data.join() === "0,0,0,255,0,0,0,0";
    this.image = new ImageData(1, 1);
    this.pixels = new Uint32Array(this.image.data.buffer);
    /** @type {Map<string, Stamp[]>} */
    this.stamps = new Map();
  }

  // Whether a circle of a radius in pixels of the page can be copied on a canvas.
  /** @type {(canvas: HTMLCanvasElement, radius: number, ratio: number) => boolean} */
  fits({ width, height }, radius, ratio) {
    return this.works && radius * ratio <= LARGEST_DISC && width * height <= MOST_PIXELS;
  }

  // Draw discs with outlines, one on the other; `screen` has their centres.
  /**
   * @type {(
   *   context: CanvasRenderingContext2D,
   *   ratio: number,
   *   scale: number,
   *   calls: Call[],
   *   screen: Point[],
   * ) => void}
   */
  draw(context, ratio, scale, calls, screen) {
    this.clear(context.canvas);
    /** @type {Stamp[]} */
    let stamps = [];
    /** @type {Partial<Call>} */
    let last = {};
    calls.forEach((call, k) => {
      const { fill, outline, radius } = call;
      if (fill !== last.fill || outline !== last.outline || radius !== last.radius) {
        stamps = this.stampsOf(call, Math.round(ROUNDED * radius * scale * ratio) / ROUNDED, ratio);
        last = call;
      }
      const x = Math.round(PARTS * ratio * screen[k][0]);
      const y = Math.round(PARTS * ratio * screen[k][1]);
      const left = Math.floor(x / PARTS);
      const top = Math.floor(y / PARTS);
      this.copy(stamps[x - PARTS * left + PARTS * (y - PARTS * top)], left, top);
    });
    this.context.putImageData(this.image, 0, 0);
    context.save();
    context.resetTransform();
    context.drawImage(this.canvas, 0, 0);
    context.restore();
  }

  /** @type {(canvas: HTMLCanvasElement) => void} */
  clear({ width, height }) {
    if (this.image.width === width && this.image.height === height) {
      this.pixels.fill(0);
      return;
    }
    Object.assign(this.canvas, { width, height });
    this.image = new ImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
  }

  // Pictures of a circle, for each place of its centre within a pixel.
  /** @type {(call: Call, radius: number, ratio: number) => Stamp[]} */
  stampsOf({ fill, outline = fill }, radius, ratio) {
    const key = [fill, outline, radius, ratio].join();
    const known = this.stamps.get(key);
    if (known) return known;
    if (this.stamps.size >= MOST_STAMPS) this.stamps.clear();
    const half = Math.ceil(radius + ratio) + 1;
    const side = 2 * half;
    const canvas = Object.assign(created("canvas"), { width: side, height: side * PARTS ** 2 });
    const context = newContext(canvas);
    Object.assign(context, { fillStyle: fill, strokeStyle: outline });
    context.lineWidth = SHAPE_OUTLINE * ratio;
    const stamps = Array.from({ length: PARTS ** 2 }, (_, k) => {
      const x = half + (k % PARTS) / PARTS;
      const y = half + Math.floor(k / PARTS) / PARTS;
      context.beginPath();
      context.arc(x, k * side + y, radius, 0, TURN);
      context.fill();
      context.stroke();
      const { data } = context.getImageData(0, k * side, side, side);
      return { side, pixels: new Uint32Array(data.buffer) };
    });
    this.stamps.set(key, stamps);
    return stamps;
  }

  // Copy a picture whose middle is at a pixel.
  /** @type {(stamp: Stamp, x: number, y: number) => void} */
  copy({ side, pixels: from }, x, y) {
    const { pixels: to } = this;
    const { width, height } = this.image;
    const left = x - side / 2;
    const top = y - side / 2;
    const first = Math.max(0, -left);
    const last = Math.min(side, width - left);
    const bottom = Math.min(side, height - top);
    for (let row = Math.max(0, -top); row < bottom; row++) {
      const source = row * side;
      const target = (top + row) * width + left;
      for (let k = first; k < last; k++) {
        const pixel = from[source + k];
        if (pixel !== 0) to[target + k] = blended(pixel, to[target + k]);
      }
    }
  }
}

/** @type {(canvas: HTMLCanvasElement) => CanvasRenderingContext2D} */
const newContext = (canvas) =>
  /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: true }));

// A pixel over another one: alpha, blue, green and red from the highest to the lowest byte.
/** @type {(over: number, under: number) => number} */
function blended(over, under) {
  const alpha = over >>> 24;
  if (alpha === 255 || under === 0) return over;
  const rest = ((under >>> 24) * (255 - alpha)) / 255;
  const all = alpha + rest;
  let pixel = Math.round(all) << 24;
  for (let shift = 0; shift < 24; shift += 8) {
    const sum = ((over >>> shift) & 255) * alpha + ((under >>> shift) & 255) * rest;
    pixel |= Math.round(sum / all) << shift;
  }
  return pixel;
}
