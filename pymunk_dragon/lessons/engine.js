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
  let order = 1;
  lab.button(
    () =>
      order === 1
        ? ["Let the force act in the middle", "让力作用在正中"]
        : ["Back to Pymunk's step", "回到引擎原来的步"],
    () => {
      order = 3 - order;
    },
  );
  lab.keep(
    "rule",
    () => order,
    (given) => {
      order = given === 2 ? 2 : 1;
    },
  );
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
  const name = () => `${order} ${passes[iterations.value]}`;
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
  // How far the handles are off, in hundredths of a millimetre.
  /** @type {() => Point[]} */
  const off = () => now(moved[name()][step.value]);
  /** @type {(vector: Numbers) => string} */
  const millimetres = ([x, y]) => `${(Math.hypot(x, y) / 100).toFixed(2)} mm`;
  /** @type {(vectors: Point[]) => number} */
  const farthest = (vectors) =>
    smallestOf([...vectors.keys()], (i) => -Math.hypot(vectors[i][0], vectors[i][1]));

  lab.label = [
    "The engine's dragon beside the exact one, and the largest errors over the step",
    "引擎算出的板凳龙与精确的板凳龙，以及最大误差随步长的变化",
  ];
  lab.legend([
    ["curve", ["exact", "精确"]],
    ["body", rules[0]],
    ["tail", rules[1]],
    ["contact", [`error × ${magnified}`, `误差，放大 ${magnified} 倍`]],
  ]);
  lab.update = () => {
    if (time.value < last) return;
    const steps = tried.get(name()) ?? new Set();
    tried.set(name(), steps.add(step.value));
  };
  lab.pane(
    0.6,
    () => {
      const handles = now(exact);
      const [x, y] = handles[1];
      const [behindX, behindY] = handles[6];
      return { x: (x + behindX) / 2, y: (y + behindY) / 2, size: 12.5, wide: 15 };
    },
    (pane) => {
      const handles = now(exact);
      const apart = off();
      const colour = colours[order - 1];
      const own = handles.map(
        ([x, y], i) =>
          /** @type {Point} */ ([
            x + 1e-5 * magnified * apart[i][0],
            y + 1e-5 * magnified * apart[i][1],
          ]),
      );
      pane.benches(benchesBetween(dragon, handles), () => "curve", 0.7);
      pane.benches(benchesBetween(dragon, own), (i) => (i === 0 ? "head" : colour), 0.85);
      handles.forEach((handle, i) => pane.line([handle, own[i]], { colour: "contact", width: 3 }));
      const worst = farthest(apart);
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
      const apart = off();
      const size = millimetres(apart[farthest(apart)]);
      return [
        `Of these benches the worst is ${size} off now.`,
        `这几节板凳中误差最大的此刻偏离 ${size}。`,
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
