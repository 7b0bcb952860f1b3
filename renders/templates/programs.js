// Programs of a guide, which run in its page: in one worker, which loads Python for the first one.
{
  // What the worker loads, with addresses in the folder of the worker.
  const ENGINE = JSON.parse(document.currentScript.dataset.engine);
  const FOLDER = "engine/";
  const STAGES = ["Python", "the libraries", "the engine"];
  const MOST_ROWS = 40; // of the text of a program
  const SHOWS_PAGE = /\blive\(/;

  let worker = null;
  let running = null; // the program whose output the worker posts

  const made = (name, properties) => Object.assign(document.createElement(name), properties);

  function endWorker() {
    worker?.terminate();
    worker = null;
  }

  function post(content) {
    if (!worker) {
      worker = new Worker(`${FOLDER}worker.js`, { type: "module" });
      worker.onmessage = ({ data }) => running?.take(data);
      worker.onerror = ({ message }) => {
        endWorker();
        running?.take({ failure: { text: message ?? "The worker cannot be loaded." } });
        running?.take({ ended: true });
      };
    }
    worker.postMessage(content);
  }

  class Program {
    constructor(place) {
      const code = place.nextElementSibling;
      const value = code.textContent.trimEnd() + "\n";
      this.needs = place.dataset.needs.split(" ").filter(Boolean);
      this.area = made("textarea", { value, hidden: true, spellcheck: false });
      this.area.ariaLabel = "Program";
      this.area.rows = Math.min(value.split("\n").length, MOST_ROWS);
      this.edit = made("button", { textContent: "Edit", type: "button" });
      this.edit.addEventListener("click", () => {
        this.edit.hidden = code.hidden = true;
        this.area.hidden = false;
        this.area.focus({ preventScroll: true });
      });
      this.start = made("button", { textContent: "Run", type: "button" });
      this.start.addEventListener("click", () => this.run());
      this.stop = made("button", { textContent: "Stop", type: "button", hidden: true });
      this.stop.addEventListener("click", () => this.end("Stopped."));
      this.state = made("span", { role: "status" });
      if (place.hasAttribute("data-runs")) place.append(this.start, this.stop);
      place.append(this.edit, this.state);

      this.output = made("div", { className: "output" });
      this.frame = null;
      code.after(this.area, this.output);
    }

    // End what runs; the worker goes on if its program has ended.
    end(text) {
      if (!this.stop.hidden) endWorker();
      this.frame?.remove();
      this.frame = null;
      this.start.hidden = false;
      this.stop.hidden = true;
      this.state.textContent = text;
    }

    run() {
      running?.end("");
      for (const image of this.output.querySelectorAll("img")) URL.revokeObjectURL(image.src);
      this.output.replaceChildren();
      if (location.protocol === "file:") {
        this.state.textContent = "Programs run where the folder is served: python -m http.server";
        return;
      }
      running = this;
      this.start.hidden = true;
      this.stop.hidden = false;
      this.texts = [...this.needs.map((place) => programs.get(place).area.value), this.area.value];
      if (SHOWS_PAGE.test(this.area.value)) this.open();
      else post({ ...ENGINE, texts: this.texts });
    }

    // Show the page of a live session, whose messages this page passes on.
    open() {
      this.frame = made("iframe", { src: `${FOLDER}live.html#stage=program`, title: "Live page" });
      this.output.append(this.frame);
    }

    take(data) {
      if (this.frame) {
        this.frame.contentWindow.postMessage(data, location.origin);
        return;
      }
      const { stage, printed, picture, bytes, failure, ended } = data;
      if (stage) {
        const name = STAGES[stage - 1];
        this.state.textContent = name ? `Loads ${name} ...` : "Runs ...";
      }
      if (printed) this.print(printed);
      if (picture) {
        const image = made("img", { alt: picture, src: URL.createObjectURL(new Blob([bytes])) });
        this.output.append(image);
      }
      if (failure) {
        this.print(`${failure.place ? `${failure.place}\n` : ""}${failure.text}\n`);
        if (!failure.kind) endWorker(); // Python itself could not be loaded.
      }
      if (ended || (failure && !failure.kind)) {
        this.stop.hidden = true; // The worker remains for the next program.
        this.end("");
      }
    }

    print(text) {
      if (this.output.lastChild?.tagName !== "PRE") {
        this.output.append(made("pre", { tabIndex: 0 }));
      }
      this.output.lastChild.append(text);
    }
  }

  const programs = new Map();
  for (const place of document.querySelectorAll(".program")) {
    programs.set(place.dataset.place, new Program(place));
  }

  window.addEventListener("message", ({ source, data }) => {
    if (!running?.frame || source !== running.frame.contentWindow) return;
    if (data.ends) endWorker();
    else if (typeof data !== "object") worker?.postMessage(data);
    else post({ ...data, program: "program.py", texts: running.texts });
  });
}
