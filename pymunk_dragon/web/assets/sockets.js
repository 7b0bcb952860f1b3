// What has the place of a WebSocket where no server is: a notebook's widget, or a worker.

const OPENS_AT_LATEST = 5000; // ms: wait for the widget
// Each so many frames are acknowledged when they are drawn; Python sends twice as many before.
const TOLD_FRAME = 3;
// This is the frame of a notebook's widget.
const IN_WIDGET = location.href.startsWith("about:srcdoc");
// What the worker of a published page loads, of which a file has nothing; null for the page of a
// server or a widget.
/** @type {Site | null} */
const SITE = JSON.parse(document.getElementById("site")?.textContent ?? "{}");
const STAGES = 4; // of loading a worker: Python, its libraries, this package, the scene

// Posts what is sent, and takes what is posted; `post` and `end` are the subclass's.
class PostedSocket {
  constructor() {
    /** @type {number} */
    this.readyState = WebSocket.CONNECTING;
    /** @type {() => void} */
    this.onopen = () => {};
    /** @type {(event: { data: unknown }) => void} */
    this.onmessage = () => {};
    /** @type {() => void} */
    this.onclose = () => {};
  }

  // A frame counts as drawn with the next picture; a page that nobody sees has none.
  /** @type {(posted: Posted) => void} */
  take({ text, bytes, frame, closed }) {
    if (closed) {
      this.close();
      return;
    }
    if (this.readyState === WebSocket.CONNECTING) {
      this.readyState = WebSocket.OPEN;
      this.onopen();
    }
    this.onmessage({ data: bytes ?? text });
    if (frame !== undefined && frame % TOLD_FRAME === 0) {
      requestAnimationFrame(() => this.send(frame));
    }
  }

  /** @type {(content: unknown) => void} */
  send(content) {
    this.post(content);
  }

  close() {
    if (this.readyState === WebSocket.CLOSED) return;
    this.end();
    this.readyState = WebSocket.CLOSED;
    this.onclose();
  }

  /** @type {(content: unknown) => void} */
  post(content) {
    throw new Error(`nowhere to post ${content}`);
  }

  end() {}
}

// The widget passes on what is posted.
class WidgetSocket extends PostedSocket {
  constructor() {
    super();
    /** @type {(event: MessageEvent) => unknown} */
    this.read = ({ source, data }) => source === parent && this.take(data);
    window.addEventListener("message", this.read);
    /** @type {number} */
    this.waiting = setTimeout(() => this.close(), OPENS_AT_LATEST);
    this.send(0);
  }

  /** @type {(posted: Posted) => void} */
  take(posted) {
    clearTimeout(this.waiting);
    super.take(posted);
  }

  /** @type {(content: unknown) => void} */
  post(content) {
    parent.postMessage(content, "*");
  }

  end() {
    window.removeEventListener("message", this.read);
  }
}

// The worker of the page around this frame, which has one for all its frames; used like a worker.
class WorkerAround {
  constructor() {
    /** @type {(event: { data: any }) => void} */
    this.onmessage = () => {};
    /** @type {(event: { message?: string }) => void} */
    this.onerror = () => {};
    /** @type {(event: MessageEvent) => unknown} */
    this.read = ({ source, data }) => source === parent && this.onmessage({ data });
    window.addEventListener("message", this.read);
  }

  /** @type {(content: unknown) => void} */
  postMessage(content) {
    parent.postMessage(content, location.origin);
  }

  terminate() {
    window.removeEventListener("message", this.read);
    this.postMessage({ ends: true });
  }
}

// A worker of this page, which loads Python and has the session. `loaded` gets what it says before.
class WorkerSocket extends PostedSocket {
  /** @param {Site} site @param {(loading: Loading) => void} loaded */
  constructor(site, loaded) {
    super();
    const link = new URLSearchParams(location.hash.slice(1));
    const stage = link.get("stage");
    /** @type {any} */
    this.worker = stage ? new WorkerAround() : new Worker("worker.js", { type: "module" });
    this.worker.onmessage = (/** @type {MessageEvent} */ { data }) => {
      if (data.stage === undefined && !data.failure) this.take(data);
      else loaded(data);
    };
    this.worker.onerror = (/** @type {ErrorEvent} */ { message }) => {
      loaded({ failure: { text: message ?? "" } });
      this.close();
    };
    this.post({ scene: stage ?? link.get("scene") ?? "", ...site });
  }

  /** @type {(content: unknown) => void} */
  post(content) {
    this.worker.postMessage(content);
  }

  end() {
    this.worker.terminate();
  }
}
