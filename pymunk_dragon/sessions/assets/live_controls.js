// Buttons, fields, keys and pointers.

const ZOOM_STEP = 1.4; // times
const WIDE = "(min-width: 44.01rem) and (min-height: 36.01rem)"; // room for all parts of the panel at once

function connect(live) {
  connectButtons(live);
  connectFields(live);
  connectKeys(live);
  connectPointers(live);
  for (const part of document.querySelectorAll(".panel details")) part.open = matchMedia(WIDE).matches;
  new ResizeObserver(() => live.requestDraw()).observe(element("field"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => live.recolour());
}

function connectPointers(live) {
  const { tools, view } = live;
  listenToPointers(element("field"), view, {
    moved: (how) => live.viewMoved(how),
    hovered(pixel) {
      tools.pixel = pixel;
      if (pixel) tools.point(pixel);
      live.requestDraw();
    },
    tapped: (pixel, kind) => live.frame && tools.tap(pixel, kind),
    taken: (pixel, kind) => live.frame !== null && tools.take(pixel, kind),
    carried: (pixel) => tools.carry(pixel),
    dropped: () => tools.drop(),
  });
  for (const kind of ["focus", "blur"]) element("field").addEventListener(kind, () => live.requestDraw());
}

const actionsOf = (live) => ({
  play: () => live.send({ do: live.state.running ? "pause" : "play" }),
  step: () => live.send({ do: "step", count: 1 }),
  "until-contact": () => live.send({ do: "until_contact" }),
  "error-close": () => live.hideError(),
  "save-charts": () => saveText("live.csv", live.charts.table),
  reset: () => live.send({ do: "reset" }),
  release: () => live.send({ do: "release", bench: 1 }),
  hold: () => live.send({ do: "hold" }),
  "zoom-in": () => live.zoom(ZOOM_STEP),
  "zoom-out": () => live.zoom(1 / ZOOM_STEP),
  fit: () => live.setFollow("field"),
  follow: () => live.toggleHead(),
  record: () => live.recorder.toggle(),
  "recorded-close": () => live.recorder.hide(),
  language: () => live.setLanguage(otherLanguage()),
  help: () => element("about").showModal(),
  close: () => element("about").close(),
});

function connectButtons(live) {
  for (const [id, action] of Object.entries(actionsOf(live))) element(id).addEventListener("click", action);
  element("save").href = `inputs${location.search}`;
}

function saveText(name, text) {
  const link = created("a", { href: URL.createObjectURL(new Blob([text], { type: "text/csv" })), download: name });
  link.click();
  URL.revokeObjectURL(link.href);
}

function connectFields(live) {
  const { tools } = live;
  const changed = (id, action) => element(id).addEventListener("change", ({ target }) => action(target));
  changed("scene", ({ value }) => live.send({ do: "scene", name: value }));
  changed("speed", ({ value }) => live.send({ do: "speed", value: Number(value) }));
  changed("contacts", ({ value }) => live.send({ do: "contacts", value }));
  for (const tool of TOOLS) changed(`tool-${tool}`, () => tools.choose(tool));
  for (const name of SWITCHES) {
    element(`show-${name}`).checked = live.shown[name];
    changed(`show-${name}`, ({ checked }) => live.show(name, checked));
  }
  element("obstacle-size").addEventListener("input", () => tools.showSize());
}

// The next speed of the list, upward or downward.
function changeSpeed(live, direction) {
  const faster = SPEEDS.find((speed) => speed > live.state.speed), slower = SPEEDS.findLast((speed) => speed < live.state.speed);
  const value = direction > 0 ? faster : slower;
  if (value) live.send({ do: "speed", value });
}

function keysOf(live) {
  // A button that is hidden has no key.
  const click = (id) => () => element(id).checkVisibility() && element(id).click();
  return {
    " ": click("play"),
    arrowright: click("step"),
    r: click("reset"),
    n: click("until-contact"),
    l: click("release"),
    b: click("hold"),
    "[": () => live.controls && changeSpeed(live, -1),
    "]": () => live.controls && changeSpeed(live, 1),
    ...Object.fromEntries(TOOLS.map((tool, k) => [k + 1, () => live.tools.choose(tool)])),
    enter: () => live.frame && live.tools.apply(),
    escape: () => live.tools.drop(),
    "+": click("zoom-in"),
    "=": click("zoom-in"), // the key of "+" without shift
    "-": click("zoom-out"),
    0: click("fit"),
    h: click("follow"),
    c: click("record"),
    w: () => live.pan(0, -1),
    a: () => live.pan(-1, 0),
    s: () => live.pan(0, 1),
    d: () => live.pan(1, 0),
    "?": click("help"),
  };
}

// Keys that an element uses itself.
function keepsKey(target, key) {
  if (target.closest("select")) return true;
  if (target.closest("input[type=range]")) return /^(arrow|page|home|end)/.test(key);
  if (target.closest("input[type=radio]")) return key.startsWith("arrow");
  if (target.closest("button, a, summary, input")) return key === " " || key === "enter";
  return key === "enter" && target !== element("field");
}

function connectKeys(live) {
  const keys = keysOf(live);
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || element("about").open || !live.state) return;
    const key = event.key.toLowerCase();
    if (!keepsKey(event.target, key) && pressOwn(live, event, true)) return;
    const action = keys[key];
    // Holding a key repeats steps, zooming and panning only.
    const repeats = !event.repeat || /^(arrowright|[-+=wasd])$/.test(key);
    if (!action || keepsKey(event.target, key)) return;
    event.preventDefault();
    if (repeats) action();
  });
  document.addEventListener("keyup", (event) => pressOwn(live, event, false));
}

// A key of the scene's own; it does nothing else.
function pressOwn(live, event, down) {
  const keys = live.scene?.keys ?? [];
  if (!(keys.includes(event.key) || keys.includes("*")) || !live.controls) return false;
  event.preventDefault();
  if (!event.repeat) live.send({ do: "press", name: event.key, down });
  return true;
}
