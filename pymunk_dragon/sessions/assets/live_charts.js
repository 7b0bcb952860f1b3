// The three charts: position error, tension along the chain, and the time that a step takes.

const ERROR_KNOWN = 1e-8; // m: errors are shown to a hundredth of a micrometre.

class LiveCharts {
  constructor(painter) {
    this.painter = painter;
    this.history = new History();
    this.charts = Object.fromEntries(["error", "force", "step"].map((name) => [name, new Chart(element(`chart-${name}`), painter)]));
    this.drawn = 0;
  }

  setModel(model) {
    this.model = model;
    this.history = new History();
    element("charts-error").hidden = !model.can("ghost");
    this.quantities = model.scene.plots.map((name) => new Quantity(name, model.unitOf(name), this.painter));
    element("charts-own").replaceChildren(...this.quantities.map(({ figure }) => figure));
    element("save-charts").hidden = !this.quantities.length;
    this.setTexts();
  }

  setTexts() {
    setText("force-name", this.model.benches ? localized("Tension along the chain (N)")
      : localized("Force by joint ({unit})", { unit: this.model.forceUnit }));
  }

  add(frame) {
    const now = performance.now();
    this.history.add({ error: frame.errors.length ? 1000 * largestOf(frame.errors) : NaN, step: 1000 * frame.step_time }, now);
    if (frame.plots) this.quantities.forEach((quantity, k) => quantity.add(frame.time, frame.plots[k], now));
  }

  // The quantities as a table, one row for each time.
  get table() {
    const [first] = this.quantities;
    const names = ["time (s)", ...this.quantities.map(({ name }) => name)].map((name) => `"${name.replaceAll('"', '""')}"`);
    const rows = first.rows.map(([time], row) => [time, ...this.quantities.map(({ rows }) => rows[row][1])]);
    return [names, ...rows].map((row) => row.join(",")).join("\n") + "\n";
  }

  // Draw at most ten times a second, and only what is visible.
  draw(frame, state, now) {
    if (now - this.drawn < CHART_EVERY) return;
    this.drawn = now;
    const { error, force, step } = this.charts;
    if (error.shown) this.drawErrors(error, frame);
    if (force.shown) this.drawForces(force, frame, new Set(state.cuts));
    for (const quantity of this.quantities) quantity.draw();
    const step_length = (state.values.step ?? 1000 * this.model.scene.step);
    if (step.shown) this.drawSteps(step, frame, step_length / state.speed);
  }

  drawErrors(chart, { errors }) {
    const track = this.history.track("error");
    const [low, high] = decadesAround(track.map(([, value]) => value));
    chart.begin(decadeTicks([low, high]));
    chart.line(track.map(([across, value]) => [across, value > 0 ? (Math.log10(value) - low) / (high - low) : NaN]));
    const worst = errors.reduce((one, value, i) => (value > (errors[one] ?? -1) ? i : one), -1);
    setText("value-error", worst < 0 ? "–" : localized("{error}, bench {i}", { error: formatError(errors[worst], ERROR_KNOWN), i: worst }));
  }

  drawForces(chart, frame, cuts) {
    const forces = this.model.benches ? frame.forces : Array.from(rowsOf(frame.joints, JOINT_SIZE), (row) => row[4]);
    element("charts-force").hidden = forces.length === 0;
    const { colours, forceScale } = this.painter;
    const last = Math.max(1, forces.length - 1);
    const valid = (j) => forces[j] > 0 && !cuts.has(j);
    chart.begin(decadeTicks([forceScale.bottom, forceScale.top]));
    if (this.model.benches) {
      chart.line(Array.from(forces, (force, j) => [j / last, valid(j) ? forceScale.share(force) : NaN]));
    } else {
      forces.forEach((force, j) => {
        const across = (j + 0.5) / forces.length;
        if (valid(j)) chart.line([[across, 0], [across, forceScale.share(force)]], colours.any, 4);
      });
    }
    for (const j of cuts) chart.line([[j / last, 0], [j / last, 1]], colours.contact, 1);
    const worst = forces.reduce((one, value, j) => (valid(j) && value > (forces[one] ?? 0) ? j : one), -1);
    setText("value-force", worst < 0 ? "–" : localized("{force}, joint {i}", { force: this.model.forceText(forces[worst]), i: worst }));
  }

  drawSteps(chart, { step_time }, budget) {
    const stepTime = 1000 * step_time;
    const track = this.history.track("step");
    const top = roundUp(track.reduce((one, [, value]) => Math.max(one, value || 0), 1.05 * budget));
    chart.begin([0, 0.5, 1].map((share) => [share, String(Number((share * top).toPrecision(2)))]));
    chart.horizontal(budget / top, this.painter.colours.contact, 1.25);
    chart.line(track.map(([across, value]) => [across, value / top]));
    setText("value-step", localized("{time} of {limit}", { time: formatTime(stepTime), limit: formatTime(budget) }));
  }
}

const formatTime = (milliseconds) => (Number.isFinite(milliseconds) ? `${Number(milliseconds.toPrecision(2))} ms` : "–");

// A chart of a quantity of the scene, with a linear scale.
class Quantity {
  constructor(name, unit, painter) {
    this.name = unit ? `${name} (${unit})` : name;
    this.rows = []; // [time, value] since the scene began, for the table
    this.history = new History();
    this.value = created("span", {}, "–");
    const canvas = created("canvas", { ariaHidden: "true" });
    this.figure = created("figure", {}, created("figcaption", {}, created("span", {}, unit ? `${translated(name)} (${unit})` : name), " ", this.value), canvas);
    this.chart = new Chart(canvas, painter);
  }

  add(time, value, now) {
    this.rows.push([time, value]);
    if (this.rows.length > MOST_ROWS) this.rows.shift();
    this.history.add({ value: value ?? NaN }, now);
  }

  draw() {
    if (!this.chart.shown) return;
    const track = this.history.track("value");
    const values = track.map(([, value]) => value).filter(Number.isFinite);
    if (!values.length) return;
    let [low, high] = [Math.min(...values), Math.max(...values)];
    // A constant quantity has a line in the middle; noise in its last digits does not fill the chart.
    const least = Math.max(Math.abs(low), Math.abs(high)) * 1e-4 || 1;
    if (high - low < least) [low, high] = [(low + high - least) / 2, (low + high + least) / 2];
    // Enough digits to tell the ticks apart.
    const digits = Math.max(2, Math.ceil(Math.log10(2 * Math.max(Math.abs(low), Math.abs(high)) / (high - low))));
    this.chart.begin([0, 0.5, 1].map((share) => [share, numberText(low + share * (high - low), digits)]));
    this.chart.line(track.map(([across, value]) => [across, (value - low) / (high - low)]));
    this.value.textContent = numberText(values.at(-1));
  }
}

const MOST_ROWS = 100000; // rows of a table: three hours
