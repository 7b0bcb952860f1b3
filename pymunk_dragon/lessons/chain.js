// Drag the next handle round handle 0, on the circle of a bench:
// where on the spiral does it belong?
stages.chain = (lab) => {
  const snap = 0.05; // m: a handle so close to a point of the spiral is put on it
  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: 420,
    step: 1,
    value: 300,
    unit: "s",
    play: () => 10,
  });
  const bench = lab.slider(["handle to handle", "把手间距"], {
    min: 1,
    max: 2.86,
    step: 0.01,
    value: 2.86,
    unit: "m",
  });
  const { spiral, begin } = new March();
  const points = curvePoints(spiral, begin - 200, 0);
  /** @type {Set<number>} */
  const found = new Set();
  let angle = 0.5;
  /** @type {number} */
  let head;
  /** @type {Frame} */
  let from;
  /** @type {number} */
  let right;
  /** @type {number[]} */
  let met;
  /** @type {number} */
  let own;
  /** @type {boolean} */
  let correct;

  /** @type {() => Point} */
  const next = () => [
    from[0] + bench.value * Math.cos(angle),
    from[1] + bench.value * Math.sin(angle),
  ];
  /** @type {(one: Numbers, two: Numbers) => number} */
  const apart = ([x, y], [otherX, otherY]) => Math.hypot(x - otherX, y - otherY);
  /** @type {(point: Numbers) => number} */
  const angleTo = ([x, y]) => Math.atan2(y - from[1], x - from[0]);
  const onSpiral = () => met.find((s) => apart(spiral.frame(s), next()) < snap);
  // Coordinates, from the outside in, at which the distance from handle 0 passes the bench.
  const meetings = () => {
    /** @type {(s: number) => number} */
    const excess = (s) => apart(spiral.frame(s), from) - bench.value;
    /** @type {number[]} */
    const roots = [];
    const theta = spiral.angle(head);
    for (
      let s = spiral.atAngle(theta + bench.value / spiral.k + 1), last = excess(s);
      s < 0;
      s += snap
    ) {
      const here = excess(s + snap);
      if (last * here < 0) {
        roots.push(rootBetween((at) => excess(at) * Math.sign(last), s, s + snap));
      }
      last = here;
    }
    return roots;
  };

  lab.label = [
    "Handle 0 on the spiral, the circle about it, and the next handle",
    "螺线上的 0 号把手，以它为圆心的圆，和下一个把手",
  ];
  lab.update = () => {
    head = begin + time.value;
    from = spiral.frame(head);
    right = neighbour(spiral, head, bench.value);
    met = meetings();
    own = onSpiral() ?? NaN;
    correct = Math.abs(own - right) < 1e-6;
  };
  lab.pane(
    1,
    () => ({ x: from[0], y: from[1], size: 2.4 * bench.value }),
    (pane) => {
      pane.line(points, { colour: "curve", width: 1.5 });
      pane.line(circlePoints(from, bench.value), { colour: "quiet", dash: [4, 4] });
      const ahead = curvePoints(spiral, head, head + 0.5);
      pane.line(ahead, { width: 3 });
      pane.benches(benchesBetween(makeDragon({ benches: 1, head: bench.value }), [from, next()]));
      const way = own ? curvePoints(spiral, Math.min(own, head), Math.max(own, head), 0.03) : [];
      pane.line(way, { colour: correct ? "tail" : "contact", width: 4 });
      for (const s of met.filter((each) => found.has(each))) {
        pane.dot(spiral.frame(s), { colour: "quiet" });
      }
      pane.dot(from, { radius: 6 });
      // Beyond the end of the way, which it does not cover.
      const end = lastOf(ahead);
      const below = end[1] < from[1];
      pane.text(end, lab.say(["handle 0, and its way ahead", "0 号把手及其前方的路"]), {
        dy: below ? 14 : -14,
      });
    },
  );
  // Turn the handle to an angle; points of the spiral on the way there are found.
  /** @type {(to: number) => void} */
  const turn = (to) => {
    /** @type {(end: number) => number} */
    const turned = (end) => Math.atan2(Math.sin(end - before), Math.cos(end - before));
    const before = angle;
    angle = to;
    const snapped = onSpiral();
    if (snapped) angle = angleTo(spiral.frame(snapped));
    // The points between the angle before and that now.
    /** @type {(s: number) => number} */
    const share = (s) => turned(angleTo(spiral.frame(s))) / turned(angle);
    for (const s of met) if (share(s) >= 0 && share(s) < 1 + 1e-9) found.add(s);
  };
  lab.keep("angle", () => angle, turn);
  lab.knob(["The next handle: drag it round the circle", "下一个把手：沿圆周拖动"], {
    at: next,
    moved: (point, way) => turn(way ? angle + ((3 * snap) / bench.value) * way : angleTo(point)),
  });
  lab.readout = () => {
    const off = apart(spiral.frame(right), next()).toFixed(2);
    const along = Math.abs(head - own).toFixed(correct ? 3 : 1);
    const [english, chinese] = !own
      ? [`Yours is not on the spiral, ${off} m off.`, `你的把手不在螺线上，差 ${off} m。`]
      : own > head
        ? [`Yours is ${along} m ahead along the path.`, `你的把手在前方，沿路径 ${along} m。`]
        : [
            `Yours is ${along} m back along the path, ${off} m off.`,
            `你的把手沿路径往回 ${along} m，差 ${off} m。`,
          ];
    const n = met.filter((each) => found.has(each)).length;
    return [
      `Points of the spiral found on the circle: ${n}. ${english}`,
      `圆上已找到 ${n} 个交点。${chinese}`,
    ];
  };
};
