// The worker of a published page: Python, its libraries, and a session that the event loop steps.

const FOLDER = "/home/pyodide/"; // where the program and its files are, as on a desktop

async function read(address) {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

// Python posts an object, and sometimes bytes, of which this takes a copy.
function post(content, bytes) {
  const posted = content.toJs({ dict_converter: Object.fromEntries });
  if (!bytes) {
    postMessage(posted);
    return;
  }
  const { buffer } = bytes.toJs();
  postMessage({ ...posted, bytes: buffer }, [buffer]);
}

// Load Python and all it needs; the module that begins sessions and runs programs.
async function load({ runtime, packages = [], wheels, files }) {
  postMessage({ stage: 1 });
  const base = new URL(runtime, self.location.href).href;
  // Some servers give .mjs a wrong type; Pyodide's own does not.
  const ending = packages.length > 0 ? "mjs" : "js";
  const archives = Promise.all(wheels.map(read));
  const contents = Promise.all(files.map((name) => read(`files/${name}`)));
  const [{ loadPyodide }, { default: createPyodideModule }] = await Promise.all([
    import(`${base}pyodide.${ending}`),
    import(`${base}pyodide.asm.${ending}`),
  ]);
  const python = await loadPyodide({ indexURL: base, createPyodideModule });

  postMessage({ stage: 2 });
  const quiet = { messageCallback: () => {} };
  if (packages.length > 0) await python.loadPackage(packages, quiet);
  // Not into the working directory, which a program may change.
  const extractDir = python.pyimport("site").getsitepackages().get(0);
  for (const archive of await archives) python.unpackArchive(archive, "wheel", { extractDir });
  for (const [i, content] of (await contents).entries()) {
    const path = FOLDER + files[i];
    python.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    python.FS.writeFile(path, new Uint8Array(content));
  }

  postMessage({ stage: 3 });
  return python.pyimport("pymunk_dragon.publish.worker");
}

let loading = null; // the module that begins a session, when it is there
let page = null; // what takes the messages of the page

// An object is a page that begins, also in place of another one, whose session ends; or the texts
// of a program, of which what it prints and its pictures are posted.
self.onmessage = async ({ data }) => {
  if (typeof data !== "object") {
    page?.take_post(data);
    return;
  }
  try {
    loading ??= load(data);
    const { begin, run } = await loading;
    page?.session.leave(page);
    page?.session.stop();
    page = null;
    postMessage({ stage: 4 });
    if (data.texts && !data.program) {
      run(post, data.texts);
      return;
    }
    page = begin(post, data.program ?? "", data.scene, data.texts) ?? null;
    page?.take_post(0);
  } catch (error) {
    loading = null;
    postMessage({ failure: { text: String(error) } });
  }
};
