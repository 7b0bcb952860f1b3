"use strict";

// Languages: a button for each, and the address remembers which (lessons.html?zh#chain).
const root = document.documentElement;
const buttons = [...document.querySelectorAll(".languages button")];

function speak(language) {
  root.lang = language;
  document.title = document.querySelector(`h1 [lang="${language}"]`).textContent;
  for (const button of buttons) button.setAttribute("aria-pressed", button.value === language);
  for (const figure of document.querySelectorAll("figure")) {
    figure.querySelector("img").alt = figure.querySelector(`figcaption [lang="${language}"]`).textContent;
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

// On paper everything is unfolded.
let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  for (const details of folded) details.open = true;
});
addEventListener("afterprint", () => {
  for (const details of folded) details.open = false;
});
