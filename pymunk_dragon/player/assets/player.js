// The player itself: its time, its view, and what is shown. Controls call its methods; it draws and writes.

// Times real time. At first a run plays at the slowest, from 1 on, that has it over within LONGEST seconds.
const RATES = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50], LONGEST = 60;
// Part of its size by which the view moves.
const PAN_STEP = 1 / 8;
// Longest time between two pictures that counts, s: after a nap of the computer the run goes on where it was.
const LONGEST_TICK = 0.25;
// Milliseconds: how often the address follows a run that plays, and how long people get to finish what they are at
// before the new state is told. Browsers refuse more than some 200 changes of the address in half a minute.
const LINK_EVERY = 500, TELL_AFTER = 700;

const element = (id) => document.getElementById(id);

// A text is only touched when it changes, which costs the browser more than drawing does.
function write(id, text) {
  if (element(id).textContent !== text) element(id).textContent = text;
}

class Player {
  constructor(told, packed, velocities, curve) {
    this.motion = new Motion(told, packed, velocities);
    this.view = new View(this.motion);
    this.painter = new Painter(element("field"), this.motion, this.view, told, curve);
    this.events = eventsOf(told);
    this.timeline = new Timeline(element("strip"), this.motion, this.events);
    this.time = this.motion.begin;
    this.length = this.motion.end - this.motion.begin;
    this.usualRate = RATES.find((rate) => rate >= 1 && this.length / rate <= LONGEST) ?? RATES.at(-1);
    this.rate = this.usualRate;
    this.playing = false;
    this.follow = "field"; // or "head", or null where the view stays as it is
    this.shown = Object.fromEntries(SWITCHES.map((name) => [name, SHOWN_AT_FIRST.includes(name)]));
    this.picked = null; // a bench
    this.pixel = null; // where the mouse is
    this.linkTimer = null;
    this.written = -LINK_EVERY; // when the address was written, ms
  }

  // ---- drawing

  ask() {
    this.asked ??= requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    this.asked = null;
    if (this.playing) {
      const passed = this.last === null ? 0 : Math.min((now - this.last) / 1000, LONGEST_TICK);
      this.last = now;
      const before = this.time;
      this.time = Math.min(before + passed * this.rate, this.motion.end);
      const event = this.events.findLast(({ time }) => before < time && time <= this.time);
      if (event) write("said", event.words);
      if (this.time >= this.motion.end) this.pause();
      else this.writeLinkSoon();
    }
    this.draw();
    if (this.playing) this.ask();
  }

  draw() {
    const { motion, view, painter, time } = this;
    const benches = new Benches(motion, motion.posesAt(time));
    this.benches = benches;
    painter.resize();
    this.timeline.draw(painter.colours);
    if (this.follow === "field") view.fit();
    if (this.follow === "head") [view.x, view.y] = [benches.poses.x[0], benches.poses.y[0]];
    const hovered = this.pixel && benches.at(view.toFloor(...this.pixel), 0);
    const pointed = hovered ?? this.picked;
    painter.draw({ time, benches, show: this.shown, pointed });
    write("clock", time.toFixed(2));
    element("time").value = time;
    // Told while it stands still only: no listener keeps up with a walking dragon.
    if (!this.playing) element("time").setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
    const bench = pointed ?? 0;
    if (document.activeElement !== element("bench")) element("bench").value = bench;
    for (const [id, text] of Object.entries(numbersInWords(numbersOf(benches, bench, time)))) write(id, text);
  }

  recolour() {
    this.painter.readColours();
    this.ask();
  }

  // ---- time

  play() {
    if (this.playing || this.length === 0) return;
    if (this.time >= this.motion.end) this.time = this.motion.begin;
    this.last = null;
    this.setPlaying(true);
    this.ask();
  }

