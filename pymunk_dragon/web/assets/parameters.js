// Sliders of the scene's parameters.

const SEND_EVERY = 100; // ms between two values of a slider that is moved
// ms: after a change by the user, values of the server do not move the slider for so long.
const SETTLE = 500;
const POSITIONS = 400; // steps of a slider

// What a slider of a parameter shows at a position from 0 to 1, and the reverse.
/**
 * @type {(
 *   range: { low: number, high: number, logarithmic?: boolean, whole?: boolean },
 * ) => Scale}
 */
function scaleOf({ low, high, logarithmic, whole }) {
  const log = logarithmic && low > 0;
  /** @type {(position: number) => number} */
  const exact = (position) =>
    log ? low * (high / low) ** position : low + position * (high - low);
  return {
    // The last step stays within 1.
    step: whole && !log && high > low ? (1 - 1e-9) / (high - low) : 1 / POSITIONS,
    valueAt(position) {
      if (position <= 0) return low;
      if (position >= 1) return high;
      const value = exact(position);
      return Math.min(
        Math.max(whole ? Math.round(value) : Number(value.toPrecision(3)), low),
        high,
      );
    },
    positionOf(value) {
      const position = log
        ? Math.log(value / low) / Math.log(high / low)
        : (value - low) / (high - low || 1);
      return Math.min(Math.max(position, 0), 1);
    },
  };
}

class Slider {
  /** @param {Parameter} parameter @param {Send} send */
  constructor(parameter, send) {
    this.parameter = parameter;
    this.scale = scaleOf(parameter);
    this.touched = -SETTLE;
    const id = `parameter-${parameter.name}`;
    this.output = created("output", { htmlFor: id });
    this.input = created("input", {
      id,
      type: "range",
      min: 0,
      max: 1,
      step: this.scale.step,
      className: "sends",
    });
    const label = created("label", { htmlFor: id }, translated(parameter.label || parameter.name));
    if (parameter.rebuilds) {
      label.append(" ", created("span", { className: "note" }, localized("starts again")));
    }
    this.element = created("div", { className: "slider" }, label, this.output, this.input);
    this.listen(send);
    this.show(parameter.value);
  }

  get value() {
    return this.scale.valueAt(this.input.valueAsNumber);
  }

  /** @type {(send: Send) => void} */
  listen(send) {
    const message = () => send({ do: "set", name: this.parameter.name, value: this.value });
    const soon = throttled(message, SEND_EVERY);
    this.input.addEventListener("input", () => {
      this.touched = performance.now();
      this.write(this.value);
      if (!this.parameter.rebuilds) soon();
    });
    // A value that is chosen goes out before what the user does next.
    this.input.addEventListener("change", () => {
      if (this.parameter.rebuilds) message();
      else soon.flush();
    });
  }

  // A value of the server.
  /** @type {(value: number) => void} */
  show(value) {
    if (!Number.isFinite(value) || performance.now() - this.touched < SETTLE) return;
    if (this.value !== value) this.input.value = String(this.scale.positionOf(value));
    this.write(value);
  }

  /** @type {(value: number) => void} */
  write(value) {
    const text = `${numberText(value)} ${translated(this.parameter.unit)}`.trim();
    this.output.textContent = text;
    this.input.setAttribute("aria-valuetext", text);
  }
}

// A number with three significant digits, or others; large and small ones in exponents.
/** @type {(value: number, digitsShown?: number) => string} */
function numberText(value, digitsShown = 3) {
  const size = Math.abs(value);
  if (size >= 10 ** (digitsShown + 3) || (size > 0 && size < 1e-4)) {
    const [digits, power] = value.toExponential(digitsShown - 1).split("e");
    return `${signed(Number(digits))}·10${superscript(Number(power))}`;
  }
  return signed(
    size >= 10 ** digitsShown ? Math.round(value) : Number(value.toPrecision(digitsShown)),
  );
}

class Sliders {
  /** @param {HTMLElement} container @param {Send} send */
  constructor(container, send) {
    this.container = container;
    this.send = send;
    /** @type {Slider[]} */
    this.sliders = [];
    this.shape = "";
  }

  // A rebuilt scene with the same parameters keeps its sliders, and with them the focus;
  // not in another language.
  /** @type {(parameters: Parameter[]) => void} */
  setParameters(parameters) {
    const fixed = parameters.map((parameter) => ({ ...parameter, value: null }));
    const shape = JSON.stringify([language, ...fixed]);
    if (shape !== this.shape) {
      this.shape = shape;
      this.sliders = parameters.map((parameter) => new Slider(parameter, this.send));
      this.container.replaceChildren(...this.sliders.map(({ element: made }) => made));
    }
    this.setValues(Object.fromEntries(parameters.map(({ name, value }) => [name, value])));
  }

  /** @type {(values: Record<string, number>) => void} */
  setValues(values) {
    for (const slider of this.sliders) slider.show(values[slider.parameter.name]);
  }
}
