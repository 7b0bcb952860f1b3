// Buttons, fields and keys of the live page.

const WIDE = "(min-width: 44.01rem) and (min-height: 36.01rem)"; // room for all parts of the panel at once

function connect(live) {
  const { tools } = live;
  connectFields(live);
  connectStage(live, {
    buttons: buttonsOf(live),
    keys: { enter: () => live.frame && tools.apply(), escape: () => tools.drop() },
    pointers: {
      hovered(pixel) {
        live.pixel = pixel;
        if (pixel) tools.point(pixel);
        live.requestDraw();
      },
      tapped: (pixel, kind) => live.frame && tools.tap(pixel, kind),
      taken: (pixel, kind) => live.frame !== null && tools.take(pixel, kind),
      carried: (pixel) => tools.carry(pixel),
      dropped: () => tools.drop(),
    },
    takes: (event) => takesKey(live, event),
  });
  element("save").href = `inputs${location.search}`;
  for (const kind of ["focus", "blur"]) element("field").addEventListener(kind, () => live.requestDraw());
  document.body.classList.toggle("framed", STAGE !== null);
  // The release of a key is not heard when another window has the focus.
  addEventListener("blur", () => live.pressed.forEach((name) => pressKey(live, name, false)));
  addEventListener("hashchange", () => live.setLanguage(chosenLanguage()));
  const opens = STAGE !== null || matchMedia(WIDE).matches;
  for (const part of document.querySelectorAll(".panel details")) part.open = opens;
}

const buttonsOf = (live) => ({
  play: () => live.send({ do: live.playing ? "pause" : "play" }),
  step: () => live.send({ do: "step", count: 1 }),
  "until-contact": () => live.send({ do: "until_contact" }),
  "error-close": () => live.hideError(),
  "save-charts": () => download(new Blob([live.charts.table], { type: "text/csv" }), "live.csv"),
  reset: () => live.send({ do: "reset" }),
  release: () => live.send({ do: "release", bench: 1 }),
  hold: () => live.send({ do: "hold" }),
  record: () => live.recorder.toggle(),
});

function connectFields(live) {
  const { tools } = live;
  const changed = (id, action) => element(id).addEventListener("change", ({ target }) => action(target));
  changed("scene", ({ value }) => live.send({ do: "scene", name: value }));
  changed("speed", ({ value }) => live.send({ do: "speed", value: Number(value) }));
  changed("contacts", ({ value }) => live.send({ do: "contacts", value }));
  for (const tool of TOOLS) changed(`tool-${tool}`, () => tools.choose(tool));
  element("obstacle-size").addEventListener("input", () => tools.showSize());
}

// Send a key of the scene's own; it does nothing else.
function takesKey(live, event) {
  const keys = live.scene?.keys ?? [];
  const all = keys.includes("*") && !event.target.closest("input, select");
  if (!(keys.includes(event.key) || all) || !live.controls) return false;
  event.preventDefault();
  if (!event.repeat) pressKey(live, event.key, event.type === "keydown");
  return true;
}

function pressKey(live, name, down) {
  live.send({ do: "press", name, down });
  live.pressed[down ? "add" : "delete"](name);
}

// ---- the start, and what tests read

function start() {
  const live = new Live();
  connect(live);
  setLanguage(chosenLanguage());
  return live;
}

try {
  globalThis.live = start();
} catch (error) {
  showFailure(error);
  throw error;
}
