// Buttons, fields and keys of the live page.

// Room for all parts of the panel at once.
const WIDE = "(min-width: 44.01rem) and (min-height: 36.01rem)";
const NOTCH_PIXELS = 100; // a notch of the wheel in most browsers
const NOTCH_LINES = 3; // the same where it counts lines

/** @type {(live: Live) => void} */
function connectLive(live) {
  const { tools } = live;
  connectLiveFields(live);
  connectStage(live, {
    buttons: liveButtons(live),
    keys: { enter: () => live.frame && tools.apply(), escape: () => tools.drop() },
    pointers: {
      hovered(pixel) {
        live.pixel = pixel;
        live.requestDraw();
      },
      tapped: (pixel, kind) => live.frame && tools.tap(pixel, kind),
      taken: (pixel, kind) => live.frame !== null && tools.take(pixel, kind),
      carried: (pixel) => tools.carry(pixel),
      dropped: () => tools.drop(),
    },
    takes: (event) => takesKey(live, event),
  });
  listenForProgram(live);
  listenForClicks(live);
  listenForLeaving(live);
  connectSite(live);
  element("save").href = `inputs${location.search}`;
  for (const kind of ["focus", "blur"]) {
    element("field").addEventListener(kind, () => live.requestDraw());
  }
  document.body.classList.toggle("framed", STAGE !== null);
  addEventListener("hashchange", () => live.setLanguage(chosenLanguage()));
  const opens = STAGE !== null || matchMedia(WIDE).matches;
  for (const part of document.querySelectorAll(".panel details")) {
    part.toggleAttribute("open", opens);
  }
}

/** @type {(live: Live) => Actions} */
const liveButtons = (live) => ({
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

/** @type {(live: Live) => void} */
function connectLiveFields(live) {
  const { tools } = live;
  /** @type {(id: string, action: (field: any) => void) => void} */
  const changed = (id, action) =>
    element(id).addEventListener("change", ({ target }) => action(target));
  changed("scene", ({ value }) => live.send({ do: "scene", name: value }));
  changed("speed", ({ value }) => live.send({ do: "speed", value: Number(value) }));
  changed("contacts", ({ value }) => live.send({ do: "contacts", value }));
  for (const tool of TOOLS) changed(`tool-${tool}`, () => tools.choose(tool));
  element("obstacle-size").addEventListener("input", () => tools.showSize());
}

// A mouse or a pen with all its buttons, and the wheel, while they belong to a program. A finger is
// its left button, and two move and zoom the view, as does the wheel with Ctrl.
/** @type {(live: Live) => void} */
function listenForProgram(live) {
  const canvas = element("field");
  const { tools } = live;
  /** @type {(event: PointerEvent) => void} */
  const passed = (event) => {
    if (event.pointerType === "touch" || !tools.isProgram || !live.frame) return;
    live.pixel = pixelOf(canvas, event);
    if (event.type === "pointerdown") canvas.setPointerCapture(event.pointerId);
    tools.press(live.pixel, event.type === "pointercancel" ? 0 : event.buttons);
    // What began before the program had the pointer ends.
    const begins = event.type === "pointerdown" || event.type === "pointermove";
    if (begins) event.stopImmediatePropagation();
  };
  /** @type {("pointerdown" | "pointermove" | "pointerup" | "pointercancel")[]} */
  const kinds = ["pointerdown", "pointermove", "pointerup", "pointercancel"];
  for (const kind of kinds) canvas.addEventListener(kind, passed, true);
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (!tools.isProgram || event.ctrlKey) return;
      event.preventDefault();
      event.stopImmediatePropagation();
      const notch = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? NOTCH_LINES : NOTCH_PIXELS;
      tools.turn(event.deltaX / notch, -event.deltaY / notch);
    },
    { capture: true, passive: false },
  );
  const hears = () => tools.isProgram || tools.hearsClicks;
  // The middle button would scroll.
  canvas.addEventListener(
    "mousedown",
    (event) => hears() && event.button === 1 && event.preventDefault(),
  );
  canvas.addEventListener("contextmenu", (event) => hears() && event.preventDefault());
}

// Clicks of the middle and the right button; those of the left one are taps.
/** @type {(live: Live) => void} */
function listenForClicks({ tools }) {
  const canvas = element("field");
  /** @type {Point} */
  let begin = [0, 0];
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 0) begin = pixelOf(canvas, event);
  });
  canvas.addEventListener("pointerup", (event) => {
    const end = pixelOf(canvas, event);
    const stays = Math.hypot(end[0] - begin[0], end[1] - begin[1]) <= TAP_SLIP;
    if ([1, 2].includes(event.button) && stays) tools.click(end, event.button + 1);
  });
}

// Nothing stays held where its release would not be heard: in another window, tab or field.
/** @type {(live: Live) => void} */
function listenForLeaving(live) {
  const canvas = element("field");
  const letGo = () => {
    releaseKeys(live);
    live.tools.drop();
  };
  addEventListener("blur", letGo);
  document.addEventListener("visibilitychange", () => document.hidden && letGo());
  canvas.addEventListener("blur", () => releaseKeys(live));
  document.addEventListener("focusin", ({ target }) => target !== canvas && releaseKeys(live));
}

// ---- the start, and what tests read

function startLive() {
  const live = new Live();
  connectLive(live);
  setLanguage(chosenLanguage());
  return live;
}

try {
  globalThis.live = startLive();
} catch (error) {
  showFailure(/** @type {Error} */ (error));
  throw error;
}
