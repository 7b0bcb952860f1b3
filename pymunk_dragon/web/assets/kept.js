// What a stage keeps in the address: sliders and dragged things that differ from their first state,
// as #near-miss&time=412.6.

const ADDRESS_EVERY = 500; // ms: browsers refuse changes of the address that come too fast

class Kept {
  // A stage without a `name`, as a small one in the list, has no address.
  /** @param {Lab} lab @param {string | undefined} name */
  constructor(lab, name) {
    this.lab = lab;
    this.name = name;
    /** @type {Map<string, { get: () => any, set: (value: any) => void }>} */
    this.things = new Map();
    /** @type {Map<string, any> | null} */
    this.first = null; // what each had with the first picture
    this.written = "";
    this.writeSoon = throttled((/** @type {string} */ state) => {
      if (lab.canvas.isConnected) rememberAddress(`#${name}${state}`);
    }, ADDRESS_EVERY);
    addEventListener("hashchange", () => this.take());
  }

  /** @type {(name: string, get: () => any, set: (value: any) => void) => void} */
  add(name, get, set) {
    this.things.set(name.replaceAll(" ", "_"), { get, set });
  }

  // With the first picture.
  begin() {
    if (this.first) return;
    // Copies, as a dragged point may change in its list.
    this.first = new Map([...this.things].map(([name, { get }]) => [name, structuredClone(get())]));
    this.take();
  }

  // Take what the address has. Twice, as a slider may reach a value only when another has moved.
  take() {
    const [name, ...parts] = location.hash.slice(1).split("&");
    if (name !== this.name || !parts.length || !this.lab.canvas.isConnected) return;
    for (const part of [...parts, ...parts]) {
      const [thing, text = ""] = part.split("=");
      const value = readJson(text);
      if (alike(value, this.first?.get(thing))) this.things.get(thing)?.set(value);
      this.lab.update?.();
    }
    this.lab.requestDraw();
  }

  // After each picture.
  remember() {
    if (!this.name || !this.first) return;
    let state = "";
    for (const [name, { get }] of this.things) {
      const value = shortJson(get());
      if (value !== shortJson(this.first.get(name))) state += `&${name}=${value}`;
    }
    if (state === this.written) return;
    this.written = state;
    this.writeSoon(state);
  }
}

// JSON with numbers of six digits.
/** @type {(value: any) => string} */
const shortJson = (value) =>
  JSON.stringify(value, (_, each) =>
    typeof each === "number" ? Number(each.toPrecision(6)) : each,
  );

/** @type {(text: string) => any} */
function readJson(text) {
  try {
    return JSON.parse(decodeURIComponent(text));
  } catch {
    return undefined;
  }
}

// Whether a value can take the place of the first one: a finite number, a list as long of them, or
// a list of such lists.
/** @type {(value: any, first: any) => boolean} */
function alike(value, first) {
  if (!Array.isArray(first)) return typeof value === typeof first && Number.isFinite(value ?? NaN);
  if (!Array.isArray(value)) return false;
  const lists = Array.isArray(first[0]);
  const fits = lists ? value.length > 0 : !first.length || value.length === first.length;
  return fits && value.every((each) => alike(each, first[0] ?? 0));
}
