// Buttons, fields, keys and pointers.

const BIG_STEP = 10; // frames
const ZOOM_STEP = 1.4; // times
const TIMELINE_STEP = 2; // times
const TOUCH_SLIP = 12; // pixels: largest distance of a touch from the bench that it selects

function connect(player) {
  connectButtons(player);
  connectFields(player);
  connectKeys(player);
  const { motion, view, timeline } = player;
  listenToPointers(element("field"), view, {
    moved: (how) => player.viewMoved(how),
    hovered(pixel) {
      player.pixel = pixel;
      player.requestDraw();
    },
    tapped(pixel, kind) {
      player.select(player.benches.at(view.toWorld(...pixel), kind === "mouse" ? 0 : TOUCH_SLIP / view.scale));
    },
  });
  listenToPointers(element("strip"), timeline, {
    moved: () => player.requestDraw(),
    hovered: () => {},
    tapped: ([px]) => player.seek(timeline.timeOfClick(px)),
  });
  listenToWheel(element("time"), timeline, () => player.requestDraw());
  element("time").disabled = player.length === 0;
  for (const id of ["play", "back", "forward", "last"]) element(id).disabled = player.length === 0;
  for (const id of ["previous", "next", "events"]) element(id).disabled = !player.events.length;
  new ResizeObserver(() => player.requestDraw()).observe(element("field"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => player.recolour());
  addEventListener("hashchange", () => player.readLink());
}

function connectButtons(player) {
  const actions = {
    play: () => player.toggle(),
    back: () => player.step(-1),
    forward: () => player.step(1),
    previous: () => player.toEvent(-1),
    next: () => player.toEvent(1),
    "zoom-in": () => player.zoom(ZOOM_STEP),
    "zoom-out": () => player.zoom(1 / ZOOM_STEP),
    fit: () => player.setFollow("field"),
    follow: () => player.toggleHead(),
    last: () => player.playLast(),
    "timeline-in": () => player.zoomTimeline(TIMELINE_STEP),
    "timeline-out": () => player.zoomTimeline(1 / TIMELINE_STEP),
    "timeline-all": () => player.showWholeTimeline(),
    language: () => player.setLanguage(otherLanguage()),
    help: () => element("about").showModal(),
    close: () => element("about").close(),
    "save-moment": () => save([player.time], `dragon_${player.time.toFixed(2)}_s.csv`),
    "save-run": () => save(player.motion.times, "dragon.csv"),
  };
  function save(times, name) {
    element("downloads").hidePopover();
    download(tableOf(player.motion, times), name);
  }
  for (const [id, action] of Object.entries(actions)) element(id).addEventListener("click", action);
}

function connectFields(player) {
  element("rate").append(...RATES.map((rate) => new Option(`${rate}×`, rate)));
  writeLists(player);
  element("time").addEventListener("input", ({ target }) => player.seek(target.valueAsNumber));
  element("rate").addEventListener("change", ({ target }) => player.setRate(Number(target.value)));
  element("slow").addEventListener("change", ({ target }) => player.setSlow(target.checked));
  element("events").addEventListener("change", ({ target }) => {
    if (target.value !== "") player.seek(player.events[target.value].time);
    target.value = "";
  });
  element("bench").addEventListener("input", ({ target }) => {
    if (target.value !== "" && target.checkValidity()) player.select(target.valueAsNumber);
  });
  for (const name of SWITCHES) {
    element(`show-${name}`).addEventListener("change", ({ target }) => player.show(name, target.checked));
  }
}

// Events to go to, and the precision of the run, in the page's language.
function writeLists({ events, motion }) {
  element("events").replaceChildren(new Option(events.length ? localized("Go to an event …") : localized("No events"), ""),
    ...events.map((event, i) => new Option(`${event.time.toFixed(2)} s: ${event.text}`, i)));
  setText("precision", localized("Positions are stored to within {error} μm in {frames} frames; between two frames, benches"
    + " move on cubic polynomials of time that match the positions and velocities of both. Numbers are shown with the digits"
    + " that are certain.", { error: Number((1e6 * motion.positionError).toPrecision(2)), frames: motion.times.length }));
}

function connectKeys(player) {
  const keys = {
    " ": () => player.toggle(),
    arrowleft: ({ shiftKey }) => player.step(shiftKey ? -BIG_STEP : -1),
    arrowright: ({ shiftKey }) => player.step(shiftKey ? BIG_STEP : 1),
    home: () => player.seek(player.motion.begin),
    end: () => player.seek(player.motion.end),
    "+": () => player.zoom(ZOOM_STEP),
    "=": () => player.zoom(ZOOM_STEP), // the key of "+" without shift
    "-": () => player.zoom(1 / ZOOM_STEP),
    0: () => player.setFollow("field"),
    h: () => player.toggleHead(),
    p: () => player.toEvent(-1),
    n: () => player.toEvent(1),
    l: () => player.playLast(),
    z: () => player.zoomTimeline(TIMELINE_STEP),
    x: () => player.zoomTimeline(1 / TIMELINE_STEP),
    c: () => player.showWholeTimeline(),
    w: () => player.pan(0, -1),
    a: () => player.pan(-1, 0),
    s: () => player.pan(0, 1),
    d: () => player.pan(1, 0),
    "?": () => element("about").showModal(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || element("about").open) return;
    // Fields keep their own keys, except the slider, whose arrow keys would move it by a hundredth of the run. Buttons keep
    // the space bar.
    const field = event.target.closest("select, input:not([type=range], [type=checkbox])");
    const presses = event.key === " " && event.target.closest("button, input[type=checkbox]");
    const action = keys[event.key.toLowerCase()];
    if (field || presses || !action) return;
    event.preventDefault();
    action(event);
  });
}
