// Rules for the scripts of the pages. All but one are classic scripts, which Python joins into one
// per page: what a script declares at its top is a global of the others on the same page.

import { readdirSync, readFileSync } from "node:fs";
import path from "node:path";
import js from "@eslint/js";
import { defineConfig } from "eslint/config";
import globals from "globals";

const ROOT = path.resolve(import.meta.dirname, "../..");
const MODULE = "pymunk_dragon/sessions/assets/widget.js";

// The folders of the scripts of each page; those of the first one are on all pages.
const SHARED = "pymunk_dragon/web/assets";
const PAGES = [
  ["pymunk_dragon/player/assets"],
  ["pymunk_dragon/sessions/assets"],
  ["pymunk_dragon/lessons/_framework/assets", "pymunk_dragon/lessons"],
];

const DECLARATION = /^(?:async )?(?:const|let|class|function\*?) ([\w$]+)/gm;
const COMMENT = /(?:^|\s)\/\/ .*$/gm;

function readScripts(folder) {
  const names = readdirSync(path.join(ROOT, folder)).filter((name) => name.endsWith(".js"));
  return names.map((name) => {
    const file = `${folder}/${name}`;
    const source = readFileSync(path.join(ROOT, file), "utf8").replace(COMMENT, "");
    const declared = Array.from(source.matchAll(DECLARATION), ([, found]) => found);
    return { file, declared, words: new Set(source.match(/[\w$]+/g)) };
  });
}

// The settings of one script, with the others of its page or, if it is shared, of all pages.
function settingsOf(script, others, seen) {
  const declared = seen.flatMap((other) => other.declared);
  const used = script.declared.filter((name) => others.some(({ words }) => words.has(name)));
  return {
    files: [script.file],
    languageOptions: { globals: Object.fromEntries(declared.map((name) => [name, "readonly"])) },
    // A name of the script's own that only others use is used.
    rules: { "no-unused-vars": ["error", { varsIgnorePattern: `^(?:${used.join("|")})$` }] },
  };
}

const shared = readScripts(SHARED);
const pages = PAGES.map((folders) => folders.flatMap(readScripts));
const without = (scripts, script) => scripts.filter((other) => other !== script);

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
  ...shared.map((script) => {
    const seen = without(shared, script);
    return settingsOf(script, [...seen, ...pages.flat()], seen);
  }),
  ...pages.flatMap((page) =>
    page.map((script) => {
      const seen = without(page, script);
      return settingsOf(script, seen, [...shared, ...seen]);
    }),
  ),
]);