  pause() {
    if (!this.playing) return;
    this.setPlaying(false);
    this.settle();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  setPlaying(playing) {
    this.playing = playing;
    document.body.classList.toggle("playing", playing);
    const name = playing ? "Pause" : "Play";
    element("play").setAttribute("aria-label", name);
    element("play").title = `${name} (space)`;
  }

  // Go to a time, and stay there.
  seek(time) {
    this.pause();
    this.time = Math.min(Math.max(time, this.motion.begin), this.motion.end);
    this.settle();
  }

  step(frames) {
    const { times } = this.motion;
    const here = this.motion.frameFrom(this.time);
    // Between two frames, the next one is already "here".
    let frame = here + frames - (frames > 0 && times[here] > this.time ? 1 : 0);
    frame = Math.min(Math.max(frame, 0), times.length - 1);
    // A frame that shares its time with this one would be a step that goes nowhere.
    while (times[frame] === this.time && times[frame + Math.sign(frames)] !== undefined) frame += Math.sign(frames);
    this.seek(times[frame]);
  }

  toEvent(direction) {
    const found = direction > 0
      ? this.events.find((event) => event.time > this.time)
      : this.events.findLast((event) => event.time < this.time);
    if (found) this.seek(found.time);
  }

  setRate(rate) {
    this.rate = rate;
    this.settle();
  }

  // ---- view

  setFollow(subject) {
    this.follow = subject;
    // From close by one stays close.
    if (subject === "head") this.view.span = Math.min(this.view.span, this.view.headSpan);
    this.settle();
  }

  toggleHead() {
    this.setFollow(this.follow === "head" ? "field" : "head");
  }

  zoom(factor) {
    this.view.zoom(factor);
    if (this.follow === "field") this.follow = null;
    this.settle();
  }

  pan(right, down) {
    this.view.pan(-right * PAN_STEP * this.view.width, -down * PAN_STEP * this.view.height);
    this.movedByHand("pan");
  }

  // A hand on the view lets go of what it follows; but while the dragon walks, zooming keeps the head in the middle.
  movedByHand(how) {
    if (!(how === "zoom" && this.playing && this.follow === "head")) this.follow = null;
    this.settle();
  }

  pick(bench) {
    this.picked = bench;
    this.settle();
  }

  show(name, shown) {
    this.shown[name] = shown;
    this.settle();
  }

  // ---- what comes after a change: a picture and the controls at once, address and words a little later

  settle() {
    element("fit").setAttribute("aria-pressed", this.follow === "field");
    element("follow").setAttribute("aria-pressed", this.follow === "head");
    element("rate").value = this.rate;
    for (const name of SWITCHES) element(`show-${name}`).checked = this.shown[name];
    this.ask();
    this.writeLinkSoon();
    clearTimeout(this.tellTimer);
    this.tellTimer = setTimeout(() => this.tell(), TELL_AFTER);
  }

  tell() {
    const moment = momentInWords(this.time, this.events);
    const { speed, angle, gap } = numbersInWords(numbersOf(this.benches, this.picked ?? 0, this.time));
    const bench = this.picked === null ? "" : `. Bench ${this.picked}: speed ${speed}, angle ${angle}, gap ${gap}`;
    if (!this.playing) write("said", moment + bench);
    const where = this.follow === "head" ? "seen from above the head" : "seen from above";
    element("field").setAttribute("aria-label", `The dragon's ${this.motion.benches} benches ${where}. ${moment}.`);
  }

  writeLinkSoon() {
    this.linkTimer ??= setTimeout(() => {
      this.linkTimer = null;
      this.written = performance.now();
      try {
        history.replaceState(null, "", linkOf(this));
      } catch {
        // A page within a notebook's frame has no address of its own.
      }
    }, Math.max(0, this.written + LINK_EVERY - performance.now()));
  }

  readLink() {
    const link = linkRead(location.hash);
    const { view, motion } = this;
    if (link.time !== undefined) this.seek(link.time);
    if (RATES.includes(link.rate)) this.rate = link.rate;
    if (link.show) for (const name of SWITCHES) this.shown[name] = link.show.includes(name);
    if (Number.isInteger(link.bench) && link.bench >= 0 && link.bench < motion.benches) this.picked = link.bench;
    // A span has a meaning only once the size of the canvas is known.
    this.painter.resize();
    if (link.follow) this.setFollow(link.follow);
    if (link.at) {
      this.follow = null;
      [view.x, view.y] = link.at;
      view.pan(0, 0);
    }
    if (link.span && this.follow !== "field") view.span = link.span;
    this.settle();
    if (link.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
  }
}
