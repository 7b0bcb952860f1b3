// Languages of the page: its texts are English, and the
// page has a catalogue from English to each other language.

/** @type {Record<string, Texts>} */
const CATALOGUES = { en: {}, ...JSON.parse(element("texts").textContent) };
// Elements without texts of the page.
const UNTRANSLATED = "script, style, svg, canvas, kbd, code, [translate=no]";
const HAS_LETTERS = /\p{L}/u;
/** @type {Texts} */
const LANGUAGE_NAMES = { en: "English", zh: "中文" };
/** @type {Texts} */
const KEY_SIGNS = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", "-": "−" };
const TRANSLATED_ATTRIBUTES = ["aria-label", "title"];

let language = "en";

// A text in the page's language, if the catalogue has it.
/** @type {(english: string) => string} */
const translated = (english) => CATALOGUES[language][english] ?? english;

/** @type {(template: string, values: Values) => string} */
const fill = (template, values) =>
  template.replace(/\{(\w+)\}/g, (field, name) => values[name] ?? field);

// The same of a text of the scripts, with values for its {fields}.
/** @type {(english: string, values?: Values) => string} */
const localized = (english, values = {}) => fill(translated(english), values);

// The language that a part of the address chooses, as lang=zh or zh.
/** @type {(part: string) => string | undefined} */
function languageIn(part) {
  const query = new URLSearchParams(part.slice(1));
  const name = query.get("lang") ?? Object.keys(CATALOGUES).find((each) => query.has(each));
  return name && Object.hasOwn(CATALOGUES, name) ? name : undefined;
}

// Without a choice in #lang=zh: that in ?lang=zh or ?zh,
// or the language in which the page was written.
const DEFAULT_LANGUAGE = languageIn(location.search) ?? document.documentElement.lang;
const chosenLanguage = () => languageIn(location.hash) ?? DEFAULT_LANGUAGE;

// The innermost elements that have all parts of a sentence.
/** @param {Element} parent @returns {Generator<Element>} */
function* textElements(parent) {
  for (const child of parent.children) {
    if (child.matches(UNTRANSLATED)) continue;
    if ([...child.childNodes].some((node) => node instanceof Text && HAS_LETTERS.test(node.data))) {
      yield child;
    } else yield* textElements(child);
  }
}

// Elements that a key clicks, with the key.
/** @type {() => [HTMLElement, string][]} */
const withKeys = () =>
  Array.from(document.querySelectorAll("[aria-keyshortcuts]"), (each) => [
    /** @type {HTMLElement} */ (each),
    each.getAttribute("aria-keyshortcuts") ?? "",
  ]);

for (const [each] of withKeys()) each.title ||= each.ariaLabel ?? each.textContent;

// The page's own texts in English, with what sets each of them.
/** @type {[string, (text: string) => void][]} */
const STATIC_TEXTS = [
  [
    document.title,
    (text) => {
      document.title = text;
    },
  ],
];

for (const found of textElements(document.body)) {
  const english = found.innerHTML.replace(/\s+/g, " ").trim();
  const set = (/** @type {string} */ text) => {
    found.innerHTML = text;
  };
  STATIC_TEXTS.push([english, set]);
}

for (const name of TRANSLATED_ATTRIBUTES) {
  for (const found of document.querySelectorAll(`[${name}]`)) {
    const set = (/** @type {string} */ text) => found.setAttribute(name, text);
    STATIC_TEXTS.push([found.getAttribute(name) ?? "", set]);
  }
}

// Texts that scripts write follow from the next drawing.
/** @type {(name: string) => void} */
function setLanguage(name) {
  language = name;
  document.documentElement.lang = name;
  for (const [english, write] of STATIC_TEXTS) write(translated(english));
  showKeys();
  const other = otherLanguage();
  Object.assign(element("language"), { lang: other, textContent: LANGUAGE_NAMES[other] });
}

// Hints name the keys, and the help lists them.
function showKeys() {
  element("keys").replaceChildren(
    ...withKeys().map(([each, key]) => {
      const sign = keySign(key);
      const what = each.title;
      each.title = `${what} (${sign})`;
      return created(
        "div",
        {},
        created("dt", {}, created("kbd", {}, sign)),
        created("dd", {}, what),
      );
    }),
  );
}

/** @type {(key: string) => string} */
const keySign = (key) =>
  key === "Space" || key === " " ? localized("space") : (KEY_SIGNS[key] ?? key);

/** @type {() => string} */
const otherLanguage = () => Object.keys(CATALOGUES).find((each) => each !== language) ?? "en";

/** @type {(playing: boolean) => void} */
function showPlaying(playing) {
  document.body.classList.toggle("playing", playing);
  const what = playing ? localized("Pause") : localized("Play");
  Object.assign(element("play"), { ariaLabel: what, title: `${what} (${localized("space")})` });
}
