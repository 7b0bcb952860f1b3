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

async function load({ runtime, packages = [], wheels, files, program = "", scene }) {
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
  if (packages.length > 0) await python.loadPackage(packages);
  for (const archive of await archives) python.unpackArchive(archive, "wheel");
  for (const [i, content] of (await contents).entries()) {
    const path = FOLDER + files[i];
    python.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    python.FS.writeFile(path, new Uint8Array(content));
  }

  postMessage({ stage: 3 });
  const { begin } = python.pyimport("pymunk_dragon.publish.worker");
  postMessage({ stage: 4 });
  return begin(post, program, scene);
}

self.onmessage = async ({ data: site }) => {
  try {
    const page = await load(site);
    if (!page) return; // What went wrong has been posted.
    self.onmessage = ({ data }) => page.take_post(data);
    page.take_post(0);
  } catch (error) {
    postMessage({ failure: { text: String(error) } });
  }
};
