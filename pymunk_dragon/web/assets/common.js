// What all parts use: elements of the page, angles and round numbers.

const TURN = 2 * Math.PI;

/** @type {<K extends string & keyof PageElements>(id: K) => PageElements[K]} */
const element = (id) => /** @type {any} */ (document.getElementById(id));

// Set a property only if it changes: a change costs the browser more than drawing does.
/** @type {(target: any, name: string, value: unknown) => void} */
function write(target, name, value) {
  if (target[name] !== value) target[name] = value;
}

/** @type {(id: string, text: string) => void} */
const setText = (id, text) => write(element(id), "textContent", text);

/**
 * @type {<K extends keyof HTMLElementTagNameMap>(
 *   tag: K,
 *   properties?: object,
 *   ...children: (Node | string)[],
 * ) => HTMLElementTagNameMap[K]}
 */
function created(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** @type {(blob: Blob, name: string) => void} */
function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The address must remain valid until the browser has begun to read.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

// Replace the address of the page, or a part of it.
/** @type {(address: string) => void} */
function rememberAddress(address) {
  try {
    history.replaceState(null, "", address);
  } catch (error) {
    // A page in a frame may have no address of its own, or may not change it.
    if (!(error instanceof DOMException && error.name === "SecurityError")) throw error;
  }
}

// The smallest of 1, 2 or 5 times a power of ten that is not below a value.
/** @type {(value: number) => number} */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 5].find((digit) => digit * power >= value) ?? 10) * power;
}

/** @type {(number: number) => string} */
const signed = (number) => String(number).replace("-", "−");

// Values at equal distances, both limits included.
/** @type {(from: number, to: number, count: number) => number[]} */
function range(from, to, count) {
  return Array.from({ length: count + 1 }, (_, i) => from + (count && ((to - from) * i) / count));
}

/** @type {<T>(items: ArrayLike<T>) => T} */
const lastOf = (items) => items[items.length - 1];

// Rows of an array of numbers, as arrays.
/** @param {Float64Array} numbers @param {number} size */
function* rowsOf(numbers, size) {
  for (let k = 0; k < numbers.length; k += size) yield numbers.subarray(k, k + size);
}

/** @type {(value: number, least: number, most: number) => number} */
const bounded = (value, least, most) => Math.min(Math.max(value, least), most);

// Call `action` with the newest value, at most once in `interval` ms; `flush` calls it now
// where a value waits.
/**
 * @type {<T>(action: (newest: T) => void, interval: number) =>
 *   ((value?: T) => void) & { flush: () => void }}
 */
function throttled(action, interval) {
  /** @type {number | null} */
  let timer = null;
  /** @type {any} */
  let newest;
  let last = -interval;

  const run = () => {
    timer = null;
    last = performance.now();
    action(newest);
  };

  /** @type {(value?: any) => void} */
  const later = (value) => {
    newest = value;
    timer ??= setTimeout(run, Math.max(0, last + interval - performance.now()));
  };

  const flush = () => {
    if (timer === null) return;
    clearTimeout(timer);
    run();
  };

  return Object.assign(later, { flush });
}
