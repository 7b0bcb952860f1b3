// Charts of the quantities of a scene: over time, as a histogram, or against another quantity.

const MOST_ROWS = 100000; // rows of a table: three hours
const ROWS_SHOWN = 6000; // rows in histograms, and against others: ten minutes
const MOST_BARS = 20; // bars of a histogram
const LEAST_SPAN = 1e-4; // of a value: noise in its last digits does not fill a chart
const SPARE = 1 / 50; // of a range, at both ends

// The range of values; that of a constant quantity has the constant in its middle.
/** @type {(values: number[]) => Limits} */
function limitsOf(values) {
  const low = Math.min(...values);
  const high = Math.max(...values);
  const least = Math.max(Math.abs(low), Math.abs(high)) * LEAST_SPAN || 1;
  const lack = Math.max(0, least - (high - low)) / 2;
  const margin = (high - low + 2 * lack) * SPARE;
  return [low - lack - margin, high + lack + margin];
}

// Writes the values in a range with enough digits to tell the ticks apart.
/** @type {(limits: Limits) => Tick} */
function ticksIn([low, high]) {
  const size = Math.max(Math.abs(low), Math.abs(high));
  const digits = Math.max(2, Math.ceil(Math.log10((10 * size) / (high - low))));
  return (value) => numberText(value, digits);
}

// The bars of a histogram: the width, and the first value and the number of each. Whole numbers
// that are few have a bar each, with the number in its middle.
/** @type {(values: number[]) => { width: number, bars: [number, number][] }} */
function histogramOf(values) {
  const [low, high] = limitsOf(values);
  const areWhole = values.every(Number.isInteger);
  const width = Math.max(roundUp((high - low) / MOST_BARS), areWhole ? 1 : 0);
  const shift = areWhole && width === 1 ? 0.5 : 0;
  /** @type {Map<number, number>} */
  const counts = new Map();
  for (const value of values) {
    const bar = Math.floor(value / width + shift);
    counts.set(bar, (counts.get(bar) ?? 0) + 1);
  }
  return { width, bars: [...counts].map(([bar, count]) => [(bar - shift) * width, count]) };
}

class Quantity {
  /** @param {string} title @param {string} unit @param {LiveCharts} charts */
  constructor(title, unit, charts) {
    this.title = title;
    this.unit = unit && ` (${unit})`;
    this.name = title + this.unit;
    this.charts = charts;
    /** @type {[number, number | null][]} */
    this.rows = []; // [time, value] since the scene began, for the table
    this.value = created("span", {}, "–");
    const onchange = () => {
      charts.views[this.name] = this.select.value;
    };
    this.select = created("select", { className: "view", onchange });
    const canvas = created("canvas", { ariaHidden: "true" });
    this.figure = created("figure", {}, created("figcaption", {}, this.select, this.value), canvas);
    this.chart = charts.chartOn(canvas);
  }

  // "time", "histogram", or the name of another quantity.
  get view() {
    return this.charts.views[this.name] ?? "time";
  }

  // The name in the page's language.
  get shownName() {
    return translated(this.title) + this.unit;
  }

  // The caption is a list of what the chart may show.
  nameViews() {
    const name = this.shownName;
    this.select.replaceChildren(
      new Option(name, "time"),
      new Option(localized("{name}: histogram", { name }), "histogram"),
    );
    for (const other of this.charts.quantities) {
      if (other === this) continue;
      const text = localized("{name} against {other}", { name, other: other.shownName });
      this.select.add(new Option(text, other.name));
    }
    this.select.value = this.view;
    this.select.ariaLabel = localized("What the chart shows");
  }

  /** @type {(time: number, value: number | null, now: number) => void} */
  add(time, value, now) {
    this.rows.push([time, value]);
    if (this.rows.length > MOST_ROWS) this.rows.shift();
    this.chart.add(value ?? NaN, now);
  }

  draw() {
    const { chart, view } = this;
    const { values } = chart;
    chart.canvas.classList.toggle("tall", view !== "time");
    if (!chart.shown || !values.length) return;
    this.value.textContent = numberText(lastOf(values));
    const other = this.charts.quantities.find(({ name }) => name === view);
    if (other) this.drawAgainst(other);
    else if (view === "histogram") this.drawHistogram();
    else {
      const limits = limitsOf(values);
      chart.start(limits, ticksIn(limits));
      chart.track();
    }
  }

  // The newest values.
  get shownRows() {
    return this.rows.slice(-ROWS_SHOWN).map(([, value]) => value ?? NaN);
  }

  drawHistogram() {
    const { chart } = this;
    const { width, bars } = histogramOf(this.shownRows.filter(Number.isFinite));
    const begins = bars.map(([begin]) => begin);
    /** @type {Limits} */
    const across = [Math.min(...begins), Math.max(...begins) + width];
    const most = Math.max(...bars.map(([, count]) => count));
    /** @type {Limits} */
    const up = [0, most * (1 + SPARE)];
    chart.start(up, ticksIn(up), across, ticksIn(across));
    for (const [begin, count] of bars) {
      const end = begin + width;
      const corners = [
        [begin, 0],
        [begin, count],
        [end, count],
        [end, 0],
      ];
      chart.fill(corners, { colour: "any", alpha: 0.6 });
      chart.line(corners, { colour: "any" });
    }
  }

  /** @type {(other: Quantity) => void} */
  drawAgainst(other) {
    const { chart } = this;
    const xs = other.shownRows;
    const points = this.shownRows.map((y, row) => [xs[row], y]);
    const known = points.filter(([x, y]) => Number.isFinite(x + y));
    if (!known.length) return;
    const across = limitsOf(known.map(([x]) => x));
    const up = limitsOf(known.map(([, y]) => y));
    chart.start(up, ticksIn(up), across, ticksIn(across));
    chart.track(points);
    chart.dot(lastOf(known), { colour: "any" });
  }
}
