// Camera: the visible part of the plane, x to the right and
// y up (down where `up` is -1) in m; pixels go down.

// pixels: a near miss of the reference scenario is then some 60 pixels wide.
const WIDEST_BENCH = 20000;
const SMALLEST = 0.2; // smallest scale relative to that of the fitted view
const LARGEST_SCALE = 1e30; // pixels per m: a canvas has single precision, which ends at 3e38
const BORDER = 0.04; // border of the fitted view as a fraction of its size

class View {
  /** @param {Subject} subject */
  constructor(subject) {
    this.x = this.y = 0;
    this.scale = 1; // pixels per m
    this.width = this.height = 1; // pixels
    this.top = this.right = this.bottom = 0; // pixels that the fitted view leaves free
    this.up = 1;
    this.headSpan = 1; // m
    this.maxScale = 1; // pixels per m
    this.free = false;
    this.field = subject.field;
    this.setSubject(subject);
  }

  // What is seen: the area of the field {centre, size}, and the widths of the benches, all in m.
  // A `free` view has no benches, and may be anywhere and of any size.
  /** @type {(subject: Subject) => void} */
  setSubject({ field, widths, narrowest, up = 1, free = false }) {
    this.field = field;
    this.free = free;
    // m: the head and three turns around it; a free view keeps its size.
    this.headSpan = free ? Infinity : 20 * widths[0];
    this.maxScale = WIDEST_BENCH / narrowest;
    this.up = up;
  }

  get fittingScale() {
    const [width, height] = this.field.size;
    const high = this.height - this.top - this.bottom;
    return (1 - 2 * BORDER) * Math.min((this.width - this.right) / width, high / height);
  }

  // Metres across the shorter side: links hold it, so that they show the same area on every screen.
  get span() {
    return Math.min(this.width, this.height) / this.scale;
  }

  /** @param {number} metres */
  set span(metres) {
    this.scale = this.bounded(Math.min(this.width, this.height) / metres);
  }

  /** @type {(scale: number) => number} */
  bounded(scale) {
    if (this.free) return Math.min(Math.max(scale, 1 / LARGEST_SCALE), LARGEST_SCALE);
    return Math.min(
      Math.max(scale, SMALLEST * Math.min(this.fittingScale, this.maxScale)),
      this.maxScale,
    );
  }

  fit() {
    [this.x, this.y] = this.field.centre;
    this.scale = this.bounded(this.fittingScale);
    this.x += this.right / 2 / this.scale;
    this.y += (this.up * (this.top - this.bottom)) / 2 / this.scale;
  }

  /** @type {(x: number, y: number) => Point} */
  toScreen(x, y) {
    return [
      (x - this.x) * this.scale + this.width / 2,
      (this.y - y) * this.up * this.scale + this.height / 2,
    ];
  }

  /** @type {(px: number, py: number) => Point} */
  toWorld(px, py) {
    return [
      this.x + (px - this.width / 2) / this.scale,
      this.y - (this.up * (py - this.height / 2)) / this.scale,
    ];
  }

  // Zoom around a pixel.
  /** @type {(factor: number, px?: number, py?: number) => void} */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toWorld(px, py);
    this.scale = this.bounded(this.scale * factor);
    const [newX, newY] = this.toWorld(px, py);
    this.x += x - newX;
    this.y += y - newY;
  }

  // Move the view by pixels, unless it is free within the size of the field around its centre.
  /** @type {(dx: number, dy: number) => void} */
  pan(dx, dy) {
    const { centre, size } = this.field;
    /** @type {(value: number, axis: number) => number} */
    const within = (value, axis) =>
      this.free ? value : bounded(value, centre[axis] - size[axis], centre[axis] + size[axis]);
    this.x = within(this.x - dx / this.scale, 0);
    this.y = within(this.y + (this.up * dy) / this.scale, 1);
  }

  // Whether any point within `reach` m of a point is visible.
  /** @type {(x: number, y: number, reach: number) => boolean} */
  isVisible(x, y, reach) {
    return (
      Math.abs(x - this.x) <= this.width / 2 / this.scale + reach &&
      Math.abs(y - this.y) <= this.height / 2 / this.scale + reach
    );
  }
}
