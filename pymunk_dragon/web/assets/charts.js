// Charts of the last seconds: position error, tension along the chain, and time of a step.

const CHART_SECONDS = 20;
const LONGEST_GAP = 250; // ms: a longer pause between two frames counts as this
const MARGINS = { left: 56, right: 6, above: 6, below: 6 }; // pixels
const ROOM_BELOW = 24; // pixels below a chart with values at its horizontal axis
const TICKS_APART = [18, 45]; // pixels: least distances of values along the axes
const LABEL_GAP = 12; // pixels beside the values at the vertical axis
const CHART_EVERY = 100; // ms between two drawings of the charts
const ERROR_KNOWN = 1e-8; // m: errors are shown to a hundredth of a micrometre.

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
  /**
   * @type {(
   *   up: Limits,
   *   tick?: Tick,
   *   across?: Limits,
   *   tickAcross?: Tick,
   * ) => void}
   */
  start(up, tick, across, tickAcross) {
    const { context } = this;
    context.reset();
    Object.assign(this, fitCanvas(this.canvas, context));
    // Values with many digits have more room.
    context.font = `${this.size}px ${this.look.font}`;
    const widest = tick
      ? Math.max(...up.map((value) => context.measureText(tick(value)).width))
      : 0;
    const left = Math.max(MARGINS.left, widest + LABEL_GAP);
    const below = tickAcross ? ROOM_BELOW : MARGINS.below;
    const margins = { ...MARGINS, left, below };
    const times = [this.begin, this.clock];
    const [apart, apartAcross] = TICKS_APART;
    this.axes({ across: across ?? times, up, tick, tickAcross, apart, apartAcross, margins });
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
    // What the charts of quantities show, by the names of these: it outlasts a new start.
    /** @type {Record<string, string>} */
    this.views = {};
  }

  /** @type {(model: Model) => void} */
  setModel(model) {
    this.model = model;
    for (const chart of Object.values(this.charts)) chart.clear();
    element("charts-error").hidden = !model.can("exact");
    const names = model.benches ? [] : model.scene.plots; // a dragon has the charts above
    this.quantities = names.map(([name, unit]) => new Quantity(name, unit, this));
    element("charts-own").replaceChildren(...this.quantities.map(({ figure }) => figure));
    element("save-charts").hidden = !this.quantities.length;
  }

  /** @type {(canvas: HTMLCanvasElement) => Chart} */
  chartOn(canvas) {
    return new Chart(canvas, this.live);
  }

  // Write the choices of all quantities, in the page's language.
  nameViews() {
    for (const quantity of this.quantities) quantity.nameViews();
  }

  /** @type {(frame: LiveFrame) => void} */
  add(frame) {
    const now = performance.now();
    this.charts.error.add(frame.errors.length ? 1000 * largestOf(frame.errors) : NaN, now);
    this.charts.step.add(1000 * frame.step_time, now);
  }

  // Values of the quantities, which also come while nothing is drawn.
  /** @type {(found: { time: number, values: (number | null)[] }) => void} */
  addValues({ time, values }) {
    const now = performance.now();
    this.quantities.forEach((quantity, k) => quantity.add(time, values[k], now));
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
