// The frame of a stage: a canvas with panes, things to drag, sliders, and one readout. `stages` has
// a function for each lesson, which is called with a `Lab` when the experiment is opened. It sets
// `lab.label`, what the canvas shows, and `lab.readout()`, what it says; `lab.update()` runs before
// each picture. A text is a pair, in English and in Chinese. Sliders and what `lab.keep` registers
// are in the address, and the button "Reset" opens the stage anew.

/** @type {Record<string, (lab: Lab) => void>} */
const stages = {};

const SMALLER = 1.7; // times a picture in the list is smaller
const LONGEST_FRAME = 0.1; // s: what one picture adds at most where a slider plays
/** @type {Record<string, Point>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

/** @type {(div: HTMLElement) => Lab} */
function openStage(div) {
  /** @type {Lab} */
  const lab = new Lab(div);
  stages[div.dataset.stage ?? ""](lab);
  document.addEventListener("languagechange", () => lab.requestDraw());
  lab.watch();
  return lab;
}

// Open a stage in its first state.
/** @type {(div: HTMLElement) => void} */
function resetStage(div) {
  rememberAddress(`#${div.dataset.stage}`);
  openStage(div).reset.focus();
}

class Lab extends Surface {
  /** @param {HTMLElement} div */
  constructor(div) {
    super(created("canvas", { role: "img" }));
    this.scene = created("div", { className: "scene" }, this.canvas);
    this.colourKey = created("ul", { className: "legend" });
    this.output = created("output", { className: "readout" });
    this.reset = created("button", { type: "button" });
    this.reset.addEventListener("click", () => resetStage(div));
    this.actions = created("div", { className: "actions" }, this.reset);
    this.controls = created("div", { className: "controls" }, this.actions);
    // A recorded picture is seen until there is something else to see.
    this.still = div.querySelector("figure");
    div.replaceChildren(this.scene, this.colourKey, this.output, this.controls);
    if (this.still) this.scene.append(this.still);
    this.readColours(); // It has a font only now that it is on the page.
    /** @type {Row[]} */
    this.rows = [];
    /** @type {StagePane[]} */
    this.panes = [];
    /** @type { { button: HTMLElement, label: () => Words }[]} */
    this.buttons = [{ button: this.reset, label: () => ["Reset", "重置"] }];
    /** @type { { item: HTMLElement, words: Words }[]} */
    this.keys = [];
    this.kept = new Kept(this, div.dataset.stage);
    /** @type { { knob: HTMLElement, label: Words, pane: StagePane, at: () => Numbers }[]} */
    this.knobs = [];
    this.painted = 0; // ms: time of the last picture
    this.isSmall = false; // whether it is a picture in the list, without controls
    /** @type {Film | null} */
    this.film = null; // what an engine would play there
    /** @type {Words} */
    this.label = ["", ""];
    /** @type {() => Words} */
    this.readout = () => ["", ""];
    /** @type {(() => void) | undefined} */
    this.update = undefined;
    /** @type {((share: number) => void) | undefined} */
    this.filmed = undefined;
  }

  /** @type {(words: Words) => string} */
  say([english, chinese]) {
    return document.documentElement.lang === "zh" ? chinese : english;
  }

  // What the colours of the picture mean: names of colours with their meaning.
  /** @type {(entries: [string, Words][]) => void} */
  legend(entries) {
    for (const [colour, words] of entries) {
      const swatch = created("i");
      const own = colour === "text" ? "ink" : colour;
      swatch.style.background = `var(--canvas-${colour}, var(--${own}))`;
      const item = created("span");
      this.keys.push({ item, words });
      this.colourKey.append(created("li", {}, swatch, item));
    }
  }

  // A thing to drag, or another part of the state, which stays in the address: `get` has a number,
  // a list of numbers or a list of such lists, and `set` takes it back.
  /** @type {(name: string, get: () => any, set: (value: any) => void) => void} */
  keep(name, get, set) {
    this.kept.add(name, get, set);
  }

  // A mixture of two colours, with a share of the second from 0 to 1.
  /** @type {(one: string, two: string, share: number) => string} */
  mixed(one, two, share) {
    const percent = 100 * bounded(share, 0, 1);
    return `color-mix(in oklab, ${this.colours[two]} ${percent}%, ${this.colours[one]})`;
  }

