// A scene that Pymunk plays on the stage of a lesson: by a live server, or by the worker of a
// published page. One connection serves all stages of the page, one after the other.

// Whether something plays scenes for this page: not in a file, and not in a frame with a sandbox.
const HAS_ENGINE =
  !SITE || (SITE.wheels && location.protocol !== "file:" && self.origin !== "null");
const HAND_SLIP = 12; // pixels: largest distance of the pointer from the body that it takes
/** @type {Words[]} */
const LOADED = [
  ["Python", "Python"],
  ["libraries", "程序库"],
  ["the engine", "引擎"],
  ["the scene", "场景"],
];

/** @type {Connection | null} */
let connection = null;
const engineFrames = new Frames();
/** @type {Played | null} */
let playedNow = null; // the stage that the connection serves

// The scene waits until it is played. `changed` is called with each event, and
// with null where the scene begins anew.
class Played {
  /** @param {Lab} lab @param {PlayedOptions} options */
  constructor(lab, { scene, changed = () => {} }) {
    this.lab = lab;
    this.name = scene;
    this.changed = changed;
    /** @type {LiveFrame | null} */
    this.frame = null;
    this.generation = 0;
    this.running = false;
    this.holds = false; // whether the hand holds a body
    /** @type {(() => void)[]} */
    this.moved = []; // what sends the sliders that have moved
    /** @type {Words | null} */
    this.note = null; // why nothing moves
    if (lab.isSmall) lab.filmed = (share) => this.showFilm(share);
    else this.enter();
  }

  // In the list: a picture of what was recorded.
  /** @type {(share: number) => void} */
  showFilm(share) {
    const film = this.lab.film ?? [];
    const bodies = film[Math.round(share * (film.length - 1))] ?? [];
    const calls = bodies.map((points) => ({ kind: "polygon", points }));
    /** @type {any} */
    const frame = { calls, step: 0, time: 0 };
    this.frame = frame;
  }

  // Whether the connection serves this stage.
  get isOpen() {
    return playedNow === this;
  }

  // Have the connection serve this stage; the scene of the one before ends.
  enter() {
    const left = playedNow;
    playedNow = this;
    left?.leave();
    this.note = ["The engine is loading ...", "引擎正在加载……"];
    // A worker begins with this scene.
    if (SITE) SITE.scene = this.name;
    if (connection?.connected) this.begin();
    else if (!connection) {
      connection = new Connection({
        received: (message) => playedNow?.receive(message),
        framed: (buffer) => playedNow?.show(engineFrames.decode(buffer)),
        changed: (open) => playedNow?.reached(open),
        loaded: (loading) => playedNow?.load(loading),
      });
      if (SITE) connection.open();
    }
    this.lab.requestDraw();
  }

  leave() {
    this.running = false;
    this.holds = false;
    this.note = [
      "Another lesson has the engine now: press a button to begin anew here.",
      "引擎正用于另一课：按任一按钮可在此重新开始。",
    ];
    this.lab.requestDraw();
  }

  /** @type {(message: Message) => void} */
  send(message) {
    if (this.isOpen) connection?.send(message);
    else this.enter();
  }

  // Begin the scene anew; it waits.
  begin() {
    this.send({ do: "scene", name: this.name });
    this.send({ do: "pause" });
    // Without the steps before the pause.
    this.send({ do: "reset" });
    for (const send of this.moved) send();
  }

  // ---- what comes from the engine

  /** @type {(open: boolean) => void} */
  reached(open) {
    if (open) this.begin();
    else this.note ??= ["The connection is lost.", "连接已断开。"];
    this.lab.requestDraw();
  }

  /** @type {(loading: Loading) => void} */
  load({ stage, failure }) {
    if (stage) {
      const [english, chinese] = LOADED[stage - 1];
      const of = `${stage}/${LOADED.length}`;
      this.note = [`Loading ${of}: ${english}`, `正在加载 ${of}：${chinese}`];
    }
    if (failure) {
      const { text } = failure;
      this.note = [`The engine could not begin. ${text}`, `引擎无法启动。${text}`];
    }
    this.lab.requestDraw();
  }

  /** @type {(message: any) => void} */
  receive(message) {
    const { kind } = message;
    if (kind === "scene" && message.name === this.name) {
      this.generation = message.generation;
      this.holds = false;
      this.changed(null);
    }
    if (message.generation === this.generation && kind === "state") {
      this.running = message.running;
    }
    if (kind === "event") this.changed(message);
    if (kind === "error") this.note = [message.text, message.text];
    this.lab.requestDraw();
  }

