// The way through the turn, and the speed of the head: who reaches the limit?
stages["speed-limit"] = (lab) => {
  const limit = 2; // m/s
  const from = -1; // m
  const until = 24; // m
  const followed = 12; // handles of the chart: no later one is faster
  const way = lab.slider(["way of the head", "龙头的路程"], {
    min: from,
    max: until,
    step: 0.01,
    value: 0,
    unit: "m",
    digits: 2,
    play: () => speed.value,
  });
  /** @type {(v: number) => string} */
  const show = (v) => `${v.toFixed(3)} m/s`;
  const speed = lab.slider(["speed of the head", "龙头速度"], {
    min: 1,
    max: 2,
    step: 0.001,
    value: 2,
    show,
  });
  const ratio = lab.slider(["ratio of the radii", "半径之比"], {
    min: 0.5,
    max: 2.1,
    step: 0.1,
    value: 2,
  });
  const dragon = makeDragon();
  /** @type {number} */
  let shown;
  /** @type {UTurn} */
  let curve;
  /** @type {Point[]} */
  let points;
  /** @type {Point[]} */
  let profile;
  /** @type {number} */
  let peak;
  /** @type {number} */
  let most;
  /** @type {Chain} */
  let chain;
  /** @type {number[]} */
  let speeds;
  /** @type {number} */
  let fastest;
  let seen = from;

  /** @type {(s: number) => number} */
  const largest = (s) => Math.max(...chainAt(curve, dragon, s, followed).ratios.map(Math.abs));
  lab.label = [
    "The dragon, red where it is too fast; below, the speed of the fastest handle",
    "板凳龙，红色处超速；下方是最快的把手的速度",
  ];
  lab.update = () => {
    if (shown !== ratio.value) {
      shown = ratio.value;
      curve = new UTurn({ ratio: shown });
      points = curvePoints(curve, -60, 74);
      profile = range(from, until, 500).map((s) => [s, largest(s)]);
      [peak] = smallestOf(profile, ([, times]) => -times);
      most = largest(minimumBetween((s) => -largest(s), peak - 0.05, peak + 0.05));
    }
    seen = Math.max(seen, way.value);
    chain = chainAt(curve, dragon, way.value);
    speeds = chain.ratios.map((each) => speed.value * Math.abs(each));
    fastest = speeds.findIndex((each) => each > Math.max(...speeds) - 1e-9);
  };
  lab.pane(
    0.6,
    () => ({ x: 0, y: 0, size: 12 }),
    (pane) => {
      pane.line(points, { colour: "curve" });
      pane.benches(benchesBetween(dragon, chain.points), (i) => {
        const share = Math.max(speeds[i], speeds[i + 1]) / limit;
        return share > 1 + 1e-9 ? "contact" : lab.mixed("body", "head", 2 * share - 1);
      });
      pane.text(chain.points[fastest], show(speeds[fastest]), { dy: -16 });
    },
  );
  const chart = lab.pane(
    0.4,
    () => ({
      across: [from, until],
      up: [0.8, 3.4],
      name: [
        "fastest handle (m/s) by the head's way (m)",
        "最快的把手 (m/s) 随龙头路程 (m) 的变化",
      ],
    }),
    (pane) => {
      pane.line(
        [
          [from, limit],
          [until, limit],
        ],
        { colour: "contact", width: 2, dash: [6, 4] },
      );
      pane.line(
        profile.map(([s, times]) => [s, s > seen ? NaN : times * speed.value]),
        { colour: "body", width: 2 },
      );
    },
  );
  lab.knob(["The head's way: drag it along the chart", "龙头的路程：沿图表拖动"], {
    pane: chart,
    step: 0.1,
    at: () => [way.value, speeds[fastest]],
    moved: ([s]) => {
      way.value = s;
    },
  });
  lab.readout = () => {
    const now = show(speeds[fastest]);
    const top = seen < peak ? "–" : show(most * speed.value);
    const times = (speeds[fastest] / speed.value).toFixed(3);
    return [
      `The fastest now: handle ${fastest}, ${now}, ${times} times the head's speed. ` +
        `In the whole turn: ${top}.`,
      `此刻最快的是 ${fastest} 号把手：${now}，是龙头的 ${times} 倍。整个调头过程中最快：${top}。`,
    ];
  };
};