  // A slider; `show` writes its value, by default with so many `digits` and a unit, and `moved`
  // gets it. One with `play()`, the change of its value in a second, has a button that moves it.
  /** @type {(label: Words, options: SliderOptions) => Slid} */
  slider(label, { min, max, step, value, unit = "", digits, play, show, moved }) {
    const input = created("input", { type: "range", min, max, step, value });
    const name = created("span");
    const shown = created("span", { className: "value" });
    const written = show ?? ((given) => `${digits ? given.toFixed(digits) : given} ${unit}`);
    /** @type {Row} */
    const row = { label, input, name, shown, play, plays: false, exact: value, show: written };
    const div = created("div", { className: "slider" }, created("label", {}, name, input), shown);
    input.addEventListener("input", () => {
      row.plays = false;
      moved?.(Number(input.value));
      this.requestDraw();
    });
    if (play) {
      row.button = created("button", { type: "button", className: "play" });
      row.button.addEventListener("click", () => {
        row.plays = !row.plays;
        row.exact =
          Number(input.value) < Number(input.max) ? Number(input.value) : Number(input.min);
        this.requestDraw();
      });
      div.append(row.button);
    }
    this.rows.push(row);
    this.controls.append(div);
    this.keep(
      label[0],
      () => Number(input.value),
      (given) => {
        input.value = given;
        input.dispatchEvent(new Event("input"));
      },
    );
    return {
      get value() {
        return Number(input.value);
      },
      set value(given) {
        input.value = String(given);
        row.plays = false;
      },
      get max() {
        return Number(input.max);
      },
      set max(given) {
        input.max = String(given);
      },
    };
  }

  // A button, whose words may change with the picture.
  /** @type {(label: () => Words, action: () => void) => void} */
  button(label, action) {
    const button = created("button", { type: "button" });
    button.addEventListener("click", () => {
      action();
      this.requestDraw();
    });
    this.buttons.push({ button, label });
    this.reset.before(button);
  }

  // A part of the canvas below those before, with a share of its height; `draw` takes the pane.
  // See `StagePane`.
  /** @type {(share: number, view: () => PaneView, draw: (pane: StagePane) => void) => StagePane} */
  pane(share, view, draw) {
    const pane = new StagePane(this, share, view, draw);
    this.panes.push(pane);
    return pane;
  }

  // A thing to drag at the point `at()` of a pane. `moved` takes the point to which it goes, and
  // from an arrow key, which moves it by `step`, also 1 (right, up) or -1; with Shift 10 or -10.
  // `released` is called when the pointer or the key is let go.
  /** @type {(label: Words, options: KnobOptions) => void} */
  knob(label, { pane = this.panes[0], at, moved, step = 0.05, small = false, released }) {
    const knob = created("button", { type: "button", className: small ? "small knob" : "knob" });
    /** @type {(point: Point, way?: number) => void} */
    const change = (point, way) => {
      moved(point, way);
      this.requestDraw();
    };
    knob.addEventListener("pointerdown", ({ pointerId }) => knob.setPointerCapture(pointerId));
    knob.addEventListener("pointermove", ({ pointerId, clientX, clientY }) => {
      const { left, top } = this.canvas.getBoundingClientRect();
      if (knob.hasPointerCapture(pointerId)) change(pane.inside(clientX - left, clientY - top));
    });
    knob.addEventListener("keydown", (event) => {
      if (!ARROWS[event.key]) return;
      event.preventDefault();
      const [x, y] = at();
      const [dx, dy] = ARROWS[event.key].map((part) => (event.shiftKey ? 10 * part : part));
      change(pane.inside(...pane.toScreen(x + step * dx, y + step * dy)), dx + dy);
    });
    for (const kind of released ? ["lostpointercapture", "keyup", "blur"] : []) {
      knob.addEventListener(kind, () => released?.());
    }
    this.knobs.push({ knob, label, pane, at });
    this.scene.append(knob);
  }

  // Lines drawn on a pane with mouse, pen or finger: `drawn` takes the points so far,
  // and whether the line ends.
  /** @type {(pane: StagePane, drawn: (points: Point[], ended: boolean) => void) => void} */
  pen(pane, drawn) {
    const { canvas } = this;
    /** @type {Point[]} */
    let points;
    /** @type {(ended: boolean) => void} */
    const change = (ended) => {
      drawn(points, ended);
      this.requestDraw();
    };
    canvas.classList.add("paper");
    canvas.addEventListener("pointerdown", ({ pointerId }) => {
      canvas.setPointerCapture(pointerId);
      points = [];
    });
    canvas.addEventListener("pointermove", ({ pointerId, offsetX, offsetY }) => {
      if (!canvas.hasPointerCapture(pointerId)) return;
      points.push(pane.toWorld(offsetX, offsetY));
      change(false);
    });
    canvas.addEventListener("lostpointercapture", () => change(true));
  }

