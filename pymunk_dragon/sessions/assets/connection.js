// The connection to the server: it is opened again when it is lost.

const FIRST_DELAY = 500; // ms: wait before the first attempt to connect again
const LAST_DELAY = 5000; // ms: longest wait
const DELAY_GROWTH = 1.6; // times, from one attempt to the next
const PING_EVERY = 5000; // ms
const SILENCE = 15000; // ms without a message after which the connection counts as lost

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
    const address = new URL(`socket${location.search}`, location.href);
    address.protocol = address.protocol.replace("http", "ws");
    address.hash = "";
    const socket = this.socket = new WebSocket(address);
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
