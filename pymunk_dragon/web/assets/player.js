// The player: its time, its view and what is shown. Controls call its methods.

const RATES = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50]; // simulated over real time
// s: longest playing time at the default rate, which is the lowest such rate from 1 on.
const LONGEST = 60;
const LAST_PART = 10; // s: a button plays so much of the end of the run
// s: most between two pictures, so that no run jumps after the computer was suspended.
const LONGEST_TICK = 0.25;
// ms: between changes of the address; browsers refuse more than some 200 in half a minute.
const LINK_EVERY = 500;
// ms: delay after the last input before the state is announced to screen readers.
const ANNOUNCE_AFTER = 700;

// The first is the lowest.
const RUN_LAYERS = [
  drawGrid,
  drawCurve,
  drawDragon,
  drawGhosts,
  drawHandles,
  drawVelocities,
  drawNumbers,
  drawContacts,
];

/** @extends {Stage<RunPicture>} */
class Player extends Stage {
  /** @param {Recording} recording */
  constructor(recording) {
    super(recording, RUN_LAYERS, RUN_SWITCHES, SHOWN_OF_RUN);
    this.recording = recording;
    this.events = eventsOf(recording);
    this.eventTimes = this.events.map(({ time }) => time);
    this.timeline = new Timeline(element("strip"), element("time"), recording, this.events);
    this.time = recording.begin;
    this.length = recording.end - recording.begin;
    this.defaultRate =
      RATES.find((rate) => rate >= 1 && this.length / rate <= LONGEST) ?? RATES[RATES.length - 1];
    this.rate = this.defaultRate;
    this.slowTimes = slowTimes(this.events);
    this.slow = true; // near events
    this.playing = false;
    /** @type {number | null} */
    this.selected = null; // a bench
    /** @type {number | null} */
    this.last = null; // ms: time of the last picture
    this.announceTimer = 0;
    this.moment = recording.momentAt(this.time);
    const write = () => rememberAddress(formatLink(this));
    this.writeLinkSoon = throttled(write, LINK_EVERY);
  }

  // ---- drawing

  /** @type {(now: number) => void} */
  tick(now) {
    if (this.playing) {
      const passed = this.last === null ? 0 : Math.min((now - this.last) / 1000, LONGEST_TICK);
      this.last = now;
      const before = this.time;
      this.time = Math.min(before + passed * this.currentRate, this.recording.end);
      const event = this.events.findLast(({ time }) => before < time && time <= this.time);
      if (event) setText("announcement", event.text);
      if (this.time >= this.recording.end) this.pause();
      else this.writeLinkSoon();
    }
    this.draw();
    if (this.playing) this.requestDraw();
  }

  draw() {
    const { recording, time, shown } = this;
    const moment = (this.moment = recording.momentAt(time));
    const { benches } = moment;
    this.resize();
    this.timeline.reveal(time);
    this.timeline.draw(this);
    this.followSubject([benches.poses.x[0], benches.poses.y[0]]);

    const hovered = this.pixel && bodyAt(this.view.toWorld(...this.pixel), 0, moment)?.bench;
    const pointed = hovered ?? this.selected;
    const errors = recording.exact?.errorsAt(time) ?? null;
    const magnification = errors ? this.magnification(benches, errors) : 1;
    this.painter.draw({
      ...moment,
      show: shown,
      pointed,
      ghosts: shown.exact ? recording.ghostsAt(time, benches, magnification) : null,
      velocities: shown.velocities ? recording.velocitiesOf(benches.poses) : null,
    });
    this.showTime();
    this.showBench(pointed ?? 0, errors, magnification);
  }

  // The numbers of a bench.
  /** @type {(bench: number, errors: number[] | null, magnification: number) => void} */
  showBench(bench, errors, magnification) {
    const { benches } = this.moment;
    if (document.activeElement !== element("bench")) element("bench").value = String(bench);
    const numbers = formatNumbers(benchNumbers(benches, bench, this.time));
    for (const [id, text] of Object.entries(numbers)) setText(id, text);
    const { exact } = this.recording;
    setText("error", errors && exact ? formatError(errors[bench], exact.resolution) : "–");
    setText(
      "legend-exact-text",
      magnification === 1
        ? localized("Exact model")
        : localized("Exact model, error × {number}", {
            number: magnification.toLocaleString("en"),
          }),
    );
  }

  showTime() {
    const { time, timeline } = this;
    setText("clock", time.toFixed(2));
    setText("reduced", this.currentRate < this.rate ? formatRate(this.currentRate) : "");
    element("time").value = String(time);
    // Only while paused: screen readers would announce every change.
    if (!this.playing) {
      element("time").ariaValueText = localized("{time} seconds", { time: time.toFixed(2) });
    }
    element("timeline-out").disabled = element("timeline-all").disabled = timeline.isWhole;
  }

