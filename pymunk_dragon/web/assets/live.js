// The page: scene, state and newest frame of the server, the view and the pictures.

const ERROR_SHOWN = 6000; // ms: an error of the server is shown for so long
const EVENTS_LISTED = 30;
const EDGE = 14; // pixels between tools or buttons and the edge of the canvas
const SCALE_BAR_ROOM = 24; // pixels at the lower border that the fitted view leaves free
const BUILDING_AFTER = 100; // ms
const ANNOUNCE_EVERY = 1500; // ms: events in between are not announced to screen readers
/** @type {Record<string, string>} */
const WORDS = { labels: "numbers" }; // of switches, in Python, where these differ
/** @type {DrawnModel} */
const NO_MODEL = /** @type {any} */ ({
  field: { centre: [0, 0], size: [1, 1] },
  widths: [1],
  narrowest: 1,
});

// The first is the lowest.
const LIVE_LAYERS = [
  drawCurve,
  drawCalls,
  drawDragon,
  drawGhosts,
  drawHandles,
  drawEfforts,
  drawNumbers,
  drawCuts,
  drawImpulses,
  drawTexts,
  drawHeld,
  drawTarget,
  drawAim,
  drawScales,
];

/** @extends {Stage<LivePicture>} */
class Live extends Stage {
  constructor() {
    super(NO_MODEL, LIVE_LAYERS, LIVE_SWITCHES, []);
    /** @type {LiveScene} */
    this.scene = NOTHING_YET;
    /** @type {LiveState} */
    this.state = NOTHING_YET;
    /** @type {LiveFrame} */
    this.frame = NOTHING_YET;
    /** @type {Model} */
    this.model = NOTHING_YET;
    /** @type {LiveFrame | null} */
    this.newest = NOTHING_YET;
    this.frames = new Frames();
    /** @type {LiveMoment | null} */
    this.cachedMoment = null;
    /** @type {Parameter[]} */
    this.first = []; // those of the scene as it began
    this.scales = new Scales();
    this.rateKind = ""; // what the rate was measured of
    /** @type { { clock: number, time: number, step: number, step_time: number }[]} */
    this.ticks = []; // of the frames in the last second
    this.aims = false; // whether keys have the field
    this.errorTimer = 0;
    this.buildingTimer = 0;
    /** @type {LiveEvent[]} */
    this.events = []; // the newest first
    this.charts = new LiveCharts(this);
    this.sliders = new Sliders(element("parameters"), (message) => this.send(message));
    this.tools = new Tools(this);
    this.recorder = new Recorder(this);
    // Whether what there is now is to be shown, and not the first view; and whether it has been.
    this.fits = false;
    this.fitted = false;
    this.drawn = 0;
    // Whether the next picture differs from the one before, and what it was drawn with.
    this.stale = true;
    this.look = "";
    /** @type {boolean | null} */
    this.asked = null; // whether the server sends contacts; null before it was told
    // Keys of the scene that are down: what holds each, and the names that were sent.
    /** @type {Map<string, string>} */
    this.pressed = new Map();
    this.announce = throttled((text) => setText("announcement", text), ANNOUNCE_EVERY);
    this.connection = new Connection({
      received: (message) => this.receive(message),
      framed: (buffer) => this.receiveFrame(buffer),
      changed: (open) => this.showConnection(open),
      loaded: (loading) => showLoading(this, loading),
    });
  }

  // Whether this page may change anything.
  get controls() {
    return this.connection.connected && this.scene?.role === "control";
  }

  get playing() {
    return this.state?.running ?? false;
  }

  // What there is to see in the newest frame.
  get moment() {
    return (this.cachedMoment ??= this.model.momentOf(this.frame, this.state));
  }

  /** @type {(message: Message) => void} */
  send(message) {
    this.connection.send(message);
  }

  // ---- messages

  /** @type {(message: any) => void} */
  receive(message) {
    if (message.kind === "building") this.showBuilding(true);
    if (message.kind === "scene") this.setScene(message);
    if (message.kind === "state") this.setState(message);
    if (message.kind === "event") this.addEvent(message);
    if (message.kind === "plots") this.charts.addValues(message);
    if (message.kind === "error") this.showError(message);
  }

