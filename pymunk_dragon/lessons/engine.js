// The engine's dragon beside the exact one: rule, step and iterations, and the errors they left.
stages.engine = (lab) => {
  const magnified = 200; // times: what a millimetre looks like
  const last = 8; // s
  /** @type {EngineRuns} */
  const { substeps, passes, errors, moved, exact } = JSON.parse(block("engine-data"));
  const frames = exact.length;
  const dragon = makeDragon({ benches: exact[0].length - 1 });
  /** @type {Words[]} */
  const rules = [
    ["Pymunk's step", "引擎原来的步"],
    ["force in the middle", "力作用在正中"],
  ];
  const colours = ["body", "tail"]; // of the rules

  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: last,
    step: 0.02,
    value: 0,
    unit: "s",
    digits: 2,
    play: () => 1.6,
  });
  const step = lab.slider(["step", "步长"], {
    min: 0,
    max: substeps.length - 1,
    step: 1,
    value: 0,
    show: (i) => `${1000 * substeps[i]} ms`,
  });
  const order = lab.slider(["rule", "规则"], {
    min: 1,
    max: 2,
    step: 1,
    value: 1,
    show: (value) => lab.say(rules[value - 1]),
  });
  const iterations = lab.slider(["iterations", "迭代次数"], {
    min: 0,
    max: passes.length - 1,
    step: 1,
    value: 2,
    show: (i) => `${passes[i]}`,
  });

  // The steps that were played to the end, for each rule and number of iterations.
  /** @type {Map<string, Set<number>>} */
  const tried = new Map();
  const name = () => `${order.value} ${passes[iterations.value]}`;
  // Vectors at the time, on straight lines between frames.
  /** @type {(path: Point[][]) => Point[]} */
  const now = (path) => {
    const frame = (time.value / last) * (frames - 1);
    const before = Math.min(Math.floor(frame), frames - 2);
    const share = frame - before;
    return path[before].map(([x, y], i) => {
      const [nextX, nextY] = path[before + 1][i];
      return [x + share * (nextX - x), y + share * (nextY - y)];
    });
  };
  // How far the handles are off, in m.
  /** @type {() => Point[]} */
  const off = () => now(moved[name()][step.value]).map(([x, y]) => [1e-5 * x, 1e-5 * y]);

  lab.label = [
    "The engine's dragon beside the exact one, and the largest errors over the step",
    "引擎算出的板凳龙与精确的板凳龙，以及最大误差随步长的变化",
  ];
  lab.update = () => {
    if (time.value < last) return;
    const steps = tried.get(name()) ?? new Set();
    tried.set(name(), steps.add(step.value));
  };
  lab.pane(
    0.6,
    () => {
      const [x, y] = now(exact)[5];
      return { x, y, size: 10, wide: 15 };
    },
    (pane) => {
      const handles = now(exact);
      const apart = off();
      const colour = colours[order.value - 1];
      const own = handles.map(
        ([x, y], i) => /** @type {Point} */ ([
          x + magnified * apart[i][0],
          y + magnified * apart[i][1],
        ]),
      );
      pane.benches(benchesBetween(dragon, handles), () => "curve", 0.7);
      pane.benches(benchesBetween(dragon, own), (i) => (i === 0 ? "head" : colour), 0.85);
      handles.forEach((handle, i) => pane.line([handle, own[i]], { colour: "contact", width: 3 }));
      const worst = smallestOf([...handles.keys()], (i) => -Math.hypot(...apart[i]));
      if (time.value > 0) pane.text(own[worst], millimetres(apart[worst]), { dx: 30 });
    },
  );
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
  lab.pane(
    0.4,
    () => ({
      across: [beyond - 0.4, beyond + substeps.length - 0.6],
      up: [-2.6, 1.2],
      tick,
      name: ["largest error (mm) over the step", "最大误差 (mm) 随步长的变化"],
    }),
    (pane) => {
      for (const [key, steps] of tried) {
        const colour = colours[Number(key[0]) - 1];
        const points = [...steps]
          .sort((a, b) => a - b)
          .map((i) => /** @type {Point} */ ([across(i), Math.log10(errors[key][i])]));
        pane.line(points, { colour, width: key === name() ? 3 : 1 });
        for (const point of points) pane.dot(point, { colour, radius: 5 });
      }
      if (tried.size) return;
      pane.text(
        [beyond + (substeps.length - 1) / 2, -0.7],
        lab.say(["play to the end: here comes a point", "播放到底，这里就有一个点"]),
        { colour: "quiet" },
      );
    },
  );
  lab.readout = () => {
    const found = errors[name()];
    const i = step.value;
    if (time.value < last) {
      const size = (1000 * Math.max(...off().map(([x, y]) => Math.hypot(x, y)))).toFixed(2);
      return [
        `Of these benches the worst is ${size} mm off now.`,
        `这几节板凳中误差最大的此刻偏离 ${size} mm。`,
      ];
    }
    const size = found[i].toPrecision(3);
    const share = tried.get(name())?.has(i - 1) ? (found[i] / found[i - 1]).toFixed(2) : "";
    return [
      `In 8 s the worst bench was ${size} mm off` +
        (share ? `, ${share} of the error in steps twice as long.` : "."),
      `8 s 内误差最大的板凳偏离 ${size} mm` + (share ? `，是步长加倍时的 ${share}。` : "。"),
    ];
  };
};
