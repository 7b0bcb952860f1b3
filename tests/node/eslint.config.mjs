// Rules for the scripts of the pages. All but one are classic scripts, which Python joins into one
// per page: what a script declares at its top is a global of those that follow it on a page.

import { readdirSync, readFileSync } from "node:fs";
import path from "node:path";
import js from "@eslint/js";
import { defineConfig } from "eslint/config";
import globals from "globals";

const ROOT = path.resolve(import.meta.dirname, "../..");
const MODULE = "pymunk_dragon/sessions/assets/widget.js";
const ASSETS = "pymunk_dragon/web/assets";
const LESSONS = "pymunk_dragon/lessons";

const DECLARATION = /^(?:async )?(?:const|let|class|function\*?) ([\w$]+)/gm;
const COMMENT = /(?:^|\s)\/\/ .*$/gm;

function readScript(file) {
  const source = readFileSync(path.join(ROOT, file), "utf8").replace(COMMENT, "");
  const declared = Array.from(source.matchAll(DECLARATION), ([, found]) => found);
  return { file, declared, words: new Set(source.match(/[\w$]+/g)) };
}

const groups = JSON.parse(readFileSync(path.join(ROOT, ASSETS, "scripts.json"), "utf8"));
const named = (group) => groups[group].map((name) => readScript(`${ASSETS}/${name}.js`));
const stages = readdirSync(path.join(ROOT, LESSONS))
  .filter((name) => name.endsWith(".js"))
  .map((name) => readScript(`${LESSONS}/${name}`));
// The scripts of each page, in their order.
const pages = [
  [...named("viewer"), ...named("player")],
  [...named("viewer"), ...named("live")],
  [...named("lab"), ...named("played"), ...stages, ...named("lessons")],
];

// The settings of one script. It sees what is declared before it on each of its pages.
function settingsOf(file) {
  const own = pages.filter((page) => page.some((script) => script.file === file));
  const before = own.map((page) => {
    const place = page.findIndex((script) => script.file === file);
    return new Set(page.slice(0, place).flatMap(({ declared }) => declared));
  });
  const seen = [...before[0]].filter((name) => before.every((names) => names.has(name)));
  const { declared } = own[0].find((script) => script.file === file);
  const others = own.flat().filter((script) => script.file !== file);
  const used = declared.filter((name) => others.some(({ words }) => words.has(name)));
  return {
    files: [file],
    languageOptions: { globals: Object.fromEntries(seen.map((name) => [name, "readonly"])) },
    // A name of the script's own that only others use is used.
    rules: { "no-unused-vars": ["error", { varsIgnorePattern: `^(?:${used.join("|")})$` }] },
  };
}

const files = new Set(pages.flat().map(({ file }) => file));

export default defineConfig([
  { files: ["**/*.js"], extends: [js.configs.recommended] },
  {
    files: ["**/*.js"],
    languageOptions: { sourceType: "script", globals: globals.browser },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      "max-statements-per-line": ["error", { max: 1 }],
      "one-var": ["error", "never"],
      curly: ["error", "multi-line"],
      eqeqeq: "error",
      "no-shadow": "error",
      "no-var": "error",
      "prefer-const": "error",
    },
  },
  { files: [MODULE], languageOptions: { sourceType: "module" } },
  ...Array.from(files, settingsOf),
]);
