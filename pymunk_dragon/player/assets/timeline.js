// Events by time: near misses and contacts, as a list and as a strip above the slider.

const THUMB = 8; // pixels: half the slider's thumb, the margin of the strip on both sides
const CLICK = 7; // pixels: largest distance of a click from an event

function eventsOf(payload) {
  const name = ([i, j]) => `benches ${i} and ${j}`;
  const nearMisses = payload.near_misses.map(({ time, benches, gap }) => ({
    time, end: time, kind: "near-miss",
    text: `Near miss: ${name(benches)}, ${formatLength(gap, 0)}`,
  }));
  const contacts = payload.windows.map(({ begin, end, benches }) => ({
    time: begin, end: end ?? payload.times.at(-1), kind: "contact",
    text: `Contact: ${name(benches)}` + (end === null ? "" : `, for ${(end - begin).toFixed(2)} s`),
  }));
  return [...nearMisses, ...contacts].sort((a, b) => a.time - b.time);
}

class Timeline {
  constructor(strip, motion, events) {
    this.strip = strip;
    this.motion = motion;
    this.events = events;
  }

  // Pixels from the left.
  toPixel(time) {
    const { begin, end } = this.motion;
    return THUMB + (this.width - 2 * THUMB) * (end > begin ? (time - begin) / (end - begin) : 0);
  }

  timeAt(px) {
    const { begin, end } = this.motion;
    const fraction = (px - THUMB) / Math.max(1, this.width - 2 * THUMB);
    return begin + Math.min(Math.max(fraction, 0), 1) * (end - begin);
  }

  // Time of the event close to a click, or the clicked time if there is none.
  timeOfClick(px) {
    const distance = (event) => Math.abs(this.toPixel(event.time) - px);
    const near = this.events.filter((event) => distance(event) <= CLICK).sort((a, b) => distance(a) - distance(b));
    return near.length ? near[0].time : this.timeAt(px);
  }

  // Draws only if the strip's size or the colours have changed.
  draw(colours) {
    const { width, height } = this.strip.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const state = [width, height, ratio, colours.type].join();
    if (state === this.drawn) return;
    this.drawn = state;
    this.width = width;
    Object.assign(this.strip, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    const context = this.strip.getContext("2d");
    context.scale(ratio, ratio);
    const middle = height / 2;
    for (const event of this.events.filter(({ kind }) => kind === "contact")) {
      context.fillStyle = colours.contact;
      const from = this.toPixel(event.time);
      context.fillRect(from - 1.5, 1, Math.max(3, this.toPixel(event.end) - from), height - 2);
    }
    for (const event of this.events.filter(({ kind }) => kind === "near-miss")) {
      const px = this.toPixel(event.time);
      context.beginPath();
      context.moveTo(px, middle - 5);
      context.lineTo(px + 4, middle);
      context.lineTo(px, middle + 5);
      context.lineTo(px - 4, middle);
      context.closePath();
      context.fillStyle = colours.head;
      context.strokeStyle = colours.type;
      context.lineWidth = 1;
      context.fill();
      context.stroke();
    }
  }
}
