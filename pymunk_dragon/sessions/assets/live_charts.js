// The three charts: position error, tension along the chain, and the time that a step takes.

const ERROR_KNOWN = 1e-8; // m: errors are shown to a hundredth of a micrometre.

class LiveCharts {
  constructor(painter) {
    this.painter = painter;
    this.history = new History();
    this.charts = Object.fromEntries(["error", "force", "step"].map((name) => [name, new Chart(element(`chart-${name}`))]));
    this.drawn = 0;
  }

  setModel(model) {
    this.model = model;
    this.history = new History();
    element("charts-error").hidden = !model.can("ghost");
    element("charts-force").hidden = model.joints.length === 0;
    this.setTexts();
  }

  setTexts() {
    setText("force-name", this.model.benches ? localized("Tension along the chain (N)") : localized("Force by joint (N)"));
  }

  add(frame, now) {
    this.history.add({ error: frame.errors.length ? 1000 * largestOf(frame.errors) : NaN, step: frame.stepTime }, now);
  }

  // Draw at most ten times a second, and only what is visible.
  draw(frame, state, now) {
    if (now - this.drawn < CHART_EVERY) return;
    this.drawn = now;
    const { error, force, step } = this.charts;
    if (error.shown) this.drawErrors(error, frame);
    if (force.shown) this.drawForces(force, frame, new Set(state.cuts));
    if (step.shown) this.drawSteps(step, frame, 1000 * this.model.scene.step / state.speed);
  }

  drawErrors(chart, { errors }) {
    const { colours, font } = this.painter;
    const track = this.history.track("error");
    const [low, high] = decadesAround(track.map(([, value]) => value));
    chart.begin(decadeTicks([low, high]), colours, font);
    chart.line(track.map(([across, value]) => [across, value > 0 ? (Math.log10(value) - low) / (high - low) : NaN]), colours.any);
    const worst = errors.reduce((one, value, i) => (value > (errors[one] ?? -1) ? i : one), -1);
    setText("value-error", worst < 0 ? "–" : localized("{error}, bench {i}", { error: formatError(errors[worst], ERROR_KNOWN), i: worst }));
  }

  drawForces(chart, { forces }, cuts) {
    const { colours, font, forceScale } = this.painter;
    const last = Math.max(1, forces.length - 1);
    const valid = (j) => forces[j] > 0 && !cuts.has(j);
    chart.begin(decadeTicks([forceScale.bottom, forceScale.top]), colours, font);
    if (this.model.benches) {
      chart.line(Array.from(forces, (force, j) => [j / last, valid(j) ? forceScale.share(force) : NaN]), colours.any);
    } else {
      forces.forEach((force, j) => {
        const across = (j + 0.5) / forces.length;
        if (valid(j)) chart.line([[across, 0], [across, forceScale.share(force)]], colours.any, 4);
      });
    }
    for (const j of cuts) chart.line([[j / last, 0], [j / last, 1]], colours.contact, 1);
    const worst = forces.reduce((one, value, j) => (valid(j) && value > (forces[one] ?? 0) ? j : one), -1);
    setText("value-force", worst < 0 ? "–" : localized("{force}, joint {i}", { force: formatForce(forces[worst]), i: worst }));
  }

  drawSteps(chart, { stepTime }, budget) {
    const { colours, font } = this.painter;
    const track = this.history.track("step");
    const top = roundUp(track.reduce((one, [, value]) => Math.max(one, value || 0), 1.05 * budget));
    chart.begin([0, 0.5, 1].map((share) => [share, String(Number((share * top).toPrecision(2)))]), colours, font);
    chart.horizontal(budget / top, colours.contact, 1.25);
    chart.line(track.map(([across, value]) => [across, value / top]), colours.any);
    setText("value-step", localized("{time} of {limit}", { time: formatTime(stepTime), limit: formatTime(budget) }));
  }
}

const formatForce = (force) => (!(force >= 0) ? "–" : force >= 1000 ? `${(force / 1000).toFixed(1)} kN` : `${Number(force.toPrecision(2))} N`);
const formatTime = (milliseconds) => (Number.isFinite(milliseconds) ? `${Number(milliseconds.toPrecision(2))} ms` : "–");
