// Languages: a button for each, and the address remembers which (lessons.html?zh#chain).
const root = document.documentElement;

// An element that the page has.
/** @type {(parent: ParentNode, selector: string) => any} */
const partOf = (parent, selector) => parent.querySelector(selector);

/** @type {HTMLButtonElement[]} */
const buttons = Array.from(document.querySelectorAll(".languages button"));
const languages = buttons.map((button) => button.value);

/** @type {(language: string) => void} */
function speak(language) {
  root.lang = language;
  document.title = partOf(document, `h1 [lang="${language}"]`).textContent;
  for (const button of buttons) {
    button.setAttribute("aria-pressed", String(button.value === language));
  }
  document.dispatchEvent(new Event("languagechange"));
}

for (const button of buttons) {
  button.addEventListener("click", () => {
    speak(button.value);
    // Other parts stay, as the token of a live server.
    const others = location.search
      .slice(1)
      .split("&")
      .filter((each) => each && !languages.includes(each));
    rememberAddress(`?${[...others, button.value].join("&")}${location.hash}`);
  });
}
speak(
  location.search
    .slice(1)
    .split("&")
    .find((each) => languages.includes(each)) ?? root.lang,
);

// Whether a published page can load its engine: not from a file, and not in a frame with a sandbox.
const HAS_ENGINE = location.protocol !== "file:" && self.origin !== "null";

// The live scene of a stage, where a live server has this page. One is open, as all belong to one
// session; a button opens another one again.
/** @type {(stage: HTMLElement) => void} */
function openScene(stage) {
  for (const old of document.querySelectorAll("iframe")) {
    const still = partOf(/** @type {Element} */ (old.closest(".experiment")), ".main");
    old.replaceWith(still.cloneNode(true));
  }
  const frame = document.createElement("iframe");
  const { page, live } = stage.dataset;
  const address = () => `${page}${location.search}#stage=${live}&lang=${root.lang}`;
  // Where it waits for the engine, the frame shows the picture that it takes the place of.
  const picture = stage.querySelector("img");
  if (picture) stage.dataset.picture = picture.src;
  frame.title = partOf(stage.closest(".lesson") ?? stage, "h2").textContent.trim();
  frame.src = address();
  document.addEventListener("languagechange", () => {
    frame.src = address();
  });
  stage.replaceChildren(frame);
}

// The worker of a published page, for one experiment after the other.
/** @type {Worker | null} */
let engine = null;

window.addEventListener("message", ({ source, data }) => {
  const frame = document.querySelector("iframe");
  if (!source || source !== frame?.contentWindow) return;
  if (data.ends) {
    engine?.terminate();
    engine = null;
    return;
  }
  if (!engine) {
    /** @type {(posted: unknown) => void} */
    const pass = (posted) =>
      document.querySelector("iframe")?.contentWindow?.postMessage(posted, location.origin);
    engine = new Worker("worker.js", { type: "module" });
    engine.onmessage = (event) => pass(event.data);
    engine.onerror = ({ message }) => {
      engine = null;
      pass({ failure: { text: message ?? "" } });
    };
  }
  engine.postMessage(data);
});

// The course of a lesson: guess, experiment, answer.
for (const lesson of /** @type {NodeListOf<HTMLElement>} */ (
  document.querySelectorAll(".lesson")
)) {
  // No form: a frame with a sandbox allows none to be sent, and these are not.
  const guesses = partOf(lesson, ".guesses");
  /** @type {HTMLInputElement[]} */
  const choices = [...guesses.querySelectorAll("input")];
  /** @type {HTMLFieldSetElement[]} */
  const fieldsets = [...guesses.querySelectorAll("fieldset")];
  const stage = partOf(lesson, ".stage");
  const answer = partOf(lesson, ".answer");

  /** @type {(state: string) => void} */
  const enter = (state) => {
    lesson.dataset.state = state;
    for (const fieldset of fieldsets) fieldset.disabled = state !== "guess";
  };

  const open = () => {
    enter("open");
    const { live, page } = stage.dataset;
    const plays = page !== "live" ? HAS_ENGINE : !stage.querySelector("figure");
    if (live && plays && !stage.querySelector("iframe")) openScene(stage);
    if (stage.dataset.stage && !stage.hasChildNodes()) openStage(stage);
    const first = stage.querySelector("input, button, [tabindex]") ?? partOf(lesson, ".show");
    first.focus({ preventScroll: true });
  };

  const openGuessed = () => {
    if (choices.every((choice) => choice.reportValidity())) open();
  };

  // Also the button that takes the place of a live scene.
  partOf(lesson, ".experiment").addEventListener("click", (/** @type {any} */ { target }) => {
    if (target.closest(".open")) openGuessed();
    if (target.closest(".open-unguessed")) open();
  });
  guesses.addEventListener("keydown", (/** @type {KeyboardEvent} */ { key }) => {
    if (key === "Enter") openGuessed();
  });

  // Guess and result side by side, and what comes of each choice.
  partOf(lesson, ".show").addEventListener("click", () => {
    for (const [i, result] of [...lesson.querySelectorAll(".result")].entries()) {
      const chosen = partOf(fieldsets[i], "input:checked");
      const words = chosen?.parentElement.querySelectorAll("span[lang]") ?? [];
      partOf(result, ".mine").replaceChildren(
        ...(chosen ? [...words].map((each) => each.cloneNode(true)) : ["–"]),
      );
      for (const [choice, item] of [...result.querySelectorAll("li")].entries()) {
        item.classList.toggle("chosen", Number(chosen?.value ?? -1) === choice);
      }
    }
    enter("answered");
    answer.focus();
  });

  partOf(lesson, ".again").addEventListener("click", () => {
    for (const choice of choices) choice.checked = false;
    if (stage.dataset.stage) stage.replaceChildren(); // The experiment begins anew.
    enter("guess");
    choices[0]?.focus();
  });
}

// In a frame, a link to a part of this page could load the page around it:
// one of `srcdoc` has no address of its own.
for (const link of window === top ? [] : document.querySelectorAll("a[href^='#']")) {
  link.addEventListener("click", (event) => {
    event.preventDefault();
    const address = link.getAttribute("href") ?? "";
    partOf(document, address).scrollIntoView();
    rememberAddress(address);
  });
}

// A page in a frame with a sandbox cannot print, and may open no window: addresses can be copied.
const isSandboxed = window !== top && self.origin === "null";
root.classList.toggle("sandboxed", isSandboxed);
for (const link of isSandboxed ? document.querySelectorAll("figcaption a") : []) {
  link.append(` ${/** @type {HTMLAnchorElement} */ (link).href}`);
}

// Sheets to print: for the class or for the teacher, of one lesson or of all.
for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (
  document.querySelectorAll(".sheets button")
)) {
  button.addEventListener("click", () => {
    const lesson = button.closest(".lesson");
    root.dataset.print = button.value;
    root.classList.toggle("one", lesson !== null);
    lesson?.classList.add("chosen");
    print();
    delete root.dataset.print;
    root.classList.remove("one");
    lesson?.classList.remove("chosen");
  });
}