  /** @type {(now: number) => void} */
  tick(now) {
    if (!this.canvas.isConnected) return; // Another one has taken its place.
    this.play(Math.min((now - this.painted) / 1000, LONGEST_FRAME));
    this.painted = now;
    this.resize();
    this.clear();
    this.update?.();
    this.kept.begin();
    let top = 0;
    // A picture in the list has the first part only, without charts.
    for (const pane of this.isSmall ? this.panes.slice(0, 1) : this.panes) {
      const height = (this.isSmall ? 1 : pane.share) * this.height;
      pane.paint(top, this.width, height);
      top += height;
    }
    this.write(this.width);
    this.kept.remember();
  }

  // The same picture in a smaller canvas.
  resize() {
    super.resize();
    if (!this.isSmall) return;
    this.width *= SMALLER;
    this.height *= SMALLER;
    this.context.scale(1 / SMALLER, 1 / SMALLER);
  }

  // Move the slider that plays, or the first one, or what the engine has played: a share of the way
  // from where it begins to the farther end.
  /** @type {(share: number) => void} */
  sweep(share) {
    const row = this.rows.find(({ play }) => play) ?? this.rows[0];
    if (row && !this.film) {
      const { input } = row;
      const [least, most] = [Number(input.min), Number(input.max)];
      const from = Number(input.defaultValue);
      const to = most - from > from - least ? most : least;
      input.value = String(from + share * (to - from));
    }
    this.filmed?.(share);
    this.requestDraw();
  }

  // Move the sliders that play.
  /** @type {(seconds: number) => void} */
  play(seconds) {
    for (const row of this.rows.filter(({ plays }) => plays)) {
      row.exact += seconds * (row.play?.() ?? 0);
      row.input.value = String(row.exact);
      row.plays = row.exact < Number(row.input.max);
      this.requestDraw();
    }
  }

  // Everything beside the canvas: texts, and where the knobs are.
  /** @type {(width: number) => void} */
  write(width) {
    for (const { label, input, show, name, shown, button, plays } of this.rows) {
      write(name, "textContent", this.say(label));
      write(shown, "textContent", show(Number(input.value)));
      write(input, "ariaValueText", shown.textContent);
      if (!button) continue;
      write(button, "textContent", plays ? "❚❚" : "▶");
      write(button, "ariaLabel", this.say(plays ? ["Pause", "暂停"] : ["Play", "播放"]));
    }
    for (const { item, words } of this.keys) write(item, "textContent", this.say(words));
    for (const { button, label } of this.buttons) write(button, "textContent", this.say(label()));
    for (const { knob, label, pane, at } of this.knobs) {
      const [x, y] = at();
      const [px, py] = pane.toScreen(x, y);
      Object.assign(knob.style, { left: `${px}px`, top: `${py}px` });
      knob.hidden = !(px >= 0 && px <= width && py >= pane.top && py <= pane.top + pane.height);
      write(knob, "ariaLabel", this.say(label));
    }
    write(this.canvas, "ariaLabel", this.say(this.label));
    // A screen reader does not read what changes with every picture.
    write(this.output, "ariaLive", this.rows.some(({ plays }) => plays) ? "off" : "polite");
    // No line ends between a number and its unit.
    write(
      this.output,
      "textContent",
      this.say(this.readout()).replace(/(?<=\d) (?=\p{L})/gu, "\u00a0"),
    );
  }
}

/** @type {(i: number) => string} */
const headAndBodies = (i) => (i === 0 ? "head" : "body");

// A part of the stage's canvas. `view()` is {x, y, size}: the middle of the floor in view and its
// height in m, and `wide`, its width, if that differs; or of a chart {across, up, name, tick} as in
// `axes`, with both languages' names.
class StagePane extends Pane {
  /**
   * @param {Lab} lab
   * @param {number} share
   * @param {() => PaneView} view
   * @param {(pane: StagePane) => void} draw
   */
  constructor(lab, share, view, draw) {
    super(lab.context, lab);
    this.lab = lab;
    this.share = share;
    this.view = view;
    this.draw = draw;
  }

  /** @type {(top: number, width: number, height: number) => void} */
  paint(top, width, height) {
    const { context, lab } = this;
    const view = this.view();
    this.top = top;
    this.width = width;
    this.height = height;
    context.save();
    context.beginPath();
    context.rect(0, top, width, height);
    context.clip();
    if ("size" in view) {
      const { x, y, size, wide = size } = view;
      const scale = Math.min(width / wide, height / size);
      this.x0 = x;
      this.y0 = y;
      this.sx = scale;
      this.sy = scale;
      this.left = width / 2;
      this.ceiling = top + height / 2;
    } else this.axes({ ...view, name: lab.say(view.name) });
    this.draw(this);
    context.restore();
  }