  /** @type {(buffer: ArrayBuffer) => void} */
  receiveFrame(buffer) {
    this.newest = this.frames.decode(buffer) ?? this.newest;
    super.requestDraw();
  }

  /** @type {(scene: LiveScene) => void} */
  setScene(scene) {
    this.showBuilding(false);
    const isFirst = !this.scene;
    nameScene(scene);
    const same = this.scene?.name === scene.name;
    const anew = this.scene?.generation !== scene.generation;
    this.scene = scene;
    this.frame = NOTHING_YET;
    this.cachedMoment = null;
    this.model = new Model(scene);
    this.view.setSubject(this.model);
    this.fitted = false;
    this.painter.model = this.model;
    this.scales = new Scales();
    this.charts.setModel(this.model);
    this.tools.setModel(this.model, same);
    if (anew) this.events = [];
    this.showEvents();
    if (!same) {
      this.first = scene.parameters;
      this.setFollow("field");
      this.fits = false;
      if (scene.follows) this.beginToFollow();
      for (const name of LIVE_SWITCHES) {
        this.shown[name] = scene.show.includes(WORDS[name] ?? name);
      }
      setText("announcement", translated(scene.title));
    }
    showScene(this);
    element("begin").hidden = true;
    if (isFirst && SITE) applyLink(this);
    this.requestDraw();
  }

  /** @type {(state: LiveState) => void} */
  setState(state) {
    if (state.generation !== this.scene?.generation) return;
    if (state.running && !this.playing) this.hideError();
    this.state = state;
    this.cachedMoment = null;
    this.sliders.setValues(state.values);
    showState(this);
    this.requestDraw();
  }

  /** @type {(event: LiveEvent) => void} */
  addEvent(event) {
    this.events = [event, ...this.events].slice(0, EVENTS_LISTED);
    this.showEvents();
    const text = translatedNumbers(event.text);
    this.announce(localized("{text}, at {time} s", { text, time: event.time.toFixed(2) }));
  }

  showEvents() {
    element("events").replaceChildren(
      ...this.events.map(({ time, text }) =>
        created(
          "li",
          {},
          created("span", { className: "quiet" }, `${time.toFixed(2)} s`),
          ` ${translatedNumbers(text)}`,
        ),
      ),
    );
    element("no-events").hidden = this.events.length > 0;
  }

  // After an error the controls show what the server has.
  // One in a user's function stays with its line and traceback.
  /** @type {(error: LiveError) => void} */
  showError({ text, place = "", trace = "" }) {
    if (this.state) setTimeout(() => this.setState(this.state), SETTLE);
    setText("error-text", text);
    setText("error-place", place);
    setText("error-trace", trace);
    element("error-trace").hidden = trace === "";
    element("error").hidden = false;
    clearTimeout(this.errorTimer);
    if (!trace) this.errorTimer = setTimeout(() => this.hideError(), ERROR_SHOWN);
  }

  hideError() {
    element("error").hidden = true;
  }

  // A scene that takes long to build says so, but one that is built at once does not flicker.
  /** @type {(begins: boolean) => void} */
  showBuilding(begins) {
    clearTimeout(this.buildingTimer);
    element("building").hidden = true;
    if (begins) {
      this.buildingTimer = setTimeout(() => {
        element("building").hidden = false;
      }, BUILDING_AFTER);
    } else this.hideError();
  }

  /** @type {(open: boolean) => void} */
  showConnection(open) {
    element("lost").hidden = open;
    this.asked = null;
    if (!open) {
      this.tools.drop();
      // The server has released them.
      this.pressed.clear();
    }
    showAccess(this);
  }

  // ---- drawing

  decode() {
    if (!this.newest) return;
    const frame = this.newest;
    this.newest = null;
    if (frame.generation !== this.scene?.generation) return;
    const before = this.frame;
    const same = before !== null && looksAlike(before, frame);
    this.frame = frame;
    this.cachedMoment = null;
    frame.calls = same ? before.calls : this.frames.callsOf(frame);
    this.stale ||= !same;
    this.charts.add(frame);
  }

