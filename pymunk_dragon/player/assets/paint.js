// Draws one moment on the canvas. Few paths of many benches: a path costs more than what is in it.

// Share of a bench's width that the curve is thick, as in the films, and pixels at least.
const CURVE_WIDTH = 0.04, THINNEST_CURVE = 1;
// Pixels that the drawn curve may be off, and points of it that are looked at together for being in sight.
const CURVE_ERROR_SHOWN = 0.3, CURVE_CHUNK = 64;
// Pixels: smallest hole and cell that are drawn, cells that are large enough for a number at the side and for a name, and
// width of a bench that is large enough for its number.
const SMALLEST_HOLE = 2.5, SMALLEST_CELL = 5, NUMBERED_CELL = 22, NAMED_CELL = 120, NUMBERED_BENCH = 10;
// Where benches are smaller than that, every so many have a number, if there is room for its pixels.
const NUMBER_EVERY = 25, NUMBER_SIZE = 28;
// Metres of arrow for each m/s.
const ARROW = 0.5;
// Pixels: the ring around a contact, and its distance from its label.
const RING = 9, LABEL_OFFSET = 14;
// Seconds before and after a near miss in which it is shown.
const NEAR_SHOWN = 1.5;

class Painter {
  constructor(canvas, motion, view, told, curve) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
    this.motion = motion;
    this.view = view;
    this.told = told;
    this.curve = placesOf(curve);
    this.curveError = motion.width / 3000;
    this.readColours();
  }

  readColours() {
    const style = getComputedStyle(document.documentElement);
    const named = (name) => style.getPropertyValue(name).trim();
    this.colours = {
      ...Object.fromEntries(["background", "curve", "head", "body", "tail", "contact", "ink"]
        .map((name) => [name, named(`--canvas-${name}`)])),
      type: named("--ink"), line: named("--line"), shade: named("--shade"),
    };
    this.font = getComputedStyle(document.body).fontFamily;
  }

  // The canvas gets as many pixels as the screen has. Tells whether its size has changed.
  resize() {
    const { width, height } = this.canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const wide = Math.max(1, Math.round(width * ratio)), high = Math.max(1, Math.round(height * ratio));
    if (this.canvas.width === wide && this.canvas.height === high && this.ratio === ratio) return false;
    Object.assign(this.canvas, { width: wide, height: high });
    Object.assign(this.view, { width: Math.max(1, width), height: Math.max(1, height) });
    this.ratio = ratio;
    return true;
  }

  // `moment` has the time, the benches then, what is to be shown, and the bench that is pointed at.
  draw({ time, benches, show, pointed }) {
    const { context, view, colours, motion } = this;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.fillStyle = colours.background;
    context.fillRect(0, 0, view.width, view.height);
    context.lineJoin = context.lineCap = "round";
    const { x, y } = benches.poses;
    const seen = [];
    for (let i = motion.benches - 1; i >= 0; i--) if (view.sees(x[i], y[i], motion.lengths[i])) seen.push(i);
    const touching = motion.touchingAt(time);
    const red = new Set(touching.flatMap((window) => window.benches));
    if (show.grid && this.told.grid) this.drawGrid(benches, seen);
    if (show.curve) this.drawCurve();
    this.drawBenches(benches, seen, red);
    if (pointed !== null) this.drawPointed(benches, pointed, red);
    if (show.handles) this.drawHandles(benches, seen);
    if (show.velocities) this.drawVelocities(time, benches, seen);
    if (show.labels) this.drawNumbers(benches, seen, red);
    if (show.grid && this.told.grid) this.drawGridNames();
    if (show.contacts) this.drawContacts(time, benches, touching);
  }

  drawCurve() {
    const { context, view, curve } = this;
    // A chord of n points is off by n^2 times as much as one of 1.
    const stride = Math.max(1, Math.floor(Math.sqrt(CURVE_ERROR_SHOWN / (view.scale * this.curveError))));
    const path = new Path2D();
    const last = curve.length / 2 - 1;
    for (let begin = 0; begin < last; begin += CURVE_CHUNK * stride) {
      const end = Math.min(begin + CURVE_CHUNK * stride, last);
      if (!this.seesCurve(begin, end)) continue;
      path.moveTo(...view.toScreen(curve[2 * begin], curve[2 * begin + 1]));
      for (let i = begin + stride; i < end + stride; i += stride) {
        const k = Math.min(i, end);
        path.lineTo(...view.toScreen(curve[2 * k], curve[2 * k + 1]));
      }
    }
    context.strokeStyle = this.colours.curve;
    context.lineWidth = Math.max(THINNEST_CURVE, CURVE_WIDTH * this.motion.width * view.scale);
    context.stroke(path);
  }

  // Whether the box around a stretch of the curve is in sight.
  seesCurve(begin, end) {
    let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let i = begin; i <= end; i++) {
      left = Math.min(left, this.curve[2 * i]);
      right = Math.max(right, this.curve[2 * i]);
      bottom = Math.min(bottom, this.curve[2 * i + 1]);
      top = Math.max(top, this.curve[2 * i + 1]);
    }
    const [x0, y0] = this.view.toScreen(left, top), [x1, y1] = this.view.toScreen(right, bottom);
    return x1 >= 0 && x0 <= this.view.width && y1 >= 0 && y0 <= this.view.height;
  }

  outline(path, benches, i) {
    const [first, ...rest] = benches.corners(i);
    path.moveTo(...this.view.toScreen(...first));
    for (const corner of rest) path.lineTo(...this.view.toScreen(...corner));
    path.closePath();
  }

  drawBenches(benches, seen, red) {
    const { context, colours, motion, view } = this;
    const tail = motion.benches - 1;
    const special = (i) => i === 0 || i === tail || red.has(i);
    context.strokeStyle = colours.ink;
    context.lineWidth = Math.min(Math.max(0.06 * motion.width * view.scale, 0.5), 1.25);
    const paint = (chosen) => {
      if (!chosen.length) return;
      const path = new Path2D();
      for (const i of chosen) this.outline(path, benches, i);
      context.fillStyle = this.colourOf(chosen[0], red);
      context.fill(path);
      context.stroke(path);
    };
    // Benches overlap only with their neighbours, so the even ones make one path, and the odd ones lie on top of them.
    for (const parity of [0, 1]) paint(seen.filter((i) => i % 2 === parity && !special(i)));
    for (const i of seen.filter(special)) paint([i]);
    const radius = this.told.dragon.hole / 2 * view.scale;
    if (2 * radius >= SMALLEST_HOLE) this.drawHoles(benches, seen, radius, colours.ink);
  }

  drawHoles(benches, seen, radius, colour) {
    const { context, view } = this;
    const path = new Path2D();
    const handles = benches.handles ??= this.motion.handlesOf(benches.poses);
    for (const handle of new Set(seen.flatMap((i) => [i, i + 1]))) {
      const [px, py] = view.toScreen(...handles[handle]);
      path.moveTo(px + radius, py);
      path.arc(px, py, radius, 0, TURN);
    }
    context.fillStyle = colour;
    context.fill(path);
    return path;
  }

  drawHandles(benches, seen) {
    const { context, colours, view } = this;
    const radius = Math.max(2.2, 0.8 * this.told.dragon.hole * view.scale);
    const path = this.drawHoles(benches, seen, radius, colours.background);
    context.strokeStyle = colours.type;
    context.lineWidth = Math.min(1.25, 0.4 * radius);
    context.stroke(path);
  }

  drawVelocities(time, benches, seen) {
    const { context, colours, motion, view } = this;
    const velocities = motion.velocitiesAt(time);
    if (!velocities) return;
    const handles = benches.handles ??= motion.handlesOf(benches.poses);
    const shafts = new Path2D(), heads = new Path2D();
    for (const handle of new Set(seen.flatMap((i) => [i, i + 1]))) {
      const [vx, vy] = velocities[handle], [hx, hy] = handles[handle];
      const [px, py] = view.toScreen(hx, hy);
      const [qx, qy] = view.toScreen(hx + ARROW * vx, hy + ARROW * vy);
      const length = Math.hypot(qx - px, qy - py);
      if (length < 2) continue;
      const ux = (qx - px) / length, uy = (qy - py) / length;
      const head = Math.min(9, 0.45 * length), half = 0.38 * head;
      shafts.moveTo(px, py);
      shafts.lineTo(qx - head * ux, qy - head * uy);
      heads.moveTo(qx, qy);
      heads.lineTo(qx - head * ux - half * uy, qy - head * uy + half * ux);
      heads.lineTo(qx - head * ux + half * uy, qy - head * uy - half * ux);
      heads.closePath();
    }
    context.strokeStyle = context.fillStyle = colours.type;
    context.lineWidth = 1.5;
    context.stroke(shafts);
    context.fill(heads);
  }

  drawNumbers(benches, seen, red) {
    const { context, colours, motion, view } = this;
    const { x, y, angle } = benches.poses;
    const thickness = motion.width * view.scale;
    context.textAlign = "center";
    context.textBaseline = "middle";
    if (thickness < NUMBERED_BENCH) {
      context.font = `600 12px ${this.font}`;
      const written = [];
      for (const i of seen.toReversed()) {
        if (i % NUMBER_EVERY && i !== motion.benches - 1 && !red.has(i)) continue;
        const [px, py] = view.toScreen(x[i], y[i]);
        if (written.some(([qx, qy]) => Math.abs(px - qx) < NUMBER_SIZE && Math.abs(py - qy) < NUMBER_SIZE / 2)) continue;
        written.push([px, py]);
        this.write(String(i), px, py);
      }
      return;
    }
    context.font = `${Math.min(0.72 * thickness, 16)}px ${this.font}`;
    for (const i of seen) {
      const [px, py] = view.toScreen(x[i], y[i]);
      // Along the bench, and never upside down.
      let turn = -angle[i] - Math.PI * Math.round(-angle[i] / Math.PI);
      if (turn <= -Math.PI / 2) turn += Math.PI;
      context.translate(px, py);
      context.rotate(turn);
      context.fillStyle = red.has(i) || i === motion.benches - 1 ? colours.background : colours.ink;
      context.fillText(String(i), 0, 0.04 * thickness);
      context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    }
  }

  // Type on whatever lies below.
  write(text, px, py) {
    const { context, colours } = this;
    context.strokeStyle = colours.background;
    context.lineWidth = 4;
    context.strokeText(text, px, py);
    context.fillStyle = colours.type;
    context.fillText(text, px, py);
  }

  // The bench that is pointed at lies on top, with a line around it.
  drawPointed(benches, i, red) {
    const { context, colours } = this;
    const path = new Path2D();
    this.outline(path, benches, i);
    for (const [colour, width] of [[colours.background, 9], [colours.type, 5]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.stroke(path);
    }
    context.fillStyle = this.colourOf(i, red);
    context.fill(path);
    this.drawHoles(benches, [i], this.told.dragon.hole / 2 * this.view.scale, colours.ink);
  }

  colourOf(i, red) {
    const { contact, head, tail, body } = this.colours;
    return red.has(i) ? contact : i === 0 ? head : i === this.motion.benches - 1 ? tail : body;
  }

  drawGrid(benches, seen) {
    const { context, colours, view, told } = this;
    const { cell, origin } = told.grid;
    const size = cell * view.scale;
    if (size < SMALLEST_CELL) return;
    const corner = (row, column) => view.toScreen(origin[0] + column * cell, origin[1] - row * cell);
    const filed = new Path2D();
    for (const i of seen) {
      for (const [row, column] of benches.cells(i, told.grid)) filed.rect(...corner(row, column), size, size);
    }
    context.fillStyle = colours.shade;
    context.fill(filed);
    const [west, north] = view.toFloor(0, 0), [east, south] = view.toFloor(view.width, view.height);
    const lines = new Path2D();
    for (const row of numbersBetween((origin[1] - north) / cell, (origin[1] - south) / cell)) {
      const py = corner(row, 0)[1];
      lines.moveTo(0, py);
      lines.lineTo(view.width, py);
    }
    for (const column of numbersBetween((west - origin[0]) / cell, (east - origin[0]) / cell)) {
      const px = corner(0, column)[0];
      lines.moveTo(px, 0);
      lines.lineTo(px, view.height);
    }
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    context.stroke(lines);
  }

  // The grid's numbers, on top of everything: rows along the left side, columns along the top, and in large cells both.
  drawGridNames() {
    const { context, view, told } = this;
    const { cell, origin } = told.grid;
    const size = cell * view.scale;
    if (size < NUMBERED_CELL) return;
    const [west, north] = view.toFloor(0, 0), [east, south] = view.toFloor(view.width, view.height);
    const rows = numbersBetween((origin[1] - north) / cell, (origin[1] - south) / cell);
    const columns = numbersBetween((west - origin[0]) / cell, (east - origin[0]) / cell);
    const middle = (row, column) => view.toScreen(origin[0] + (column + 0.5) * cell, origin[1] - (row + 0.5) * cell);
    context.font = `11px ${this.font}`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const row of rows) if (middle(row, 0)[1] > 24) this.write(signed(row), 14, middle(row, 0)[1]);
    for (const column of columns) this.write(signed(column), middle(0, column)[0], 10);
    if (size < NAMED_CELL) return;
    for (const row of rows) {
      for (const column of columns) {
        const [px, py] = middle(row, column);
        this.write(`${signed(row)}, ${signed(column)}`, px, py);
      }
    }
  }

  drawContacts(time, benches, touching) {
    const { context, view } = this;
    for (const window of touching) {
      const point = view.toScreen(...benches.gap(...window.benches).ends[0]);
      this.ring(point);
    }
    for (const miss of this.told.near) {
      if (Math.abs(miss.time - time) > NEAR_SHOWN) continue;
      const { ends } = benches.gap(...miss.benches);
      const [one, two] = ends.map((end) => view.toScreen(...end));
      const middle = [(one[0] + two[0]) / 2, (one[1] + two[1]) / 2];
      // Around both ends, as far apart as they may look.
      this.ring(middle, Math.hypot(one[0] - two[0], one[1] - two[1]) / 2);
      context.font = `600 13px ${this.font}`;
      context.textAlign = "left";
      context.textBaseline = "middle";
      this.write(`${inLength(miss.gap, 0)} at ${miss.time.toFixed(2)} s`, middle[0] + LABEL_OFFSET, middle[1] - LABEL_OFFSET);
    }
  }

  ring([px, py], inner = 0) {
    const { context, colours } = this;
    for (const [stroke, width] of [[colours.background, 5], [colours.type, 2]]) {
      context.beginPath();
      context.arc(px, py, Math.max(RING, 1.6 * inner), 0, TURN);
      context.strokeStyle = stroke;
      context.lineWidth = width;
      context.stroke();
    }
  }
}

// The whole numbers from that of `from` to that of `to`.
function numbersBetween(from, to) {
  const first = Math.floor(from);
  return Array.from({ length: Math.floor(to) - first + 1 }, (_, i) => first + i);
}

const signed = (number) => String(number).replace("-", "−");

// All frames' places of a packed track in a row, in m.
function placesOf(packed) {
  const { origin, step, counts } = packed;
  return Float64Array.from(counts, (count, i) => origin[i & 1] + step * count);
}

// A length in m as people read it. Below 1 cm tenths of a millimetre count, if they are known.
function inLength(metres, blur) {
  if (metres >= 1) return `${metres.toFixed(2)} m`;
  return `${(1000 * metres).toFixed(metres < 0.01 && blur < 0.0001 ? 1 : 0)} mm`;
}