  // The point of the pane at a pixel, or the one nearest to it.
  /** @type {(px: number, py: number) => Point} */
  inside(px, py) {
    const { top, width, height } = this;
    return this.toWorld(bounded(px, 0, width), bounded(py, top, top + height));
  }

  // Benches in the colours that `colour` has for their numbers, each above those behind it.
  /**
   * @type {(
   *   benches: Benches<BenchSizes>,
   *   colour?: (i: number) => string,
   *   alpha?: number,
   * ) => void}
   */
  benches(benches, colour = headAndBodies, alpha = 1) {
    const { context } = this;
    Object.assign(context, { strokeStyle: this.colour("ink"), globalAlpha: alpha });
    context.lineWidth = bounded(0.02 * this.sx, 0.5, 1.25);
    for (let i = benches.model.benches - 1; i >= 0; i--) {
      const path = new Path2D();
      addPolygon(path, this, benches.corners(i));
      context.fillStyle = this.colour(colour(i));
      context.fill(path);
      context.stroke(path);
    }
    context.globalAlpha = 1;
  }
}

// 1, 2, 5, 10 and so on by their place, and for negative places 0.5, 0.2, 0.1.
/** @type {(place: number) => number} */
const roundNumber = (place) =>
  Number(`${[1, 2, 5][((place % 3) + 3) % 3]}e${Math.floor(place / 3)}`);

/** @type {(place: number) => string} */
const roundSeconds = (place) => `${roundNumber(place)} s`;

/** @type {(exponent: number) => string} */
const magnification = (exponent) => `× ${(10 ** exponent).toFixed(0)}`;

// Points of a curve between two coordinates, and of a circle.
/** @type {(curve: Curve, from: number, to: number, step?: number) => Point[]} */
function curvePoints(curve, from, to, step = 0.1) {
  return range(from, to, Math.max(Math.ceil((to - from) / step), 1)).map((s) => {
    const [x, y] = curve.frame(s);
    return [x, y];
  });
}

/** @type {(centre: Numbers, radius: number) => Point[]} */
function circlePoints([x, y], radius) {
  return range(0, TURN, 180).map((angle) => [
    x + radius * Math.cos(angle),
    y + radius * Math.sin(angle),
  ]);
}

// The coordinate of a curve between two others that is closest to a point.
/** @type {(curve: Curve, point: Numbers, from: number, to: number) => number} */
function nearestOn(curve, [x, y], from, to) {
  /** @type {(s: number) => number} */
  const apart = (s) => Math.hypot(curve.frame(s)[0] - x, curve.frame(s)[1] - y);
  const best = smallestOf(range(from, to, Math.ceil((to - from) / 0.1)), apart);
  return bounded(minimumBetween(apart, best - 0.1, best + 0.1), from, to);
}

// A pane of the floor where the head is closest to a bench, and a chart of its gap over time, where
// time is dragged. `benchesAt(t, handles)` are the benches; `draw` adds to the chart, as up to
// `now.seen`, the latest time so far.
/** @type {(lab: Lab, parts: GapParts) => GapNow} */
function gapPanes(lab, { time, size, benchesAt, view, draw }) {
  /** @type {GapNow} */
  const now = { seen: -Infinity, bench: 0, gap: Infinity, ends: [], update: () => {} };
  now.update = () =>
    Object.assign(now, nearestToHead(benchesAt(time.value, 14)), {
      seen: Math.max(now.seen, time.value),
    });
  lab.pane(
    0.5,
    () => ({ x: now.ends[0][0], y: now.ends[0][1], size: size() }),
    (pane) => {
      const hit = now.gap <= 0 ? now.bench : 0;
      pane.benches(benchesAt(time.value, 61), (i) =>
        i === 0 ? "head" : i === hit ? "contact" : "body",
      );
      pane.line(now.ends, { colour: "contact", width: 2 });
    },
  );
  const chart = lab.pane(0.5, view, (pane) => {
    const {
      across: [from, to],
      up: [bottom, top],
    } = view();
    const zero = bounded(0, bottom, top);
    pane.fill(
      [
        [from, zero],
        [to, zero],
        [to, bottom],
        [from, bottom],
      ],
      { colour: "contact", alpha: 0.15 },
    );
    draw(pane);
  });
  lab.knob(["The time: drag it along the chart", "时间：沿图表拖动"], {
    pane: chart,
    step: 0.01,
    at: () => [time.value, bounded(1000 * now.gap, ...view().up)],
    moved: ([t]) => {
      time.value = t;
    },
  });
  return now;
}
