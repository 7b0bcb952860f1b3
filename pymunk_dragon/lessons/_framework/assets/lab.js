// The frame of a stage: a canvas with panes, things to drag, sliders, and one readout. `stages` has a function for each
// lesson, which is called with a `Lab` when the experiment is opened. It sets `lab.label`, what the canvas shows,
// `lab.readout`, which returns the text of the readout, and where it computes something for both, `lab.update`.

const stages = {};

const SCENE_COLOURS = ["background", "curve", "head", "body", "tail", "contact", "motion", "force", "grid"];
const PLAYED_FRAME = 0.1; // s: longest time that one picture of a playing stage adds
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

function openStage(div) {
  const lab = new Lab(div);
  stages[div.dataset.stage](lab);
  lab.open();
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
    this.texts = []; // Functions that write texts in the page's language.
    this.panes = [];
    this.knobs = [];
  }

  open() {
    this.readColours();
    this.write();
    document.addEventListener("languagechange", () => this.write());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.readColours());
    new ResizeObserver(() => this.changed()).observe(this.scene);
  }

  // The version of a text in the page's language.
  say(text) {
    return text[document.documentElement.lang] ?? text.en;
  }

  write() {
    for (const write of this.texts) write();
    this.canvas.ariaLabel = this.say(this.label);
    this.changed();
  }

  readColours() {
    const style = getComputedStyle(this.scene), named = (name) => style.getPropertyValue(name).trim();
    this.colours = Object.fromEntries(SCENE_COLOURS.map((name) => [name, named(`--canvas-${name}`)]));
    Object.assign(this.colours, { outline: named("--canvas-ink"), text: named("--ink"), quiet: named("--quiet"), rule: named("--rule") });
    this.font = style.fontFamily;
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

  // A slider; `show` writes its value, and one with `play`, its change in a second, has a button that moves it.
  slider({ label, min, max, step, value, unit = "", show = (given) => `${given} ${unit}`, play }) {
    const input = made("input", { type: "range", min, max, step, value });
    const [name, shown] = [made("span"), made("span", { className: "value" })];
    const row = made("div", { className: "slider" }, made("label", {}, name, input), shown);
    const slider = {
      get value() {
        return Number(input.value);
      },
      set value(given) {
        input.value = given;
        update();
      },
      limit(least, most) {
        Object.assign(input, { min: least, max: most });
        update();
      },
    };
    const update = () => {
      input.ariaValueText = shown.textContent = show(slider.value);
      this.changed();
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
    this.texts.push(() => { button.ariaLabel = this.say({ en: "Play", zh: "播放" }); });
    let plays, exact, last;
    const turn = (on) => {
      plays = on;
      Object.assign(button, { ariaPressed: String(on), textContent: on ? "❚❚" : "▶" });
      this.output.ariaLive = on ? "off" : "polite";
    };
    const step = (now) => {
      if (!plays) return;
      exact += Math.min((now - last) / 1000, PLAYED_FRAME) * rate();
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

  // A thing to drag at the point `at()` of a pane: `moved` takes the point to which it goes; `step` is that of an arrow key.
  knob({ pane = this.panes[0], label, at, moved, step = 0.05, small = false }) {
    const knob = made("button", { type: "button", className: small ? "small knob" : "knob" });
    this.texts.push(() => { knob.ariaLabel = this.say(label); });
    let held = null;
    const here = ({ clientX, clientY }) => {
      const { left, top } = this.scene.getBoundingClientRect();
      return [clientX - left, clientY - top];
    };
    knob.addEventListener("pointerdown", (event) => {
      knob.setPointerCapture(event.pointerId);
      const [px, py] = here(event), [x, y] = pane.toScreen(at());
      held = [x - px, y - py];
    });
    knob.addEventListener("pointermove", (event) => {
      if (!held) return;
      const [px, py] = here(event);
      moved(pane.toWorld([px + held[0], py + held[1]]));
      this.changed();
    });
    for (const end of ["pointerup", "pointercancel"]) knob.addEventListener(end, () => { held = null; });
    knob.addEventListener("keydown", (event) => {
      if (!ARROWS[event.key]) return;
      event.preventDefault();
      const [x, y] = at(), [dx, dy] = ARROWS[event.key], size = event.shiftKey ? 10 * step : step;
      moved([x + size * dx, y + size * dy], [dx, dy]);
      this.changed();
    });
    this.knobs.push({ knob, pane, at });
    this.scene.append(knob);
  }

  // Drawing on a pane with mouse, pen or finger: the points of each line.
  pen(pane, { began, moved, ended }) {
    const { canvas } = this;
    const point = ({ offsetX, offsetY }) => pane.toWorld([offsetX, offsetY]);
    canvas.classList.add("paper");
    let draws = false;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      draws = true;
      began(point(event));
    });
    canvas.addEventListener("pointermove", (event) => {
      if (draws) for (const each of event.getCoalescedEvents?.() ?? [event]) moved(point(each));
      this.changed();
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, () => {
        if (draws) ended();
        draws = false;
        this.changed();
      });
    }
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
      context.save();
      context.beginPath();
      context.rect(0, top, width, pane.share * height);
      context.clip();
      pane.place(top, width, pane.share * height);
      pane.draw(pane);
      context.restore();
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
// in view, in m, or {across, up, ...} of a chart: the ranges of its axes, names, and texts of their ticks.
class Pane {
  constructor(lab, share, view, draw) {
    Object.assign(this, { lab, share, view, draw, context: lab.context });
  }

  place(top, width, height) {
    Object.assign(this, { top, width, height });
    const view = this.view();
    if (!view.across) {
      this.sx = this.sy = Math.min(width / view.width, height / view.height);
      [this.x0, this.y0] = [view.x - width / 2 / this.sx, view.y + height / 2 / this.sy];
      [this.left, this.ceiling] = [0, top];
      return;
    }
    const [left, right, above, below] = [52, 16, 26, 36];
    const [[x0, x1], [y0, y1]] = [view.across, view.up];
    [this.sx, this.sy] = [(width - left - right) / (x1 - x0), (height - above - below) / (y1 - y0)];
    [this.x0, this.y0, this.left, this.ceiling] = [x0, y1, left, top + above];
    this.axes(view, [x0, x1], [y0, y1]);
  }

  axes({ name, tickAcross = String, tickUp = String }, [x0, x1], [y0, y1]) {
    for (const x of ticks(x0, x1, this.sx / 80)) {
      this.line([[x, y0], [x, y1]], { colour: "rule" });
      this.text([x, y0], tickAcross(x), { dy: 15, colour: "quiet", halo: false });
    }
    for (const y of ticks(y0, y1, this.sy / 32)) {
      this.line([[x0, y], [x1, y]], { colour: "rule" });
      this.text([x0, y], tickUp(y), { dx: -8, dy: 0, align: "right", colour: "quiet", halo: false });
    }
    this.text([x0, y1], this.lab.say(name), { dx: -44, dy: -14, align: "left", halo: false });
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
    context.strokeStyle = this.colour(colour);
    context.lineWidth = width;
    context.setLineDash(dash);
    context.stroke(this.path(points, closed));
    context.setLineDash([]);
  }

  fill(points, { colour, alpha = 1 }) {
    const { context } = this;
    context.globalAlpha = alpha;
    context.fillStyle = this.colour(colour);
    context.fill(this.path(points, true));
    context.globalAlpha = 1;
  }

  // An arrow of a length in pixels from a point in the direction [x, y].
  arrow(point, [dx, dy], length, { colour = "text", width = 2.5 } = {}) {
    const size = Math.hypot(dx, dy) * this.sx / length, tip = [point[0] + dx / size, point[1] + dy / size];
    const barb = (side) => [-0.8, side * 0.4].map((part) => 9 * part / this.sx / Math.hypot(dx, dy));
    const end = (side) => [tip[0] + barb(side)[0] * dx - barb(side)[1] * dy, tip[1] + barb(side)[0] * dy + barb(side)[1] * dx];
    this.line([point, tip], { colour, width });
    this.line([end(1), tip, end(-1)], { colour, width });
  }

  // A dot with a radius in pixels.
  dot(point, { colour = "text", radius = 4, rim = "background" } = {}) {
    const { context } = this, [px, py] = this.toScreen(point);
    context.beginPath();
    context.arc(px, py, radius, 0, ROUND);
    context.fillStyle = this.colour(colour);
    context.fill();
    context.strokeStyle = this.colour(rim);
    context.lineWidth = 1;
    context.stroke();
  }

  text(point, text, { dx = 0, dy = 0, align = "center", colour = "text", halo = true } = {}) {
    const { context, lab } = this, [px, py] = this.toScreen(point);
    context.font = `13px ${lab.font}`;
    Object.assign(context, { textAlign: align, textBaseline: "middle", lineWidth: 4, strokeStyle: lab.colours.background });
    if (halo) context.strokeText(text, px + dx, py + dy);
    context.fillStyle = this.colour(colour);
    context.fillText(text, px + dx, py + dy);
  }

  // Benches with their holes. Neighbours overlap, so those with odd numbers come first, and the head is on top.
  benches(benches, { colour = partColour(benches), alpha = 1, outline = "outline" } = {}) {
    const { context } = this, { poses: { x, y }, motion } = benches;
    context.lineWidth = Math.min(Math.max(0.02 * this.sx, 0.5), 1.25);
    context.globalAlpha = alpha;
    context.strokeStyle = this.colour(outline);
    for (const parity of [1, 0]) {
      const paths = new Map();
      for (let i = parity; i < motion.benches; i += 2) {
        const [px, py] = this.toScreen([x[i], y[i]]), reach = motion.lengths[i] * this.sx;
        if (px < -reach || px > this.width + reach || py < this.top - reach || py > this.top + this.height + reach) continue;
        const name = colour(i);
        if (!paths.has(name)) paths.set(name, new Path2D());
        paths.get(name).addPath(this.path(benches.corners(i), true));
      }
      for (const [name, path] of paths) {
        context.fillStyle = this.colour(name);
        if (name !== "none") context.fill(path);
        context.stroke(path);
      }
    }
    context.globalAlpha = 1;
  }
}

// The colours of a dragon's parts.
function partColour({ motion }) {
  return (i) => (i === 0 ? "head" : i === motion.benches - 1 ? "tail" : "body");
}

// A power of ten, as 10⁻³.
function power(exponent) {
  return `10${String(exponent).replace(/./g, (digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)])}`;
}

// The round numbers 1, 2, 5, 10 and so on, by their place after 1; in units of seconds, metres and the like.
function roundNumber(place) {
  return Number(`${[1, 2, 5][((place % 3) + 3) % 3]}e${Math.floor(place / 3)}`);
}

// Round numbers between two limits, not more than `density` for each 1.
function ticks(first, last, density) {
  const rough = 1 / density, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((digit) => digit * power >= rough) * power;
  const from = Math.ceil(first / step - 1e-9), to = Math.floor(last / step + 1e-9);
  return Array.from({ length: Math.max(to - from + 1, 0) }, (_, i) => Number(((from + i) * step).toPrecision(12)));
}

// Points of a curve between two coordinates.
function curvePoints(curve, from, to, step = 0.1) {
  const count = Math.max(Math.ceil((to - from) / step), 1);
  return Array.from({ length: count + 1 }, (_, i) => curve.frame(from + (to - from) * i / count).slice(0, 2));
}

// The coordinate of a curve between two others that is closest to a point.
function nearestOn(curve, [x, y], from, to, step = 0.1) {
  const apart = (s) => {
    const [px, py] = curve.frame(s);
    return (px - x) ** 2 + (py - y) ** 2;
  };
  let best = from;
  for (let s = from; s <= to; s += step) if (apart(s) < apart(best)) best = s;
  return Math.min(Math.max(minimumBetween(apart, best - step, best + step), from), to);
}
