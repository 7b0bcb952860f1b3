// Puts NumPy, cffi and Pillow of Pyodide's distribution into a folder: `node wheels.mjs FOLDER`.
// PYODIDE_WHEELS then names it for the tests.

import { mkdirSync, readdirSync } from "node:fs";
import { loadPyodide } from "pyodide";

const folder = process.argv[2];
mkdirSync(folder, { recursive: true });
const python = await loadPyodide({ packageCacheDir: folder });
await python.loadPackage(["numpy", "cffi", "pillow"]);
// What cannot be downloaded is only reported by the runtime.
const wheels = readdirSync(folder).filter((name) => name.endsWith(".whl"));
process.exit(wheels.length >= 3 ? 0 : 1);