  /** @type {(frame: LiveFrame | null) => void} */
  show(frame) {
    if (frame?.generation !== this.generation) return;
    frame.calls = engineFrames.callsOf(frame);
    if (!this.frame) this.lab.still?.remove();
    this.frame = frame;
    this.note = null;
    this.lab.requestDraw();
  }

  // What the readout says: why nothing moves, or what the lesson has to say.
  /** @type {(words: (frame: LiveFrame) => Words) => Words} */
  says(words) {
    return this.note ?? (this.frame ? words(this.frame) : ["", ""]);
  }

  // ---- controls

  // A slider of the scene.
  /** @type {(name: string, label: Words, options: SliderOptions) => Slid} */
  slider(name, label, options) {
    /** @type {(value: number) => void} */
    const moved = (value) => this.send({ do: "set", name, value });
    const slid = this.lab.slider(label, { ...options, moved });
    this.moved.push(() => slid.value !== options.value && moved(slid.value));
    return slid;
  }

  // Buttons to let the scene run and pause, and to begin it anew with the sliders as they are.
  runs() {
    this.lab.button(
      () => (this.running ? ["Pause", "暂停"] : ["Play", "播放"]),
      () => this.send({ do: this.running ? "pause" : "play" }),
    );
    this.lab.button(
      () => ["Begin anew", "重新开始"],
      () => this.send({ do: "reset" }),
    );
  }

  // A hand that pulls bodies: the pointer takes those on a pane; with keys, a knob moves the body
  // of a number.
  /** @type {(pane: StagePane, label: Words, body: () => number) => void} */
  hand(pane, label, body) {
    const { lab } = this;
    const { canvas } = lab;
    canvas.classList.add("held");
    canvas.addEventListener("pointerdown", ({ pointerId, offsetX, offsetY }) => {
      const point = pane.toWorld(offsetX, offsetY);
      const calls = this.frame?.calls ?? [];
      const found = bodyAt(point, HAND_SLIP / pane.sx, { benches: NO_BENCHES, calls });
      if (!found) return;
      canvas.setPointerCapture(pointerId);
      this.grab(pane, found.point);
    });
    canvas.addEventListener("pointermove", ({ pointerId, offsetX, offsetY }) => {
      if (canvas.hasPointerCapture(pointerId)) this.drag(pane.inside(offsetX, offsetY));
    });
    canvas.addEventListener("lostpointercapture", () => this.drop());
    lab.knob(label, {
      pane,
      small: true,
      step: 0.2,
      at: () => this.frame?.held?.slice(2) ?? this.centre(body()),
      moved: (point) => {
        if (!this.holds) this.grab(pane, this.centre(body()));
        this.drag(point);
      },
      released: () => this.drop(),
    });
  }

  /** @type {(pane: StagePane, point: Numbers) => void} */
  grab(pane, [x, y]) {
    this.holds = true;
    // What rests would not follow the hand.
    if (!this.running) this.send({ do: "play" });
    this.send({ do: "grab", x, y, slip: HAND_SLIP / pane.sx });
  }

  /** @type {(point: Point) => void} */
  drag([x, y]) {
    if (this.holds) this.send({ do: "drag", x, y });
  }

  drop() {
    if (this.holds) this.send({ do: "drop" });
    this.holds = false;
  }

  // ---- what a pane shows

  // Centre of the body of a number, in the order in which bodies are drawn.
  /** @type {(body: number) => Point} */
  centre(body) {
    const points = this.bodies[body]?.points ?? [[NaN, NaN]];
    const count = points.length;
    return [sumOf(points.map(([x]) => x)) / count, sumOf(points.map(([, y]) => y)) / count];
  }

  get bodies() {
    return this.frame?.calls.filter(({ kind }) => kind === "polygon") ?? [];
  }

  // The bodies, the first as the head, and the line of the hand.
  /** @type {(pane: StagePane) => void} */
  draw(pane) {
    const { context } = pane;
    const colours = [pane.colour("head"), pane.colour("body")];
    context.lineWidth = 1;
    context.strokeStyle = pane.colour("ink");
    for (const [k, { points }] of [...this.bodies.entries()].reverse()) {
      const path = new Path2D();
      addPolygon(path, pane, points);
      context.fillStyle = colours[Math.min(k, 1)];
      context.fill(path);
      context.stroke(path);
    }
    const held = this.frame?.held;
    if (held) pane.line([held.slice(0, 2), held.slice(2)], { colour: "force", width: 2 });
  }
}

/** @type {(numbers: number[]) => number} */
const sumOf = (numbers) => numbers.reduce((sum, number) => sum + number, 0);

/** @type {any} */
const NO_BENCHES = { model: { benches: 0 } };
