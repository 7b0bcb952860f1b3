// Runs a Python script in Pyodide: `node pyodide.mjs SCRIPT RESULTS ARCHIVE...`. There, /repository
// is this repository, /results the folder RESULTS, and the archives lie unpacked among the
// libraries. RESULTS/usage.json gets the processor time of each stage, s, and the memory, bytes.

import { readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [script, results, ...archives] = process.argv.slice(2);
const folder = process.env.PYODIDE_RUNTIME;
const module = folder ? pathToFileURL(resolve(folder, "pyodide.mjs")).href : "pyodide";

let before = 0;
const usage = {};
/** Note what a stage took. */
function stage(name) {
  const { user, system } = process.cpuUsage();
  const now = (user + system) / 1e6;
  usage[name] = now - before;
  before = now;
}

const { loadPyodide } = await import(module);
// Nothing is written to the repository.
const python = await loadPyodide({
  env: {
    HOME: "/results",
    PYODIDE_TESTS: process.env.PYODIDE_TESTS ?? "",
    PYTHONDONTWRITEBYTECODE: "1",
  },
});
stage("runtime");

const libraries = python.runPython("import site; site.getsitepackages()[0]");
for (const archive of archives) {
  const bytes = new Uint8Array(readFileSync(archive));
  python.unpackArchive(bytes, "zip", { extractDir: libraries });
}
python.mountNodeFS("/repository", resolve(import.meta.dirname, "../.."));
python.mountNodeFS("/results", resolve(results));
python.runPython('import sys; sys.path[:0] = "/repository/tests", "/repository"');
stage("libraries");

try {
  python.runPython(readFileSync(script, "utf8"), { filename: script });
} catch (error) {
  // Node would print the line of the error, which is the whole runtime.
  console.error(error.message);
  process.exit(1);
}
stage("script");
usage.memory = 1024 * process.resourceUsage().maxRSS;
writeFileSync(resolve(results, "usage.json"), JSON.stringify(usage));
// Python may have timers that keep node running.
process.exit(0);
