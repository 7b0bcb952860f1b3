// Buttons, fields, keys and pointers.

const BIG_STEP = 10; // frames
const ZOOM_STEP = 1.4; // times
const TOUCH_SLIP = 12; // pixels: largest distance of a touch from the bench that it selects

function connect(player) {
  connectButtons(player);
  connectFields(player);
  connectKeys(player);
  const { motion, view } = player;
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
  Object.assign(element("time"), { min: motion.begin, max: motion.end, disabled: player.length === 0 });
  for (const id of ["play", "back", "forward"]) element(id).disabled = player.length === 0;
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
  element("events").append(new Option(player.events.length ? "Go to an event …" : "No events", ""),
    ...player.events.map(({ time, text }, i) => new Option(`${time.toFixed(2)} s: ${text}`, i)));
  element("time").addEventListener("input", ({ target }) => player.seek(target.valueAsNumber));
  element("strip").addEventListener("click", ({ offsetX }) => player.seek(player.timeline.timeOfClick(offsetX)));
  element("rate").addEventListener("change", ({ target }) => player.setRate(Number(target.value)));
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
