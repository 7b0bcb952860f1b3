// The frame of a stage: a canvas with panes, things to drag, sliders, and one readout. `stages` has a function for each
// lesson, which is called with a `Lab` when the experiment is opened. It sets `lab.label`, what the canvas shows, and
// `lab.readout`, which returns what the readout says; `lab.update` runs before both. A text is a pair, English and Chinese.

const stages = {};

const SCENE_COLOURS = ["background", "curve", "head", "body", "tail", "contact"];
const LONGEST_FRAME = 0.1; // s: what one picture of a playing stage adds at most
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
const CHART_MARGINS = { left: 52, right: 16, above: 26, below: 36 }; // pixels

function openStage(div) {
  const lab = new Lab(div);
  stages[div.dataset.stage](lab);
  document.addEventListener("languagechange", () => lab.write());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => lab.readColours());
  new ResizeObserver(() => lab.changed()).observe(lab.scene);
  lab.readColours();
  lab.write();
}

function made(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

class Lab {
  constructor(div) {
    this.canvas = made("canvas", { role: "img" });
    this.scene = made("div", { className: "scene" }, this.canvas);
    this.output = made("output", { className: "readout", ariaLive: "polite" });
    this.controls = made("div", { className: "controls" });
    div.replaceChildren(this.scene, this.output, this.controls);
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.texts = [() => { this.canvas.ariaLabel = this.say(this.label); }]; // write texts in the page's language
    this.panes = [];
    this.knobs = [];
  }

  say([english, chinese]) {
    return document.documentElement.lang === "zh" ? chinese : english;
  }

  write() {
    for (const write of this.texts) write();
    this.changed();
  }

  readColours() {
    const style = getComputedStyle(this.scene), named = (name) => style.getPropertyValue(name).trim();
    this.colours = Object.fromEntries(SCENE_COLOURS.map((name) => [name, named(`--canvas-${name}`)]));
    this.colours.outline = named("--canvas-ink");
    for (const [name, variable] of [["text", "--ink"], ["quiet", "--quiet"], ["rule", "--rule"]]) this.colours[name] = named(variable);
    this.font = `13px ${style.fontFamily}`;
    this.changed();
  }

  // A mixture of two colours, with a share of the second from 0 to 1 in steps of a twentieth.
  mixed(one, two, share) {
    const percent = 5 * Math.round(20 * Math.min(Math.max(share, 0), 1));
    return `color-mix(in oklab, ${this.colours[two]} ${percent}%, ${this.colours[one]})`;
  }

  // Something changed: draw with the next picture.
  changed() {
    this.scheduled ??= requestAnimationFrame(() => {
      this.scheduled = undefined;
      this.paint();
    });
  }

  // A slider; `show` writes its value. One with `play`, the change of its value in a second, has a button that moves it.
  slider(label, { min, max, step, value, unit = "", show = (given) => `${given} ${unit}`, play }) {
    const input = made("input", { type: "range", min, max, step, value });
    const name = made("span"), shown = made("span", { className: "value" });
    const row = made("div", { className: "slider" }, made("label", {}, name, input), shown);
    const update = () => {
      input.ariaValueText = shown.textContent = show(Number(input.value));
      this.changed();
    };
    const slider = {
      get value() { return Number(input.value); },
      set value(given) {
        input.value = given;
        update();
      },
      limit(least, most) {
        Object.assign(input, { min: least, max: most });
        update();
      },
    };
    input.addEventListener("input", update);
    this.texts.push(() => {
      name.textContent = this.say(label);
      update();
    });
    if (play) row.append(this.player(slider, input, play));
    this.controls.append(row);
    return slider;
  }

  player(slider, input, rate) {
    const button = made("button", { type: "button", className: "play" });
    this.texts.push(() => { button.ariaLabel = this.say(["Play", "播放"]); });
    let plays, exact, last;
    const turn = (on) => {
      plays = on;
      Object.assign(button, { ariaPressed: String(on), textContent: on ? "❚❚" : "▶" });
      this.output.ariaLive = on ? "off" : "polite";
    };
    const step = (now) => {
      if (!plays) return;
      exact += Math.min((now - last) / 1000, LONGEST_FRAME) * rate();
      last = now;
      slider.value = exact;
      turn(exact < Number(input.max));
      requestAnimationFrame(step);
    };
    button.addEventListener("click", () => {
      turn(!plays);
      exact = slider.value < Number(input.max) ? slider.value : Number(input.min);
      last = performance.now();
      requestAnimationFrame(step);
    });
    input.addEventListener("input", () => turn(false));
    turn(false);
    return button;
  }

  // A part of the canvas below those before, with a share of its height; `draw` takes the pane. See `Pane`.
  pane(share, view, draw) {
    this.panes.push(new Pane(this, share, view, draw));
    return this.panes.at(-1);
  }

  // A thing to drag at the point `at()` of a pane. `moved` takes the point to which it goes, and from an arrow key, whose
  // `step` is in m, also 1 (right, up) or -1, with Shift 10 or -10.
  knob(label, { pane = this.panes[0], at, moved, step = 0.05, small = false }) {
    const knob = made("button", { type: "button", className: small ? "small knob" : "knob" });
    this.texts.push(() => { knob.ariaLabel = this.say(label); });
    let held = null; // pixels from the pointer to the knob
    const change = (...to) => {
      moved(...to);
      this.changed();
    };
    knob.addEventListener("pointerdown", ({ pointerId, clientX, clientY }) => {
      knob.setPointerCapture(pointerId);
      const [px, py] = pane.toScreen(at());
      held = [px - clientX, py - clientY];
    });
    knob.addEventListener("pointermove", ({ clientX, clientY }) => {
      if (held) change(pane.toWorld([clientX + held[0], clientY + held[1]]));
    });
    for (const end of ["pointerup", "pointercancel"]) knob.addEventListener(end, () => { held = null; });
    knob.addEventListener("keydown", (event) => {
      if (!ARROWS[event.key]) return;
      event.preventDefault();
      const [x, y] = at(), [dx, dy] = ARROWS[event.key].map((part) => (event.shiftKey ? 10 * part : part));
      change([x + step * dx, y + step * dy], dx + dy);
    });
    this.knobs.push({ knob, pane, at });
    this.scene.append(knob);
  }

  // Lines drawn on a pane with mouse, pen or finger: `drawn` takes the points so far, and whether the line ends.
  pen(pane, drawn) {
    const { canvas } = this;
    let points = null;
    canvas.classList.add("paper");
    canvas.addEventListener("pointerdown", ({ pointerId }) => {
      canvas.setPointerCapture(pointerId);
      points = [];
    });
    canvas.addEventListener("pointermove", ({ offsetX, offsetY }) => {
      if (!points) return;
      points.push(pane.toWorld([offsetX, offsetY]));
      drawn(points, false);
      this.changed();
    });
    canvas.addEventListener("lostpointercapture", () => {
      drawn(points, true);
      points = null;
      this.changed();
    });
  }

  paint() {
    const { canvas, context, scene } = this;
    const width = scene.clientWidth, height = scene.clientHeight, ratio = devicePixelRatio;
    if (width === 0) return;
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = this.colours.background;
    context.fillRect(0, 0, width, height);
    context.lineJoin = "round";
    this.update?.();
    let top = 0;
    for (const pane of this.panes) {
      pane.paint(top, width, pane.share * height);
      top += pane.share * height;
    }
    for (const { knob, pane, at } of this.knobs) {
      const [px, py] = pane.toScreen(at());
      Object.assign(knob.style, { left: `${px}px`, top: `${py}px` });
      knob.hidden = !(px >= 0 && px <= width && py >= pane.top && py <= pane.top + pane.height);
    }
    const text = this.say(this.readout());
    if (this.output.textContent !== text) this.output.textContent = text;
  }
}

// A part of the canvas with coordinates of its own, y up. `view()` is {x, y, width, height} of the floor that has to be
// in view, in m; or of a chart {across, up, name}: the ranges of its axes and a name, and `tick` if it writes their values.
class Pane {
  constructor(lab, share, view, draw) {
    Object.assign(this, { lab, share, view, draw, context: lab.context });
  }

  paint(top, width, height) {
    const { context } = this, { x, y, width: across, height: up, ...chart } = this.view();
    Object.assign(this, { top, width, height });
    context.save();
    context.beginPath();
    context.rect(0, top, width, height);
    context.clip();
    if (chart.across) {
      this.axes(chart);
    } else {
      const scale = Math.min(width / across, height / up);
      this.place([x - width / 2 / scale, y + height / 2 / scale], [scale, scale], [0, top]);
    }
    this.draw(this);
    context.restore();
  }

  // The point at the upper left corner, pixels to a unit, and pixels of the corner.
  place([x0, y0], [sx, sy], [left, ceiling]) {
    Object.assign(this, { x0, y0, sx, sy, left, ceiling });
  }

  axes({ across: [x0, x1], up: [y0, y1], name, tick = String }) {
    const { left, right, above, below } = CHART_MARGINS;
    const scales = [(this.width - left - right) / (x1 - x0), (this.height - above - below) / (y1 - y0)];
    this.place([x0, y1], scales, [left, this.top + above]);
    for (const x of ticks(x0, x1, this.sx / 80)) {
      this.line([[x, y0], [x, y1]], { colour: "rule" });
      this.text([x, y0], tick(x), { dy: 15, colour: "quiet" });
    }
    for (const y of ticks(y0, y1, this.sy / 32)) {
      this.line([[x0, y], [x1, y]], { colour: "rule" });
      this.text([x0, y], tick(y), { dx: -8, align: "right", colour: "quiet" });
    }
    this.text([x0, y1], this.lab.say(name), { dx: -44, dy: -14, align: "left" });
  }

  toScreen([x, y]) {
    return [this.left + (x - this.x0) * this.sx, this.ceiling + (this.y0 - y) * this.sy];
  }

  toWorld([px, py]) {
    return [this.x0 + (px - this.left) / this.sx, this.y0 - (py - this.ceiling) / this.sy];
  }

  colour(name) {
    return this.lab.colours[name] ?? name;
  }

  path(points, closed) {
    const path = new Path2D();
    points.forEach((point, i) => path[i === 0 ? "moveTo" : "lineTo"](...this.toScreen(point)));
    if (closed) path.closePath();
    return path;
  }

  line(points, { colour = "text", width = 1, dash = [], closed = false } = {}) {
    const { context } = this;
    Object.assign(context, { strokeStyle: this.colour(colour), lineWidth: width });
    context.setLineDash(dash);
    context.stroke(this.path(points, closed));
    context.setLineDash([]);
  }

  fill(points, { colour, alpha = 1 }) {
    const { context } = this;
    Object.assign(context, { fillStyle: this.colour(colour), globalAlpha: alpha });
    context.fill(this.path(points, true));
    context.globalAlpha = 1;
  }

  // A dot with a radius in pixels.
  dot(point, { colour = "text", radius = 4 } = {}) {
    const { context } = this;
    context.beginPath();
    context.arc(...this.toScreen(point), radius, 0, ROUND);
    Object.assign(context, { fillStyle: this.colour(colour), strokeStyle: this.colour("background"), lineWidth: 1 });
    context.fill();
    context.stroke();
  }

  // A text with a rim, moved by pixels.
  text(point, text, { dx = 0, dy = 0, align = "center", colour = "text" } = {}) {
    const { context } = this, [px, py] = this.toScreen(point);
    Object.assign(context, { font: this.lab.font, textAlign: align, textBaseline: "middle", lineWidth: 4 });
    Object.assign(context, { strokeStyle: this.colour("background"), fillStyle: this.colour(colour) });
    context.strokeText(text, px + dx, py + dy);
    context.fillText(text, px + dx, py + dy);
  }

  // Benches in the colours that `colour` has for their numbers. Neighbours overlap: even ones are above odd ones.
  benches(benches, colour = (i) => (i === 0 ? "head" : "body"), alpha = 1) {
    const { context } = this, { poses: { x, y }, motion: { benches: count, lengths } } = benches;
    Object.assign(context, { strokeStyle: this.colour("outline"), globalAlpha: alpha });
    context.lineWidth = Math.min(Math.max(0.02 * this.sx, 0.5), 1.25);
    for (const parity of [1, 0]) {
      const paths = new Map();
      for (let i = parity; i < count; i += 2) {
        const [px, py] = this.toScreen([x[i], y[i]]), reach = lengths[i] * this.sx;
        if (px < -reach || px > this.width + reach || py < this.top - reach || py > this.top + this.height + reach) continue;
        if (!paths.has(colour(i))) paths.set(colour(i), new Path2D());
        paths.get(colour(i)).addPath(this.path(benches.corners(i), true));
      }
      for (const [name, path] of paths) {
        context.fillStyle = this.colour(name);
        context.fill(path);
        context.stroke(path);
      }
    }
    context.globalAlpha = 1;
  }
}

// Round numbers between two limits, not more than `density` for each 1.
function ticks(first, last, density) {
  const place = Array.from({ length: 60 }, (_, i) => i - 30).find((each) => roundNumber(each) * density >= 1);
  const step = roundNumber(place), from = Math.ceil(first / step - 1e-9), to = Math.floor(last / step + 1e-9);
  return Array.from({ length: Math.max(to - from + 1, 0) }, (_, i) => Number(((from + i) * step).toPrecision(12)));
}

// 1, 2, 5, 10 and so on by their place, and for negative places 0.5, 0.2, 0.1.
function roundNumber(place) {
  return Number(`${[1, 2, 5][((place % 3) + 3) % 3]}e${Math.floor(place / 3)}`);
}

// Values at equal distances, both limits included.
function range(from, to, count) {
  return Array.from({ length: count + 1 }, (_, i) => from + (to - from) * i / count);
}

function bounded(value, least, most) {
  return Math.min(Math.max(value, least), most);
}

// Points of a curve between two coordinates, and on a circle.
function curvePoints(curve, from, to, step = 0.1) {
  return range(from, to, Math.max(Math.ceil((to - from) / step), 1)).map((s) => curve.frame(s).slice(0, 2));
}

function circlePoints([x, y], radius) {
  return range(0, ROUND, 180).map((angle) => [x + radius * Math.cos(angle), y + radius * Math.sin(angle)]);
}

// The coordinate of a curve between two others that is closest to a point.
function nearestOn(curve, [x, y], from, to, step = 0.1) {
  const apart = (s) => Math.hypot(curve.frame(s)[0] - x, curve.frame(s)[1] - y);
  const best = range(from, to, Math.ceil((to - from) / step)).reduce((one, other) => (apart(other) < apart(one) ? other : one));
  return bounded(minimumBetween(apart, best - step, best + step), from, to);
}
