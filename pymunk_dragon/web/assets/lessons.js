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
    // Where no engine plays, the recorded run stays.
    const plays = !stage.dataset.scene || HAS_ENGINE;
    if (plays && !stage.querySelector("canvas")) openStage(stage);
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
    // The experiment begins anew.
    if (stage.dataset.scene) playedNow?.begin();
    else stage.replaceChildren();
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
