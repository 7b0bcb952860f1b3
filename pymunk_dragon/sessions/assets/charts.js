// Charts of the last seconds.

const CHART_SECONDS = 20;
const LONGEST_GAP = 250; // ms: a longer pause between two frames counts as this
const CHART_LEFT = 56; // pixels: room for numbers at the left
const CHART_EDGE = 6; // pixels: room at the other sides
const CHART_EVERY = 100; // ms between two drawings of the charts

// Values of the last seconds. Pauses leave no gap.
class History {
  constructor() {
    this.samples = [];
    this.clock = 0;
  }

  add(values, now) {
    this.clock += Math.min(now - (this.last ?? now), LONGEST_GAP);
    this.last = now;
    this.samples.push({ at: this.clock, ...values });
    const begin = this.clock - 1000 * CHART_SECONDS;
    let old = 0;
    while (this.samples[old].at < begin) old++;
    if (old > 100) this.samples.splice(0, old);
  }

  // Pairs [share of the width, value] of one quantity.
  track(name) {
    const begin = this.clock - 1000 * CHART_SECONDS;
    return this.samples.filter(({ at }) => at >= begin).map((sample) => [(sample.at - begin) / (1000 * CHART_SECONDS), sample[name]]);
  }
}

// A small canvas with horizontal lines at `ticks` [share of the height, text].
class Chart {
  constructor(canvas, painter) {
    Object.assign(this, { canvas, painter, context: canvas.getContext("2d") });
  }

  get shown() {
    return this.canvas.getClientRects().length > 0;
  }

  begin(ticks) {
    const { canvas, context, painter: { colours, font } } = this;
    const { width, height } = canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    Object.assign(this, { width, height });
    const [wide, high] = [width, height].map((size) => Math.max(1, Math.round(size * ratio)));
    if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = `11px ${font}`;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.lineJoin = "round";
    for (const [share, text] of ticks) {
      context.fillStyle = colours.quiet;
      context.fillText(text, CHART_LEFT - 6, this.toY(share));
      this.horizontal(share, colours.rule, 1);
    }
  }

  toX(share) {
    return CHART_LEFT + share * (this.width - CHART_LEFT - CHART_EDGE);
  }

  toY(share) {
    return this.height - CHART_EDGE - Math.min(Math.max(share, 0), 1) * (this.height - 2 * CHART_EDGE);
  }

  horizontal(share, colour, width) {
    this.line([[0, share], [1, share]], colour, width);
  }

  // A line through points [share of the width, share of the height]; numbers that are not finite interrupt it.
  line(points, colour = this.painter.colours.any, width = 1.5) {
    const { context } = this;
    context.beginPath();
    let drawing = false;
    for (const [across, up] of points) {
      const valid = Number.isFinite(up);
      if (valid && drawing) context.lineTo(this.toX(across), this.toY(up));
      else if (valid) context.moveTo(this.toX(across), this.toY(up));
      drawing = valid;
    }
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
  }
}

// The decades around positive values, at least two of them: powers of ten of the lower and the upper end.
function decadesAround(values) {
  const logs = values.filter((value) => value > 0).map((value) => Math.log10(value));
  if (!logs.length) return [-2, 0];
  const high = Math.ceil(logs.reduce((one, two) => Math.max(one, two)));
  const low = Math.floor(logs.reduce((one, two) => Math.min(one, two)));
  return [Math.min(low, high - 2), high];
}

// Ticks at powers of ten, at most five of them.
function decadeTicks([low, high]) {
  const stride = Math.ceil((high - low) / 4);
  const powers = Array.from({ length: high - low + 1 }, (_, k) => low + k).filter((power) => (power - low) % stride === 0);
  return powers.map((power) => [(power - low) / (high - low), powerText(power)]);
}
