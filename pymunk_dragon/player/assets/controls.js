// What buttons, fields, keys and hands do.

const BIG_STEP = 10; // frames
const ZOOM_STEP = 1.4; // times
const FINGER = 12; // pixels by which a finger may miss a bench

function connect(player) {
  connectButtons(player);
  connectFields(player);
  connectKeys(player);
  const { motion, view } = player;
  listenToPointers(element("field"), view, {
    moved: (how) => player.movedByHand(how),
    hovered(pixel) {
      player.pixel = pixel;
      player.ask();
    },
    tapped(pixel, kind) {
      player.pick(player.benches.at(view.toFloor(...pixel), kind === "mouse" ? 0 : FINGER / view.scale));
    },
  });
  Object.assign(element("time"), { min: motion.begin, max: motion.end, disabled: player.length === 0 });
  for (const id of ["play", "back", "forward"]) element(id).disabled = player.length === 0;
  for (const id of ["previous", "next", "events"]) element(id).disabled = !player.events.length;
  new ResizeObserver(() => player.ask()).observe(element("field"));
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
    ...player.events.map(({ time, words }, i) => new Option(`${time.toFixed(2)} s: ${words}`, i)));
  element("time").addEventListener("input", ({ target }) => player.seek(target.valueAsNumber));
  element("strip").addEventListener("click", ({ offsetX }) => player.seek(player.timeline.clicked(offsetX)));
  element("rate").addEventListener("change", ({ target }) => player.setRate(Number(target.value)));
  element("events").addEventListener("change", ({ target }) => {
    if (target.value !== "") player.seek(player.events[target.value].time);
    target.value = "";
  });
  element("bench").addEventListener("input", ({ target }) => {
    if (target.value !== "" && target.checkValidity()) player.pick(target.valueAsNumber);
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
    // Fields keep their own keys, but the slider's would move it by a hundredth of the run; buttons keep the space bar.
    const field = event.target.closest("select, input:not([type=range], [type=checkbox])");
    const presses = event.key === " " && event.target.closest("button, input[type=checkbox]");
    const action = keys[event.key.toLowerCase()];
    if (field || presses || !action) return;
    event.preventDefault();
    action(event);
  });
}