  /** @type {(now: number) => void} */
  tick(now) {
    this.decode();
    const { frame, state, tools } = this;
    this.resize();
    if (!this.drawn) this.clear(); // A new canvas is black.
    if (!frame || !state) return;
    this.leaveRoom();
    if (this.fits && !this.fitted) this.view.field = this.model.wholeField(frame);
    this.fitted = true;
    const { x, y } = this.moment.benches.poses;
    // The place to which a pointer pulls a body stays where it is.
    if (!tools.carried) this.followSubject(this.scene.follows ? frame.focus : [x[0], y[0]]);
    this.aims = this.pixel === null && element("field").matches(":focus-visible");
    tools.flush();
    this.scales.include(this.moment, now);
    this.askForContacts();
    this.paint();
    this.recorder.add();
    this.charts.draw(frame, state, now);
    showFrame(this);
    this.drawn += 1;
  }

  requestDraw() {
    this.stale = true;
    super.requestDraw();
  }

  // Draw what has changed since the last picture.
  paint() {
    const { view, scales, aims } = this;
    const tops = [...EFFORTS, "impulse"].map((kind) => scales[/** @type {Kind} */ (kind)].top);
    const look = JSON.stringify([aims, tops, view]);
    if (this.stale || look !== this.look) this.painter.draw(this.picture);
    this.stale = false;
    this.look = look;
  }

  // Have the server leave out contacts that are not shown.
  askForContacts() {
    const { contacts } = this.switches;
    if (contacts !== this.asked) this.send({ do: "show", contacts });
    this.asked = contacts;
  }

  /** @returns {LivePicture} */
  get picture() {
    const { moment, frame, scales, switches: show, aims } = this;
    const { held, target } = this.tools;
    const ghosts = show.exact ? this.model.ghostsOf(frame) : null;
    const pointed = target?.bench ?? null;
    return { ...moment, show, ghosts, scales, held, target, aims, pointed };
  }

  // The fitted view has nothing behind tools, buttons and scale bar.
  leaveRoom() {
    const { offsetWidth: width, offsetHeight: height } = element("zoom");
    this.view.top = element("toolbox").offsetHeight + EDGE;
    this.view.right = height > width ? width + EDGE : 0;
    this.view.bottom = height > width ? SCALE_BAR_ROOM : height + EDGE;
  }

  /** @type {(subject: string | null) => void} */
  setFollow(subject) {
    this.fits = subject === "field";
    this.fitted = false;
    super.setFollow(subject);
  }

  // Follow what a program follows, in a view of the size in which its scene begins.
  beginToFollow() {
    this.resize();
    this.leaveRoom();
    this.view.fit();
    this.setFollow("head");
  }

  // A body is followed until the view is moved, also while it is zoomed.
  /** @type {(how: string) => void} */
  viewMoved(how) {
    if (this.scene?.follows && this.follow === "head" && how !== "pan") this.afterChange();
    else super.viewMoved(how);
  }

  // The switches that are on and make sense for the scene.
  /** @returns {Record<string, boolean>} */
  get switches() {
    return Object.fromEntries(
      LIVE_SWITCHES.map((name) => [name, this.shown[name] && this.hasSwitch(name)]),
    );
  }

  /** @type {(name: string) => boolean} */
  hasSwitch(name) {
    return name === "contacts" || name === "forces" || this.model.benches > 0;
  }

  afterChange() {
    this.showView();
    this.requestDraw();
  }

  // Controls and charts follow with the next state and picture.
  /** @type {(name: string) => void} */
  setLanguage(name) {
    setLanguage(name);
    const address =
      name === DEFAULT_LANGUAGE ? location.pathname + location.search : `#lang=${name}`;
    if (!SITE) rememberAddress(address);
    if (!this.scene) return;
    this.showEvents();
    showScene(this);
    if (this.state) this.setState(this.state);
  }
}
