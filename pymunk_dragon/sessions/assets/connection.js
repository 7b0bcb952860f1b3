// The connection to the session: it is opened again when it is lost.

const FIRST_DELAY = 500; // ms: wait before the first attempt to connect again
const LAST_DELAY = 5000; // ms: longest wait
const DELAY_GROWTH = 1.6; // times, from one attempt to the next
const PING_EVERY = 5000; // ms
const SILENCE = 15000; // ms without a message after which the connection counts as lost

const TOLD_FRAME = 3; // every so many frames Python is told that they are drawn; it sends twice as many before
const IN_WIDGET = location.href.startsWith("about:srcdoc"); // this is the frame of a notebook's widget

// Takes the place of a WebSocket there: the widget passes on what is posted.
class WidgetSocket extends EventTarget {
  constructor() {
    super();
    this.readyState = WebSocket.CONNECTING;
    this.read = ({ source, data }) => source === parent && this.take(data);
    window.addEventListener("message", this.read);
    this.waiting = setTimeout(() => this.close(), LAST_DELAY);
    this.send(0);
  }

  // A frame counts as drawn with the next picture; a page that nobody sees has none.
  take({ text, bytes, frame, closed }) {
    clearTimeout(this.waiting);
    if (closed) {
      this.close();
      return;
    }
    if (this.readyState === WebSocket.CONNECTING) this.turn(WebSocket.OPEN, "open");
    this.dispatchEvent(new MessageEvent("message", { data: bytes ?? text }));
    if (frame % TOLD_FRAME === 0) requestAnimationFrame(() => this.send(frame));
  }

  turn(state, event) {
    this.readyState = state;
    this.dispatchEvent(new Event(event));
  }

  send(content) {
    parent.postMessage(content, "*");
  }

  close() {
    window.removeEventListener("message", this.read);
    this.turn(WebSocket.CLOSED, "close");
  }
}

class Connection {
  // `received` gets each JSON message, `framed` each binary frame, and `changed` is called as the connection opens and closes.
  constructor({ received, framed, changed }) {
    Object.assign(this, { received, framed, changed });
    this.delay = FIRST_DELAY;
    this.latency = null; // ms: time from a ping to its answer
    this.open();
    setInterval(() => this.ping(), PING_EVERY);
  }

  get connected() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  open() {
    const socket = this.socket = IN_WIDGET ? new WidgetSocket() : new WebSocket(`socket${location.search}`);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      this.heard = performance.now();
      this.changed(true);
    });
    socket.addEventListener("message", ({ data }) => this.read(data));
    socket.addEventListener("close", () => this.reopen(socket));
  }

  // Wait longer after each attempt that fails; the first message sets the wait back.
  reopen(socket) {
    if (socket !== this.socket) return;
    this.latency = null;
    this.changed(false);
    setTimeout(() => this.open(), this.delay);
    this.delay = Math.min(LAST_DELAY, this.delay * DELAY_GROWTH);
  }

  read(data) {
    this.heard = performance.now();
    this.delay = FIRST_DELAY;
    if (data instanceof ArrayBuffer) {
      this.framed(data);
      return;
    }
    const message = JSON.parse(data);
    if (message.kind === "pong") this.latency = performance.now() - this.pinged;
    else this.received(message);
  }

  ping() {
    if (!this.connected) return;
    if (performance.now() - this.heard > SILENCE) {
      this.socket.close();
      return;
    }
    this.pinged = performance.now();
    this.send({ do: "ping", id: Math.round(this.pinged) });
  }

  send(message) {
    if (this.connected) this.socket.send(JSON.stringify(message));
  }
}