  // So that the largest position error in the view is visible.
  /** @type {(benches: Benches<Recording>, errors: number[]) => number} */
  magnification(benches, errors) {
    const { scale } = this.view;
    const worst = this.painter.visible(benches).reduce((most, i) => Math.max(most, errors[i]), 0);
    return magnificationOf(worst * scale, this.recording.narrowest * scale);
  }

  // ---- time

  // Simulated over real time at present.
  get currentRate() {
    return this.slow ? slowedRate(this.rate, this.time, this.slowTimes) : this.rate;
  }

  play() {
    if (this.playing || this.length === 0) return;
    if (this.time >= this.recording.end) this.time = this.recording.begin;
    this.last = null;
    this.playing = true;
    showPlaying(true);
    this.requestDraw();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    showPlaying(false);
    this.afterChange();
  }

  toggle() {
    return this.playing ? this.pause() : this.play();
  }

  // Go to a time and pause.
  /** @type {(time: number) => void} */
  seek(time) {
    this.pause();
    this.time = Math.min(Math.max(time, this.recording.begin), this.recording.end);
    this.afterChange();
  }

  // Go to the next of some times, or the one before.
  /** @type {(times: ArrayLike<number>, direction: number) => void} */
  toNext(times, direction) {
    const all = Array.from(times);
    const later = () => all.find((each) => each > this.time);
    const next = direction > 0 ? later() : all.findLast((each) => each < this.time);
    this.seek(next ?? this.time);
  }

  // Play the end of the run, with that part on the timeline.
  playLast() {
    this.timeline.setPart(this.recording.end - LAST_PART, LAST_PART);
    this.seek(this.timeline.from);
    this.play();
  }

  // Set the rate, whether the run is slow near events, or the selected bench.
  /** @type {(name: "rate" | "slow" | "selected", value: unknown) => void} */
  set(name, value) {
    Object.assign(this, { [name]: value });
    this.afterChange();
  }

  /** @type {(factor: number) => void} */
  zoomTimeline(factor) {
    this.timeline.zoom(factor, 0, 0, this.time);
    this.requestDraw();
  }

  /** @type {(name: string) => void} */
  setLanguage(name) {
    setLanguage(name);
    showPlaying(this.playing);
    writeLists(this);
    this.afterChange();
  }

  // ---- after any change: update picture and controls at once, address and announcement later

  afterChange() {
    this.showView();
    element("rate").value = String(this.rate);
    element("slow").checked = this.slow;
    element("legend-exact").hidden = !(this.recording.exact && this.shown.exact);
    this.requestDraw();
    this.writeLinkSoon();
    clearTimeout(this.announceTimer);
    this.announceTimer = setTimeout(() => this.announce(), ANNOUNCE_AFTER);
  }

  announce() {
    const description = describeTime(this.time, this.events);
    const { speed, angle, gap } = formatNumbers(
      benchNumbers(this.moment.benches, this.selected ?? 0, this.time),
    );
    const bench =
      this.selected === null
        ? ""
        : localized(". Bench {i}: speed {speed}, angle {angle}, gap {gap}", {
            i: this.selected,
            speed,
            angle,
            gap,
          });
    if (!this.playing) setText("announcement", description + bench);
    const count = this.recording.benches;
    const seen =
      this.follow === "head"
        ? localized("The dragon's {count} benches seen from above the head", { count })
        : localized("The dragon's {count} benches seen from above", { count });
    element("field").setAttribute("aria-label", `${seen}. ${description}.`);
  }

  readLink() {
    const link = parseLink(location.hash);
    const { bench = -1, rate = this.rate } = link;
    const { view, recording } = this;
    if (link.time !== undefined) this.seek(link.time);
    if (RATES.includes(rate)) this.rate = rate;
    this.slow = link.slow;
    if (link.show) for (const name of RUN_SWITCHES) this.shown[name] = link.show.includes(name);
    if (Number.isInteger(bench) && bench >= 0 && bench < recording.benches) this.selected = bench;
    if (chosenLanguage() !== language) this.setLanguage(chosenLanguage());
    // A span requires the size of the canvas.
    this.resize();
    if (link.follow) this.setFollow(link.follow);
    if (link.at) {
      this.setFollow(null);
      [view.x, view.y] = link.at;
      view.pan(0, 0);
    }
    if (link.span && this.follow !== "field") view.span = link.span;
    this.afterChange();
    if (link.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
  }
}

// Events to go to, and the precision of the run, in the page's language.
/** @type {(player: Player) => void} */
function writeLists({ events, recording }) {
  const first = events.length ? localized("Go to an event …") : localized("No events");
  const options = events.map(
    ({ time, text }, i) => new Option(`${time.toFixed(2)} s: ${text}`, String(i)),
  );
  element("events").replaceChildren(new Option(first, ""), ...options);
  setText(
    "precision",
    localized(
      "Positions are stored to within {error} μm in {frames} frames; between two frames," +
        " benches move on cubic polynomials of time that match the positions and velocities of" +
        " both. Numbers are shown with the digits that are certain.",
      {
        error: Number((1e6 * recording.positionError).toPrecision(2)),
        frames: recording.times.length,
      },
    ),
  );
}
