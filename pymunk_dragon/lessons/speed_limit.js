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
  /** @type {number} */
  let peak; // m: way of the head where a handle is fastest in the whole turn
  /** @type {Chain} */
  let atPeak;
  /** @type {Chain} */
  let chain;
  /** @type {number[]} */
  let speeds;
  /** @type {number} */
  let fastest;
  let seen = from;

  /** @type {(s: number) => Chain} */
  const first = (s) => chainAt(curve, dragon, s, followed);
  /** @type {(ratios: number[]) => number} */
  const largestOf = (ratios) => {
    const sizes = ratios.map(Math.abs);
    return sizes.findIndex((each) => each > Math.max(...sizes) - 1e-9);
  };
  /** @type {(s: number) => number} */
  const slowness = (s) => -Math.max(...first(s).ratios.map(Math.abs));
  lab.label = ["The dragon in the turn, the faster the redder", "调头中的板凳龙，越快越红"];
  lab.legend([
    ["body", ["1 m/s", "1 m/s"]],
    ["head", ["2 m/s, the limit", "2 m/s，限速"]],
    ["contact", ["3.2 m/s", "3.2 m/s"]],
  ]);
  lab.update = () => {
    if (shown !== ratio.value) {
      shown = ratio.value;
      curve = new UTurn({ ratio: shown });
      points = curvePoints(curve, -60, 74);
      const near = smallestOf(range(from, until, 500), slowness);
      peak = minimumBetween(slowness, near - 0.05, near + 0.05);
      atPeak = first(peak);
    }
    seen = Math.max(seen, way.value);
    chain = chainAt(curve, dragon, way.value);
    speeds = chain.ratios.map((each) => speed.value * Math.abs(each));
    fastest = largestOf(speeds);
  };
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 12 }),
    (pane) => {
      pane.line(points, { colour: "curve" });
      pane.benches(benchesBetween(dragon, chain.points), (i) => {
        const ends = [speeds[i], speeds[i + 1]];
        const share = (ends[0] + ends[1]) / 2 / limit;
        // A clear step at the limit, and red at 1.6 times it.
        return Math.max(...ends) > limit + 1e-9
          ? lab.mixed("head", "contact", 0.4 + (share - 1))
          : lab.mixed("body", "head", 2 * share - 1);
      });
      if (seen >= peak) {
        const place = atPeak.points[largestOf(atPeak.ratios)];
        pane.dot(place, { colour: "ink", radius: 5 });
        pane.text(place, lab.say(["fastest here", "此处最快"]), { dy: 18 });
      }
      pane.text(chain.points[fastest], show(speeds[fastest]), { dy: fastest ? -16 : -26 });
    },
  );
  lab.knob(["The head: drag it along its way", "龙头：沿路线拖动"], {
    at: () => chain.points[0],
    moved: (point, key) => {
      way.value = key ? way.value + key / 10 : nearestOn(curve, point, from, until);
    },
  });
  lab.readout = () => {
    const now = show(speeds[fastest]);
    const times = (speeds[fastest] / speed.value).toFixed(3);
    const most = largestOf(atPeak.ratios);
    const top = show(Math.abs(atPeak.ratios[most]) * speed.value);
    const [english, chinese] =
      seen < peak
        ? ["", ""]
        : [
            ` In the whole turn: ${top}, handle ${most}.`,
            `整个调头过程中最快：${top}，${most} 号把手。`,
          ];
    return [
      `The fastest now: handle ${fastest}, ${now}, ${times} times the head's speed.${english}`,
      `此刻最快的是 ${fastest} 号把手：${now}，是龙头的 ${times} 倍。${chinese}`,
    ];
  };
};
