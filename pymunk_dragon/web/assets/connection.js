// The connection to the session: it is opened again when it is lost.

const FIRST_DELAY = 500; // ms: wait before the first attempt to connect again
const LAST_DELAY = 5000; // ms: longest wait
const DELAY_GROWTH = 1.6; // times, from one attempt to the next
const PING_EVERY = 5000; // ms
const SILENCE = 15000; // ms without a message after which the connection counts as lost
const WORKER_PING = 1000; // ms
const ANSWER = 5000; // ms: a worker that is silent for longer can be stopped

class Connection {
  // `received` gets each JSON message, `framed` each binary frame, `changed` whether the connection
  // is open, and `loaded` how far a worker is, which `open` starts.
  /** @param {Listeners} listeners */
  constructor({ received, framed, changed, loaded }) {
    this.received = received;
    this.framed = framed;
    this.changed = changed;
    this.loaded = loaded;
    this.heard = Infinity; // ms: time of the last message, once there is one to be expected
    /** @type {Socket | null} */
    this.socket = null;
    this.delay = FIRST_DELAY;
    if (!SITE) this.open();
    setInterval(() => this.ping(), SITE ? WORKER_PING : PING_EVERY);
  }

  get connected() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  open() {
    const socket = this.newSocket();
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.heard = performance.now();
      this.changed(true);
    };
    socket.onmessage = (/** @type {MessageEvent} */ { data }) => this.read(data);
    socket.onclose = () => this.reopen(socket);
  }

  /** @returns {Socket} */
  newSocket() {
    if (SITE) return new WorkerSocket(SITE, (loading) => this.load(loading));
    return IN_WIDGET ? new WidgetSocket() : new WebSocket(`socket${location.search}`);
  }

  // Take how far a worker is; then its program runs, which may not answer any more.
  /** @type {(loading: Loading) => void} */
  load(loading) {
    this.heard = loading.stage === STAGES ? performance.now() : Infinity;
    this.loaded(loading);
  }

  // Whether a worker has not said anything for long: a program keeps it busy.
  get stuck() {
    return performance.now() - this.heard > ANSWER;
  }

  // Wait longer after each attempt that fails; the first message sets the wait back.
  /** @type {(socket: Socket) => void} */
  reopen(socket) {
    if (socket !== this.socket) return;
    this.changed(false);
    // A worker that did not come up would not do so now.
    if (SITE && this.heard === Infinity) return;
    this.heard = Infinity;
    setTimeout(() => this.open(), this.delay);
    this.delay = Math.min(LAST_DELAY, this.delay * DELAY_GROWTH);
  }

  /** @type {(data: any) => void} */
  read(data) {
    this.heard = performance.now();
    this.delay = FIRST_DELAY;
    if (data instanceof ArrayBuffer) this.framed(data);
    else this.received(JSON.parse(data));
  }

  ping() {
    if (!this.connected) return;
    if (!SITE && performance.now() - this.heard > SILENCE) this.socket?.close();
    else this.send({ do: "ping", id: Math.round(performance.now()) });
  }

  /** @type {(message: Message) => void} */
  send(message) {
    if (this.connected) this.socket?.send(JSON.stringify(message));
  }
}

// ---- binary frames: the length of a JSON header, the header, and arrays of 64-bit numbers

// Numbers of a contact: point, normal, impulse; less than 0 without an arrow.
const CONTACT_SIZE = 5;
const JOINT_SIZE = 6; // numbers of a joint: two ends, its force or torque, and 1 for a torque
const CALL_HEAD = 7; // numbers of a call before its points

// A frame, or the shapes that are drawn in the frames after it.
/** @type {(buffer: ArrayBuffer) => any} */
function decodeFrame(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  /** @type {any} */
  const frame = {
    ...header,
    poses: [],
    exact: [],
    errors: [],
    forces: [],
    contacts: [],
    joints: [],
    calls: [],
    bodies: [],
  };
  let offset = 4 + length;
  frame.numbers = new Float64Array(buffer, offset);
  for (const [name, size] of Object.entries(header.sizes)) {
    frame[name] = new Float64Array(buffer, offset, size);
    offset += frame[name].byteLength;
  }
  return frame;
}

// What Pymunk draws, as objects: kind, points, radius, angle, colours, and the grip of a hand: 2 if
// it can hold the body, 1 where it finds nothing else (a body of sensors only), 0 if it cannot.
/** @type {(frame: { calls: any, colours?: number[][] }) => Call[]} */
function callsOf({ calls, colours = [] }) {
  const texts = colours.map(([r, g, b, a]) => `rgba(${r}, ${g}, ${b}, ${a / 255})`);
  /** @type {Call[]} */
  const found = [];
  for (let k = 0; k < calls.length;) {
    const count = calls[k + 1];
    /** @type {Point[]} */
    const points = [];
    for (let p = k + CALL_HEAD; p < k + CALL_HEAD + 2 * count; p += 2) {
      points.push([calls[p], calls[p + 1]]);
    }
    const kind = KINDS[calls[k]];
    const radius = calls[k + 2];
    found.push({
      kind,
      points,
      radius,
      reach: reachOf({ kind, points, radius }),
      angle: calls[k + 3],
      fill: texts[calls[k + 4]],
      outline: texts[calls[k + 5]],
      grip: calls[k + 6],
      opaque: colours[calls[k + 4]][3] >= 255,
    });
    k += CALL_HEAD + 2 * count;
  }
  return found;
}

const KINDS = ["circle", "segment", "polygon", "line", "dot"];

// Distance from the first point within which all of a shape is; the radius of a dot is in pixels.
/** @type {(shape: Shape) => number} */
function reachOf({ kind, points, radius }) {
  const [[x, y]] = points;
  const distances = points.map(([px, py]) => Math.hypot(px - x, py - y));
  return Math.max(...distances) + (kind === "dot" ? 0 : radius);
}

/** @type {(packed: Float64Array) => Poses} */
const posesOf = (packed) => posesFrom(packed.length / 3, (i) => packed.subarray(3 * i, 3 * i + 3));
