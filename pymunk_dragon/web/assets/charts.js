// Charts of the last seconds: position error, tension along the chain, time of a step,
// and quantities of the scene.

const CHART_SECONDS = 20;
const LONGEST_GAP = 250; // ms: a longer pause between two frames counts as this
const MARGINS = { left: 56, right: 6, above: 6, below: 6 }; // pixels
const LABEL_GAP = 12; // pixels beside the values at the vertical axis
const CHART_EVERY = 100; // ms between two drawings of the charts
const ERROR_KNOWN = 1e-8; // m: errors are shown to a hundredth of a micrometre.
const MOST_ROWS = 100000; // rows of a table: three hours

// A chart with a canvas of its own, and values of the last seconds, in which pauses leave no gap.
class Chart extends Pane {
  /** @param {HTMLCanvasElement} canvas @param {Look} painter */
  constructor(canvas, painter) {
    super(/** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")), painter);
    this.canvas = canvas;
    this.size = 11;
    /** @type {Point[]} */
    this.samples = [];
    this.clock = 0;
    /** @type {number | null} */
    this.last = null;
  }

  clear() {
    this.samples.length = 0;
    this.clock = 0;
    this.last = null;
  }

  /** @type {(value: number, now: number) => void} */
  add(value, now) {
    this.clock += Math.min(now - (this.last ?? now), LONGEST_GAP) / 1000;
    this.last = now;
    this.samples.push([this.clock, value]);
    const old = this.samples.findIndex(([at]) => at >= this.begin);
    if (old > 100) this.samples.splice(0, old);
  }

  get begin() {
    return this.clock - CHART_SECONDS;
  }

  // The values that are finite.
  get values() {
    return this.samples.map(([, value]) => value).filter(Number.isFinite);
  }

  get shown() {
    return this.canvas.getClientRects().length > 0;
  }

  // Clear the canvas and draw the axes.
  /** @type {(up: Limits, tick?: (value: number) => string, across?: Limits) => void} */
  start(up, tick, across) {
    const { context } = this;
    context.reset();
    Object.assign(this, fitCanvas(this.canvas, context));
    // Values with many digits have more room.
    context.font = `${this.size}px ${this.look.font}`;
    const widest = tick
      ? Math.max(...up.map((value) => context.measureText(tick(value)).width))
      : 0;
    const margins = { ...MARGINS, left: Math.max(MARGINS.left, widest + LABEL_GAP) };
    const times = [this.begin, this.clock];
    this.axes({ across: across ?? times, up, tick, apart: 18, margins });
  }

  /** @type {(points?: Numbers[]) => void} */
  track(points = this.samples) {
    this.line(points, { colour: "any", width: 1.5 });
  }
}

// The decades around positive values, at least two of them:
// powers of ten of the lower and the upper end.
/** @type {(values: number[]) => Limits} */
function decadesAround(values) {
  const logs = values.filter((value) => value > 0).map(Math.log10);
  if (!logs.length) return [-2, 0];
  const high = Math.ceil(Math.max(...logs));
  return [Math.min(Math.floor(Math.min(...logs)), high - 2), high];
}

class LiveCharts {
  /** @param {Live} live */
  constructor(live) {
    this.live = live;
    const charts = ["error", "step", ...EFFORTS].map((name) => [
      name,
      new Chart(element(`chart-${name}`), live),
    ]);
    /** @type {Record<string, Chart>} */
    this.charts = Object.fromEntries(charts);
    this.drawn = 0;
    /** @type {Model} */
    this.model = NOTHING_YET;
    /** @type {Quantity[]} */
    this.quantities = [];
  }

  /** @type {(model: Model) => void} */
  setModel(model) {
    this.model = model;
    for (const chart of Object.values(this.charts)) chart.clear();
    element("charts-error").hidden = !model.can("exact");
    const names = model.benches ? [] : model.scene.plots; // a dragon has the charts above
    this.quantities = names.map(([name, unit]) => new Quantity(name, unit, this.live));
    element("charts-own").replaceChildren(...this.quantities.map(({ figure }) => figure));
    element("save-charts").hidden = !this.quantities.length;
  }

  /** @type {(frame: LiveFrame) => void} */
  add(frame) {
    const now = performance.now();
    this.charts.error.add(frame.errors.length ? 1000 * largestOf(frame.errors) : NaN, now);
    this.charts.step.add(1000 * frame.step_time, now);
    const { plots } = frame;
    if (plots) this.quantities.forEach((quantity, k) => quantity.add(frame.time, plots[k], now));
  }

  // The quantities as a table, one row for each time.
  get table() {
    const [first] = this.quantities;
    const names = ["time (s)", ...this.quantities.map(({ name }) => name)];
    const rows = first.rows.map(([time], row) => [
      time,
      ...this.quantities.map((quantity) => quantity.rows[row][1]),
    ]);
    const quoted = names.map((name) => `"${name.replaceAll('"', '""')}"`);
    return [quoted, ...rows].map((row) => row.join(",")).join("\n") + "\n";
  }

