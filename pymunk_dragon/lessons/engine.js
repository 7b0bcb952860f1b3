// Rule, step and iterations of the engine: each setting leaves a point in a chart of the error.
stages.engine = (lab) => {
  /** @type { { substeps: number[], passes: number[], errors: Record<string, number[]> }} */
  const { substeps, passes, errors } = JSON.parse(block("engine-data"));
  /** @type {Words[]} */
  const rules = [
    ["Pymunk's step", "引擎原来的步"],
    ["force in the middle", "力作用在正中"],
  ];
  const order = lab.slider(["rule", "规则"], {
    min: 1,
    max: 2,
    step: 1,
    value: 1,
    show: (value) => lab.say(rules[value - 1]),
  });
  const step = lab.slider(["step", "步长"], {
    min: 0,
    max: substeps.length - 1,
    step: 1,
    value: 0,
    show: (i) => `${1000 * substeps[i]} ms`,
  });
  const iterations = lab.slider(["iterations", "迭代次数"], {
    min: 0,
    max: passes.length - 1,
    step: 1,
    value: 2,
    show: (i) => `${passes[i]}`,
  });

  // The steps that were tried, for each rule and number of iterations.
  /** @type {Map<string, Set<number>>} */
  const tried = new Map();
  const name = () => `${order.value} ${passes[iterations.value]}`;
  // Steps are halvings from the finest one, beyond all logarithms of errors, so that one function
  // writes both.
  const beyond = 100;
  /** @type {(i: number) => number} */
  const across = (i) => beyond + substeps.length - 1 - i;
  /** @type {(value: number) => string} */
  const tick = (value) => {
    if (!Number.isInteger(value)) return "";
    if (value < beyond / 2) return `${10 ** value}`;
    const i = across(value);
    return i in substeps ? `${1000 * substeps[i]} ms` : "";
  };

  lab.label = [
    "The error over the step, for the settings that were tried",
    "误差随步长的变化：试过的各组设置",
  ];
  lab.update = () => {
    const steps = tried.get(name()) ?? new Set();
    tried.set(name(), steps.add(step.value));
  };
  lab.pane(
    1,
    () => ({
      across: [beyond - 0.4, beyond + substeps.length - 0.6],
      up: [-2.6, 1.2],
      tick,
      name: ["largest error (mm) by the length of the steps", "最大误差 (mm) 随步长的变化"],
    }),
    (pane) => {
      for (const [key, steps] of tried) {
        const colour = key.startsWith("1") ? "head" : "body";
        const points = [...steps]
          .sort((a, b) => a - b)
          .map((i) => /** @type {Point} */ ([across(i), Math.log10(errors[key][i])]));
        pane.line(points, { colour, width: key === name() ? 3 : 1 });
        for (const point of points) pane.dot(point, { colour, radius: 4 });
      }
      const now = Math.log10(errors[name()][step.value]);
      pane.dot([across(step.value), now], { colour: "contact", radius: 6 });
    },
  );
  lab.readout = () => {
    const found = errors[name()];
    const i = step.value;
    const size = found[i].toPrecision(3);
    const share = tried.get(name())?.has(i - 1) ? (found[i] / found[i - 1]).toFixed(2) : "";
    return [
      `The worst bench is ${size} mm off` +
        (share ? `, ${share} of the error in steps twice as long.` : "."),
      `误差最大的板凳偏离 ${size} mm` + (share ? `，是步长加倍时的 ${share}。` : "。"),
    ];
  };
};
