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

// What was guessed, how far each course came, and whether its program is unfolded, by the names of
// lessons: it outlasts a reload, but not in a private frame, which has no storage.
const MEMORY = "pymunk-dragon lessons";

/** @type {() => Record<string, Course>} */
function readMemory() {
  try {
    return JSON.parse(sessionStorage.getItem(MEMORY) ?? "{}");
  } catch {
    return {};
  }
}

/** @type {(name: string, course: Course) => void} */
function memorize(name, course) {
  try {
    sessionStorage.setItem(MEMORY, JSON.stringify({ ...readMemory(), [name]: course }));
  } catch {
    // The course is lost with the page.
  }
}

const memory = readMemory();

// Once an element comes into sight.
/** @type {(element: Element, action: () => void) => void} */
function whenSeen(element, action) {
  const observer = new IntersectionObserver((entries) => {
    if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
    observer.disconnect();
    action();
  });
  observer.observe(element);
}

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
  const program = partOf(lesson, ".code");

  const remember = () =>
    memorize(lesson.id, {
      state: lesson.dataset.state ?? "",
      chosen: choices.flatMap(({ checked }, k) => (checked ? k : [])),
      unfolded: program.open,
    });

  /** @type {(state: string) => void} */
  const enter = (state) => {
    lesson.dataset.state = state;
    for (const fieldset of fieldsets) fieldset.disabled = state !== "guess";
    remember();
  };

  const fill = () => {
    // Where no engine plays, the recorded run stays.
    const plays = !stage.dataset.scene || HAS_ENGINE;
    if (plays && !stage.querySelector(".scene")) openStage(stage);
  };

  const open = () => {
    enter("open");
    fill();
    partOf(lesson, ".pinned").scrollIntoView();
    const first = stage.querySelector("input, button, [tabindex]") ?? partOf(lesson, ".show");
    first.focus({ preventScroll: true });
  };

  const openGuessed = () => {
    if (choices.every((choice) => choice.reportValidity())) open();
  };

  // Guess and result side by side, and what comes of each choice.
  const show = () => {
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
  };

  // Also the button that takes the place of a live scene.
  partOf(lesson, ".experiment").addEventListener("click", (/** @type {any} */ { target }) => {
    if (target.closest(".open")) openGuessed();
    if (target.closest(".open-unguessed")) open();
  });
  guesses.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== "Enter") return;
    // The same key would press the button of the stage that has the focus then.
    event.preventDefault();
    openGuessed();
  });
  guesses.addEventListener("change", remember);
  program.addEventListener("toggle", remember);

  partOf(lesson, ".show").addEventListener("click", () => {
    show();
    answer.focus();
  });

  partOf(lesson, ".again").addEventListener("click", () => {
    for (const choice of choices) choice.checked = false;
    // The experiment begins anew; a recorded picture has none.
    if (stage.querySelector(".scene")) resetStage(stage);
    enter("guess");
    choices[0]?.focus();
  });

  // What the page showed before it was loaded again, or what its address has of the stage.
  const { state = "guess", chosen = [], unfolded = false } = memory[lesson.id] ?? {};
  // Otherwise the browser, which keeps the place, would keep it on a page of another length.
  program.open = unfolded;
  for (const [k, choice] of choices.entries()) choice.checked = chosen.includes(k);
  if (state === "answered") show();
  if (state === "open") enter("open");
  const addressed = () => {
    const [name, ...kept] = location.hash.slice(1).split("&");
    if (name !== lesson.id || !kept.length) return;
    if (lesson.dataset.state === "guess") enter("open");
    fill();
    // Not to where it was: stages above have their heights only once they are seen.
    history.scrollRestoration = "manual";
    partOf(lesson, ".pinned").scrollIntoView();
  };
  if (lesson.dataset.state !== "guess") whenSeen(stage, fill);
  addEventListener("hashchange", addressed);
  addressed();
}

// ---- the list: a small picture of each stage, which moves while it is pointed at or has the focus

const SWEEP = 6000; // ms from one end of what moves to the other
const STILL = 0.6; // share of that which stands still

// A picture of a stage without controls; where an engine plays, of what was recorded.
/** @type {(name: string, place: Element) => Lab} */
function pictureOf(name, place) {
  const film = document.getElementById(`${name}-film`);
  const lab = new Lab(created("div"));
  lab.film = film && JSON.parse(film.textContent);
  lab.isSmall = true;
  stages[name](lab);
  place.append(lab.canvas);
  lab.readColours();
  lab.watch();
  document.addEventListener("languagechange", () => lab.requestDraw());
  return lab;
}

/** @type {(card: HTMLAnchorElement) => void} */
function depict(card) {
  const lab = pictureOf(card.hash.slice(1), partOf(card, ".picture"));

  let begin = 0; // ms: 0 while it stands still
  /** @type {(now: number) => void} */
  const sweep = (now) => {
    const share = begin ? ((now - begin) / SWEEP + STILL) % 2 : STILL;
    lab.sweep(Math.min(share, 2 - share));
    if (begin) requestAnimationFrame(sweep);
  };
  const move = () => {
    if (begin || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    begin = performance.now();
    requestAnimationFrame(sweep);
  };
  const rest = () => {
    begin = 0;
  };
  for (const kind of ["pointerenter", "focus"]) card.addEventListener(kind, move);
  for (const kind of ["pointerleave", "pointercancel", "blur"]) card.addEventListener(kind, rest);
  lab.requestDraw();
  requestAnimationFrame(sweep);
}

for (const card of document.querySelectorAll(".card")) {
  const stage = partOf(document, `${card.getAttribute("href")} .stage`);
  const drawn = !stage.dataset.scene || document.getElementById(`${stage.dataset.stage}-film`);
  if (drawn) whenSeen(card, () => depict(/** @type {HTMLAnchorElement} */ (card)));
}

// ---- until an engine plays, a stage whose program has recorded no film shows how it begins

for (const place of document.querySelectorAll("figure .picture")) {
  whenSeen(place, () => {
    const lab = pictureOf(partOf(place.closest(".lesson") ?? root, ".stage").dataset.stage, place);
    lab.sweep(0);
    lab.isSmall = false; // with its charts
  });
}

// ---- films that repeat can be paused: then a still picture takes their place

for (const film of /** @type {NodeListOf<HTMLImageElement>} */ (
  document.querySelectorAll("img[src^='data:image/gif']")
)) {
  const still = created("canvas", { role: "img", ariaLabel: film.alt, width: film.width });
  still.height = film.height;
  const button = partOf(film.parentElement ?? root, ".pause");
  /** @type {(paused: boolean) => void} */
  const pause = (paused) => {
    if (paused) still.getContext("2d")?.drawImage(film, 0, 0, still.width, still.height);
    (paused ? film : still).replaceWith(paused ? still : film);
    button.setAttribute("aria-pressed", String(paused));
  };
  button.addEventListener("click", () => pause(film.isConnected));
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) {
    film.decode().then(
      () => pause(true),
      () => {},
    );
  }
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