  // Draw at most ten times a second, and only what is visible.
  /** @type {(frame: LiveFrame, state: LiveState, now: number) => void} */
  draw(frame, state, now) {
    if (now - this.drawn < CHART_EVERY) return;
    this.drawn = now;
    const { error, step } = this.charts;
    const efforts = this.model.efforts(frame);
    if (error.shown) this.drawErrors(error, frame);
    for (const kind of EFFORTS) this.drawEfforts(kind, efforts, new Set(state.cuts));
    for (const quantity of this.quantities) quantity.draw();
    const step_length = state.values.step ?? 1000 * this.model.scene.step;
    if (step.shown) this.drawSteps(step, frame, step_length / state.speed);
  }

  /** @type {(chart: Chart, frame: LiveFrame) => void} */
  drawErrors(chart, { errors }) {
    chart.start(decadesAround(chart.values), powerText);
    chart.track(chart.samples.map(([at, value]) => [at, Math.log10(value)]));
    const worst = errors.reduce((one, value, i) => (value > (errors[one] ?? -1) ? i : one), -1);
    const error = formatError(errors[worst], ERROR_KNOWN);
    setText("value-error", worst < 0 ? "–" : localized("{error}, bench {i}", { error, i: worst }));
  }

  /** @type {(kind: Kind, efforts: Effort[], cuts: Set<number>) => void} */
  drawEfforts(kind, efforts, cuts) {
    const chart = this.charts[kind];
    const { bottom, top } = this.live.scales[kind];
    const joints = efforts.filter((joint) => joint.kind === kind);
    element(`charts-${kind}`).hidden = joints.length === 0;
    if (!chart.shown || !joints.length) return;
    /** @type {(joint: Effort) => boolean} */
    const isValid = ({ number, effort }) => effort > 0 && !cuts.has(number);
    /** @type {(joint: Effort) => number} */
    const upOf = (joint) => (isValid(joint) ? Math.max(Math.log10(joint.effort), bottom) : NaN);
    const points = joints.map((joint) => [joint.number, upOf(joint)]);
    chart.start([bottom, top], powerText, [-0.5, efforts.length - 0.5]);
    if (this.model.benches) chart.track(points);
    else {
      for (const [j, up] of points) {
        chart.line(
          [
            [j, bottom],
            [j, up],
          ],
          { colour: "any", width: 4 },
        );
      }
    }
    for (const j of cuts) {
      chart.line(
        [
          [j, bottom],
          [j, top],
        ],
        { colour: "contact" },
      );
    }
    const largest = largestOf(joints.filter(isValid).map(({ effort }) => effort));
    const worst = joints.find((joint) => isValid(joint) && joint.effort === largest);
    setText(
      `value-${kind}`,
      worst
        ? localized("{force}, joint {i}", { force: this.model.effortText(worst), i: worst.number })
        : "–",
    );
  }

  /** @type {(chart: Chart, frame: LiveFrame, budget: number) => void} */
  drawSteps(chart, { step_time }, budget) {
    chart.start([0, roundUp(Math.max(...chart.values, 1.05 * budget))]);
    chart.line(
      [
        [chart.begin, budget],
        [chart.clock, budget],
      ],
      { colour: "contact", width: 1.25 },
    );
    chart.track();
    const time = formatTime(1000 * step_time);
    const limit = formatTime(budget);
    setText("value-step", localized("{time} of {limit}", { time, limit }));
  }
}

/** @type {(ms: number) => string} */
const formatTime = (ms) => (Number.isFinite(ms) ? `${Number(ms.toPrecision(2))} ms` : "–");

// A chart of a quantity of the scene, with a linear scale.
class Quantity {
  /** @param {string} title @param {string} unit @param {Look} painter */
  constructor(title, unit, painter) {
    this.title = title;
    this.unit = unit && ` (${unit})`;
    this.name = title + this.unit;
    /** @type {[number, number | null][]} */
    this.rows = []; // [time, value] since the scene began, for the table
    this.value = created("span", {}, "–");
    this.caption = created("span");
    const canvas = created("canvas", { ariaHidden: "true" });
    this.figure = created(
      "figure",
      {},
      created("figcaption", {}, this.caption, " ", this.value),
      canvas,
    );
    this.chart = new Chart(canvas, painter);
  }

  /** @type {(time: number, value: number | null, now: number) => void} */
  add(time, value, now) {
    this.rows.push([time, value]);
    if (this.rows.length > MOST_ROWS) this.rows.shift();
    this.chart.add(value ?? NaN, now);
  }

  draw() {
    const { chart } = this;
    const { values } = chart;
    this.caption.textContent = translated(this.title) + this.unit;
    if (!chart.shown || !values.length) return;
    let low = Math.min(...values);
    let high = Math.max(...values);
    // A constant quantity has a line in the middle;
    // noise in its last digits does not fill the chart.
    const least = Math.max(Math.abs(low), Math.abs(high)) * 1e-4 || 1;
    if (high - low < least) [low, high] = [(low + high - least) / 2, (low + high + least) / 2];
    // Enough digits to tell the ticks apart.
    const digits = Math.max(
      2,
      Math.ceil(Math.log10((10 * Math.max(Math.abs(low), Math.abs(high))) / (high - low))),
    );
    const margin = (high - low) / 50;
    chart.start([low - margin, high + margin], (value) => numberText(value, digits));
    chart.track();
    this.value.textContent = numberText(lastOf(values));
  }
}
