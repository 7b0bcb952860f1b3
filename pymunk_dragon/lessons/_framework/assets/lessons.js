"use strict";

// Languages: a button for each, and the address remembers which (lessons.html?zh#chain).
const root = document.documentElement;
const buttons = [...document.querySelectorAll(".languages button")];

function speak(language) {
  root.lang = language;
  document.title = document.querySelector(`h1 [lang="${language}"]`).textContent;
  for (const button of buttons) button.setAttribute("aria-pressed", button.value === language);
  for (const figure of document.querySelectorAll("figure")) {
    const alt = figure.querySelector(`figcaption [lang="${language}"]`).textContent;
    for (const image of figure.querySelectorAll("img:first-child")) image.alt = alt;
  }
}

for (const button of buttons) {
  button.addEventListener("click", () => {
    speak(button.value);
    history.replaceState(null, "", `?${button.value}${location.hash}`);
  });
}
const asked = location.search.slice(1);
speak(buttons.some((button) => button.value === asked) ? asked : root.lang);

// A film begins anew each time that it is unfolded: a browser plays on what it has shown before, unless its address is new.
for (const details of document.querySelectorAll("details.run")) {
  const film = details.querySelector(".film");
  if (!film) continue;
  const [type, data] = film.src.slice("data:".length).split(";base64,");
  const bytes = Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  film.removeAttribute("src");
  details.addEventListener("toggle", () => {
    URL.revokeObjectURL(film.src);
    if (details.open) film.src = URL.createObjectURL(new Blob([bytes], { type }));
    else film.removeAttribute("src");
  });
}

// A guess is checked once the form is complete; another choice takes the verdict away.
for (const form of document.querySelectorAll(".guesses")) {
  const show = (shown) => {
    for (const fieldset of form.querySelectorAll("fieldset")) {
      const verdict = fieldset.querySelector(".verdict");
      verdict.classList.toggle("hit", fieldset.querySelector("input:checked")?.value === fieldset.dataset.right);
      verdict.hidden = !shown;
    }
  };
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    show(true);
  });
  form.addEventListener("change", () => show(false));
}

// Sheets to print: for the class or for the teacher, of one lesson or of all.
for (const button of document.querySelectorAll(".sheets button")) {
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

// On paper everything is unfolded.
let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  for (const details of folded) details.open = true;
});
addEventListener("afterprint", () => {
  for (const details of folded) details.open = false;
});
