// A published page: its start, how far the engine is or why it cannot run, and links with a state.

const LOOK_EVERY = 1000; // ms: whether the worker answers, and what the link has to be
const STATE_DIGITS = 3; // decimals of the time in a link
const SET = "set."; // before the name of a slider in a link
const PICTURED = "dragon"; // the scene of the picture where no program has the page
// Scene for a frame on the page of a guide.
const STAGE = new URLSearchParams(location.hash.slice(1)).get("stage");

// Why this browser cannot run the engine here; empty if it can.
function hindrance() {
  if (location.protocol === "file:") {
    return localized(
      "The engine cannot run in a page that is opened as a file:" +
        " serve the folder with python -m http.server",
    );
  }
  if (self.origin === "null") {
    const address = location.href;
    return localized("The engine cannot run in this frame, only at {address} by itself.", {
      address,
    });
  }
  const able = "Worker" in window && typeof WebAssembly === "object";
  return able ? "" : localized("This browser is too old for the engine.");
}

// The picture before the engine is there, if it is one of the scene of the link.
/** @type {(site: Site) => string | undefined} */
function firstPicture({ title, picture }) {
  const scene = LINKED.get("scene") ?? PICTURED;
  return title || scene === PICTURED ? picture : undefined;
}

/** @type {(live: Live) => void} */
function connectSite(live) {
  if (!SITE) return;
  const picture = firstPicture(SITE);
  if (picture) element("begin-picture").src = picture;
  element("begin-picture").hidden = !picture;
  element("begin").hidden = false;
  element("save").hidden = true;
  element("begin-play").addEventListener("click", () => beginEngine(live));
  element("stop").addEventListener("click", () => {
    live.hideError();
    live.connection.socket?.close();
  });
  setInterval(() => {
    element("stuck").hidden = !live.connection.stuck;
    if (!STAGE && live.state) rememberAddress(stateLink(live));
  }, LOOK_EVERY);
  const why = hindrance();
  if (why) showHindrance(why);
  else if (STAGE) beginEngine(live);
}

/** @type {(why: string) => void} */
function showHindrance(why) {
  element("begin").hidden = false;
  setText("begin-text", why);
  element("begin-play").hidden = hindrance() !== "";
  element("loading").hidden = true;
  element("begin-alone").hidden = self.origin !== "null" || location.protocol === "file:";
  element("begin-alone").href = location.href;
}

/** @type {(live: Live) => void} */
function beginEngine(live) {
  live.hideError();
  element("begin-play").hidden = true;
  live.connection.open();
}

/** @type {(live: Live, loading: Loading) => void} */
function showLoading(live, { stage, failure }) {
  if (failure) {
    const { place } = failure;
    // A worker whose script does not come gives no reason.
    const text = failure.text || localized("the server does not answer");
    showHindrance(localized("The engine could not begin: {text}", { text }));
    if (place) live.showError(failure);
    return;
  }
  element("begin").hidden = false;
  const names = [
    localized("Python"),
    localized("Libraries"),
    localized("The engine"),
    localized("The scene"),
  ];
  const text = localized("Loading {stage} of {count}: {name}", {
    stage: String(stage),
    count: String(STAGES),
    name: names[stage - 1],
  });
  setText("begin-text", text);
  Object.assign(element("loading"), { hidden: false, value: stage - 1, max: STAGES });
}

// The scene of a program has the title and the text of its page; it is the first of the scenes.
/** @type {(scene: LiveScene) => void} */
function nameScene(scene) {
  const [own] = scene.scenes;
  if (!SITE?.title) return;
  own.title = SITE.title;
  if (scene.name === own.name) Object.assign(scene, { title: SITE.title, text: SITE.text });
}

// ---- links

// The part of the address after "#" for the scene as it is now.
/** @type {(live: Live) => string} */
function stateLink({ scene, state, frame, first }) {
  const query = new URLSearchParams({ scene: scene.name });
  for (const { name, value } of first) {
    const now = state.values[name];
    if (now !== value) query.set(SET + name, String(now));
  }
  if (!state.running && frame) query.set("t", frame.time.toFixed(STATE_DIGITS));
  if (language !== DEFAULT_LANGUAGE) query.set("lang", language);
  return `#${query}`;
}

const LINKED = new URLSearchParams(location.hash.slice(1));

// Bring the first scene to the state of the link; a time is reached as fast as possible.
/** @type {(live: Live) => void} */
function applyLink(live) {
  for (const [key, value] of LINKED) {
    if (key.startsWith(SET)) {
      live.send({ do: "set", name: key.slice(SET.length), value: Number(value) });
    }
  }
  const steps = Math.round(Number(LINKED.get("t") ?? 0) / live.scene.step);
  if (steps > 0) live.send({ do: "step", count: steps });
}
