// Puts the parts together: what is shown, what the controls do, and the clock.

// Times real time. A run plays at the slowest of them that has it over within LONGEST seconds.
const RATES = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50], LONGEST = 60;
const BIG_STEP = 10; // frames
const ZOOM_STEP = 1.4, PAN_STEP = 1 / 8; // times; of the view's size
// Longest time between two drawings that counts, s: after a nap of the computer the run goes on where it was.
const LONGEST_TICK = 0.25;
// Milliseconds: how often the address follows a run that plays, and how long people get to finish what they are at
// before the new state is told. Browsers refuse more than some 200 changes of the address in half a minute.
const LINK_EVERY = 500, TELL_AFTER = 700;
// Pixels by which a finger may miss a bench.
const FINGER = 12;

const element = (id) => document.getElementById(id);

function player(told, packed, curve) {
  const motion = new Motion(told, packed);
  const view = new View(motion);
  const painter = new Painter(element("field"), motion, view, told, curve);
  const events = eventsOf(told);
  const timeline = new Timeline(element("strip"), motion, events);
  const length = motion.end - motion.begin;
  const usualRate = RATES.find((rate) => length / rate <= LONGEST) ?? RATES.at(-1);
  const state = {
    time: motion.begin, playing: false, rate: usualRate, usualRate, follow: "field", view,
    show: Object.fromEntries(SWITCHES.map((name) => [name, SHOWN_AT_FIRST.includes(name)])),
    picked: null, hovered: null, pixel: null,
  };
  let benches = null, asked = false, last = null, written = 0, linkTimer = null, tellTimer = null;

  // ---- drawing

  function ask() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(tick);
  }

  function tick(now) {
    asked = false;
    if (state.playing) {
      const passed = last === null ? 0 : Math.min((now - last) / 1000, LONGEST_TICK);
      state.time = Math.min(state.time + passed * state.rate, motion.end);
      if (state.time >= motion.end) pause();
      else writeLinkSoon();
    }
    last = state.playing ? now : null;
    draw();
    if (state.playing) ask();
  }

  function draw() {
    benches = new Benches(motion, motion.posesAt(state.time));
    if (painter.resize()) timeline.draw(painter.colours);
    if (state.follow === "field") view.fit();
    if (state.follow === "head") [view.x, view.y] = [benches.poses.x[0], benches.poses.y[0]];
    if (state.pixel) state.hovered = benches.at(view.toFloor(...state.pixel), 0);
    const pointed = state.hovered ?? state.picked;
    painter.draw({ time: state.time, benches, show: state.show, pointed });
    write("clock", state.time.toFixed(2));
    element("time").value = state.time;
    element("time").setAttribute("aria-valuetext", `${state.time.toFixed(2)} seconds`);
    showCard(pointed ?? 0);
  }

  // A text is only touched when it changes, which costs the browser more than drawing does.
  function write(id, text) {
    if (element(id).textContent !== text) element(id).textContent = text;
  }

  function numbersOf(i) {
    const velocities = motion.velocitiesAt(state.time);
    const degrees = (benches.poses.angle[i] * 360) / TURN;
    const coil = benches.nextCoil(i);
    return {
      bench: i,
      speed: velocities && Math.hypot(...velocities[i]),
      angle: degrees - 360 * Math.ceil((degrees - 180) / 360),
      gap: coil && coil.gap,
      nearest: coil && coil.bench,
      blur: coil && Math.max(motion.blurAt(state.time, i), motion.blurAt(state.time, coil.bench)),
    };
  }

  function showCard(i) {
    const { speed, angle, gap, nearest, blur } = numbersOf(i);
    const input = element("bench");
    if (document.activeElement !== input) input.value = i;
    write("part", i === 0 ? "head" : i === motion.benches - 1 ? "tail" : "body");
    write("speed", speed === null ? "–" : `${speed.toFixed(3)} m/s`);
    write("angle", `${angle.toFixed(1).replace("-", "−")}°`);
    write("gap", gap === null ? "–" : gap === 0 ? `touches ${nearest}` : `${inLength(gap, blur)} to ${nearest}`);
  }

  // ---- time

  function pause() {
    if (!state.playing) return;
    state.playing = false;
    showPlaying();
    settle();
  }

  function play() {
    if (state.playing || length === 0) return;
    if (state.time >= motion.end) state.time = motion.begin;
    state.playing = true;
    last = null;
    showPlaying();
    ask();
  }

  function showPlaying() {
    document.body.classList.toggle("playing", state.playing);
    const name = state.playing ? "Pause" : "Play";
    element("play").setAttribute("aria-label", name);
    element("play").title = `${name} (space)`;
  }

  function seek(time) {
    state.time = Math.min(Math.max(time, motion.begin), motion.end);
    settle();
  }

  function step(frames) {
    pause();
    const { times } = motion;
    const here = motion.frameFrom(state.time);
    // Between two frames, one back is the one before.
    let frame = here + frames - (frames > 0 && times[here] > state.time ? 1 : 0);
    frame = Math.min(Math.max(frame, 0), times.length - 1);
    // A frame that shares its time with another would be a step that goes nowhere.
    while (times[frame] === state.time && times[frame + Math.sign(frames)] !== undefined) frame += Math.sign(frames);
    seek(times[frame]);
  }

  function toEvent(direction) {
    const found = direction > 0
      ? events.find((event) => event.time > state.time)
      : events.findLast((event) => event.time < state.time);
    if (!found) return;
    pause();
    seek(found.time);
  }

  // ---- what follows a change: a picture now, address and words a little later

  function settle() {
    ask();
    writeLinkSoon();
    clearTimeout(tellTimer);
    tellTimer = setTimeout(tell, TELL_AFTER);
  }

  function writeLinkSoon() {
    if (linkTimer !== null) return;
    linkTimer = setTimeout(() => {
      linkTimer = null;
      written = performance.now();
      try {
        history.replaceState(null, "", linkOf(state));
      } catch {
        // A page within a notebook's frame has no address of its own.
      }
    }, Math.max(0, written + LINK_EVERY - performance.now()));
  }

  function tell() {
    const happening = events.filter((event) =>
      event.kind === "contact" ? event.time <= state.time && state.time <= event.end
        : Math.abs(event.time - state.time) < 0.05);
    const words = [`t = ${state.time.toFixed(2)} s`, ...happening.slice(0, 3).map((event) => event.words)].join(". ");
    const picked = state.picked === null ? "" : `. Bench ${state.picked}: ${["speed", "angle", "gap"].map((id) => `${id} ${element(id).textContent}`).join(", ")}`;
    if (!state.playing) write("said", words + picked);
    const where = state.follow === "head" ? "seen from above the head" : "seen from above";
    element("field").setAttribute("aria-label", `The dragon's ${motion.benches} benches ${where}. ${words}.`);
  }

  // ---- view

  function follow(subject) {
    state.follow = subject;
    // From close by one stays close.
    if (subject === "head") view.span = Math.min(view.span, view.headSpan);
    showFollowing();
    settle();
  }

  function showFollowing() {
    element("fit").setAttribute("aria-pressed", state.follow === "field");
    element("follow").setAttribute("aria-pressed", state.follow === "head");
  }

  // While the dragon walks, zooming keeps the head in the middle if it was there; whatever else moves the view lets go.
  function moved(how) {
    const keeps = how === "step" || (how === "zoom" && state.playing);
    if (state.follow === "field" || !keeps) state.follow = null;
    showFollowing();
    settle();
  }

  function zoom(factor) {
    view.zoom(factor);
    moved("step");
  }

  function pan(right, down) {
    view.pan(-right * PAN_STEP * view.width, -down * PAN_STEP * view.height);
    moved("pan");
  }

  function pick(bench) {
    state.picked = bench;
    settle();
  }

  function show(name, shown) {
    state.show[name] = shown;
    element(`show-${name}`).checked = shown;
    settle();
  }

  // ---- links

  function readLink() {
    const link = linkRead(location.hash);
    if (link.time !== undefined) {
      pause();
      state.time = Math.min(Math.max(link.time, motion.begin), motion.end);
    }
    if (RATES.includes(link.rate)) state.rate = link.rate;
    element("rate").value = state.rate;
    if (link.show) for (const name of SWITCHES) show(name, link.show.includes(name));
    if (Number.isInteger(link.bench) && link.bench >= 0 && link.bench < motion.benches) state.picked = link.bench;
    painter.resize();
    if (link.follow) follow(link.follow);
    if (link.at) {
      state.follow = null;
      [view.x, view.y] = link.at;
      view.pan(0, 0);
    }
    if (link.span && state.follow !== "field") view.span = link.span;
    showFollowing();
    settle();
    if (link.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) play();
  }

  // ---- controls

  const onClick = (id, action) => element(id).addEventListener("click", action);
  onClick("play", () => (state.playing ? pause() : play()));
  onClick("back", () => step(-1));
  onClick("forward", () => step(1));
  onClick("previous", () => toEvent(-1));
  onClick("next", () => toEvent(1));
  onClick("zoom-in", () => zoom(ZOOM_STEP));
  onClick("zoom-out", () => zoom(1 / ZOOM_STEP));
  onClick("fit", () => follow("field"));
  onClick("follow", () => follow(state.follow === "head" ? "field" : "head"));
  onClick("help", () => element("about").showModal());
  onClick("save-moment", () => {
    element("downloads").hidePopover();
    download(tableOf(motion, [state.time]), `dragon_${state.time.toFixed(2)}_s.csv`);
  });
  onClick("save-run", () => {
    element("downloads").hidePopover();
    download(tableOf(motion, motion.times), "dragon.csv");
  });
  element("time").addEventListener("input", (event) => {
    pause();
    seek(event.target.valueAsNumber);
  });
  element("strip").addEventListener("click", (event) => {
    pause();
    seek(timeline.clicked(event.offsetX));
  });
  element("rate").addEventListener("change", (event) => {
    state.rate = Number(event.target.value);
    settle();
  });
  element("events").addEventListener("change", (event) => {
    if (event.target.value === "") return;
    pause();
    seek(events[event.target.value].time);
    event.target.value = "";
  });
  element("bench").addEventListener("input", ({ target }) => {
    if (target.value !== "" && target.checkValidity()) pick(target.valueAsNumber);
  });
  for (const name of SWITCHES) {
    element(`show-${name}`).addEventListener("change", ({ target }) => show(name, target.checked));
  }
  listenToPointers(element("field"), view, {
    moved,
    hovered(pixel) {
      state.pixel = pixel;
      if (!pixel) state.hovered = null;
      ask();
    },
    tapped(pixel, kind) {
      const slip = kind === "mouse" ? 0 : FINGER / view.scale;
      pick(benches.at(view.toFloor(...pixel), slip));
    },
  });

  const keys = {
    " ": () => (state.playing ? pause() : play()),
    ArrowLeft: ({ shiftKey }) => step(shiftKey ? -BIG_STEP : -1),
    ArrowRight: ({ shiftKey }) => step(shiftKey ? BIG_STEP : 1),
    Home: () => (pause(), seek(motion.begin)),
    End: () => (pause(), seek(motion.end)),
    "+": () => zoom(ZOOM_STEP), "=": () => zoom(ZOOM_STEP), "-": () => zoom(1 / ZOOM_STEP),
    0: () => follow("field"),
    h: () => follow(state.follow === "head" ? "field" : "head"),
    p: () => toEvent(-1), n: () => toEvent(1),
    w: () => pan(0, -1), a: () => pan(-1, 0), s: () => pan(0, 1), d: () => pan(1, 0),
    "?": () => element("about").showModal(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || element("about").open) return;
    const own = event.target.closest("select, input:not([type=range], [type=checkbox])");
    const presses = event.target.closest("button, input[type=checkbox]") && event.key === " ";
    const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (own || presses || !action) return;
    event.preventDefault();
    action(event);
  });

  // ---- the page

  element("rate").append(...RATES.map((rate) => new Option(`${rate}×`, rate)));
  Object.assign(element("time"), { min: motion.begin, max: motion.end, disabled: length === 0 });
  for (const id of ["play", "back", "forward"]) element(id).disabled = length === 0;
  for (const id of ["previous", "next", "events"]) element(id).disabled = !events.length;
  element("events").append(new Option(events.length ? "Go to an event …" : "No events", ""),
    ...events.map(({ time, words }, i) => new Option(`${time.toFixed(2)} s: ${words}`, i)));
  if (!told.grid) element("show-grid").closest("label").hidden = true;
  for (const name of SWITCHES) element(`show-${name}`).checked = state.show[name];
  element("precision").textContent = `Places are kept to ${Number((5e5 * packed.step).toPrecision(2))} μm`
    + ` in ${packed.frames} frames; between two frames, benches go straight.`;
  new ResizeObserver(ask).observe(element("field"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    painter.readColours();
    timeline.draw(painter.colours);
    ask();
  });
  addEventListener("hashchange", readLink);
  readLink();
  draw();
  timeline.draw(painter.colours);

  // For lessons that hold the page in a frame, and for the curious.
  return Object.freeze({
    play, pause, seek, draw, pick, step,
    get time() { return state.time; },
    get playing() { return state.playing; },
    get begin() { return motion.begin; },
    get end() { return motion.end; },
    get view() { return { x: view.x, y: view.y, scale: view.scale, follow: state.follow }; },
    handles: (frame) => Array.from(placesIn(packed, frame)),
    poses: (time) => {
      const { x, y, angle } = motion.posesAt(time);
      return Array.from(x, (_, i) => [x[i], y[i], angle[i]]);
    },
    numbers: (bench) => (draw(), numbersOf(bench)),
    cells: (bench) => new Benches(motion, motion.posesAt(state.time)).cells(bench, told.grid),
    pixel: (x, y) => view.toScreen(x, y),
    gapEnds: (i, j) => benches.gap(i, j).ends,
  });
}

async function started() {
  try {
    const told = JSON.parse(block("told"));
    const [packed, curve] = await Promise.all([
      unpacked(told.handles, block("handles-packed")), unpacked(told.curve, block("curve-packed")),
    ]);
    return player(told, packed, curve);
  } catch (error) {
    element("failure").hidden = false;
    element("failure").textContent = `The dragon cannot be shown: ${error.message}. A newer browser may help.`;
    throw error;
  }
}

globalThis.dragon = started();
