// Events by time: near misses and contacts, as a list and on a timeline above the slider,
// also of a part of the run.

const THUMB = 8; // pixels: half the slider's thumb, the margin of the strip on both sides
const CLICK = 7; // pixels: largest distance of a click from an event
const SHORTEST_PART = 0.2; // s: shortest part of the run on the timeline
const MARGIN = 0.1; // fraction of the part between its end and a time that has left it
const MARK = 5; // pixels: half the height of a mark
const LABEL_EVERY = 64; // pixels: least distance of labels
const LABEL_SIZE = 10; // pixels

/** @type {(recording: Recording) => RunEvent[]} */
function eventsOf(recording) {
  const nearMisses = recording.nearMisses.map(({ time, benches: [i, j], gap }) => ({
    time,
    end: time,
    kind: "near-miss",
    get text() {
      return localized("Near miss: benches {i} and {j}, {gap}", {
        i,
        j,
        gap: formatLength(gap, 0),
      });
    },
  }));
  const contacts = recording.windows.map(({ begin, end, benches: [i, j] }) => ({
    time: begin,
    end: end ?? recording.end,
    kind: "contact",
    get text() {
      const contact = localized("Contact: benches {i} and {j}", { i, j });
      return end === null
        ? contact
        : contact + localized(", for {time} s", { time: (end - begin).toFixed(2) });
    },
  }));
  return [...nearMisses, ...contacts].sort((a, b) => a.time - b.time);
}

class Timeline {
  /**
   * @param {HTMLCanvasElement} strip
   * @param {HTMLInputElement} slider
   * @param {Recording} recording
   * @param {RunEvent[]} events
   */
  constructor(strip, slider, recording, events) {
    this.strip = strip;
    this.context = /** @type {CanvasRenderingContext2D} */ (strip.getContext("2d"));
    this.slider = slider;
    this.recording = recording;
    this.events = events;
    this.width = 1;
    this.from = 0;
    this.length = 0;
    this.drawn = "";
    this.setPart(recording.begin, Infinity);
  }

  get isWhole() {
    return this.length >= this.recording.end - this.recording.begin;
  }

  // Show from a time on so many seconds, within the run.
  /** @type {(from: number, length: number) => void} */
  setPart(from, length) {
    const { begin, end } = this.recording;
    this.length = Math.min(Math.max(length, SHORTEST_PART), end - begin);
    this.from = Math.min(Math.max(from, begin), end - this.length);
  }

  get to() {
    return this.from + this.length;
  }

  // Zoom around a pixel, as a view does.
  /** @type {(factor: number, px: number, py: number, time?: number) => void} */
  zoom(factor, px, py, time = this.timeAt(px)) {
    const share = this.length > 0 ? (time - this.from) / this.length : 0;
    const length = Math.max(this.length / factor, SHORTEST_PART);
    this.setPart(time - share * length, length);
  }

  /** @type {(dx: number) => void} */
  pan(dx) {
    this.setPart(this.from - (dx * this.length) / this.inner, this.length);
  }

  // Move the part so that it has a time.
  /** @type {(time: number) => void} */
  reveal(time) {
    if (time > this.to) this.setPart(time - MARGIN * this.length, this.length);
    else if (time < this.from) this.setPart(time - (1 - MARGIN) * this.length, this.length);
  }

  // Pixels between the ends of the slider's range.
  get inner() {
    return Math.max(1, this.width - 2 * THUMB);
  }

  // Pixels from the left.
  /** @type {(time: number) => number} */
  toPixel(time) {
    return THUMB + this.inner * (this.length > 0 ? (time - this.from) / this.length : 0);
  }

  /** @type {(px: number) => number} */
  timeAt(px) {
    return this.from + Math.min(Math.max((px - THUMB) / this.inner, 0), 1) * this.length;
  }

  // Time of the event close to a click, or the clicked time if there is none.
  /** @type {(px: number) => number} */
  timeOfClick(px) {
    /** @type {(event: RunEvent) => number} */
    const distance = (event) => Math.abs(this.toPixel(event.time) - px);
    const near = this.events
      .filter((event) => distance(event) <= CLICK)
      .sort((a, b) => distance(a) - distance(b));
    return near.length ? near[0].time : this.timeAt(px);
  }

  // Draws only if the strip's size, the part or the colours have changed.
  /** @type {(look: Look) => void} */
  draw(look) {
    const { context } = this;
    const { width, height } = fitCanvas(this.strip, context);
    const state = [width, height, devicePixelRatio, look.colours.text, this.from, this.to].join();
    if (state === this.drawn) return;
    this.drawn = state;
    this.width = width;
    Object.assign(this.slider, { min: this.from, max: this.to });
    context.clearRect(0, 0, width, height);
    this.drawLabels(context, look);
    const middle = height - MARK - 2;
    const shown = this.events.filter(({ time, end }) => end >= this.from && time <= this.to);
    for (const event of shown.filter(({ kind }) => kind === "contact")) {
      context.fillStyle = look.colours.contact;
      const from = Math.max(this.toPixel(event.time) - 1.5, THUMB - 1.5);
      const to = Math.min(this.toPixel(event.end), width - THUMB);
      context.fillRect(from, middle - MARK - 1, Math.max(3, to - from), 2 * MARK + 2);
    }
    for (const event of shown.filter(({ kind }) => kind === "near-miss")) {
      const px = this.toPixel(event.time);
      const path = new Path2D(
        `M${px} ${middle - MARK}l${MARK - 1} ${MARK}l${1 - MARK} ${MARK}l${1 - MARK} ${-MARK}z`,
      );
      context.fillStyle = look.colours.head;
      context.fill(path);
      strokeOnce(context, path, look.colours.text, 1);
    }
  }

  // Round times at the upper side.
  /** @type {(context: CanvasRenderingContext2D, look: Look) => void} */
  drawLabels(context, { colours, font }) {
    context.font = `${LABEL_SIZE}px ${font}`;
    context.textBaseline = "top";
    context.textAlign = "center";
    context.fillStyle = context.strokeStyle = colours.quiet;
    for (const time of ticks(
      this.from,
      this.to,
      this.inner / LABEL_EVERY / (this.length || Number.EPSILON),
    )) {
      const px = this.toPixel(time);
      const label = signed(time);
      const half = context.measureText(label).width / 2;
      if (px - half < 0 || px + half > this.width) continue;
      context.fillText(label, px, 0);
    }
  }
}

// ---- slow motion near events: the speed falls in proportion to the time to the nearest one

const SLOWEST = 1 / 8; // simulated over real time
const APPROACH = 2; // 1/s: speed over the time to the event
// s: a contact that begins so soon after another one has no slow motion of its own.
const APART = 2;

// Times of the events that playing slows down at: near misses,
// and contacts after a time without one.
/** @type {(events: RunEvent[]) => number[]} */
function slowTimes(events) {
  const begins = events.filter(({ kind }) => kind === "contact").map(({ time }) => time);
  return [
    ...events.filter(({ kind }) => kind === "near-miss").map(({ time }) => time),
    ...begins.filter((time, k) => k === 0 || time - begins[k - 1] > APART),
  ];
}

// The speed at a time, no higher than the chosen `rate`.
/** @type {(rate: number, time: number, times: number[]) => number} */
function slowedRate(rate, time, times) {
  const distance = times.reduce((least, each) => Math.min(least, Math.abs(each - time)), Infinity);
  return Math.min(rate, Math.max(SLOWEST, APPROACH * distance));
}
