// Draw a path, or drag its points: does the arm follow its tip to the end?
stages.robot = (lab) => {
  const speed = 0.2; // m/s
  const clear = 1e-9; // m from the path's begin to the base
  const apart = 0.13; // m between drawn points
  const most = 50; // drawn points that are kept
  const fewest = 4; // points of a path
  const before = 0.3; // m between the points before those
  const arm = makeDragon({
    benches: 16,
    head: 0.14,
    overhang: 0.02,
    body: [...Array(6).fill(0.1), ...Array(5).fill(0.13), ...Array(4).fill(0.16)],
    width: [...Array(7).fill(0.05), ...Array(5).fill(0.06), ...Array(4).fill(0.07)],
  });
  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: 10,
    step: 0.001,
    value: 0,
    unit: "s",
    digits: 2,
    play: () => 1,
  });
  /** @type {Point[]} */
  let points = [
    [-1.9, 0],
    [-1.6, 0],
    [-1.3, 0],
    [-1, 0],
    [-0.75, 0.08],
    [-0.5, 0.25],
    [-0.25, 0.3],
    [-0.03, 0.15],
    [0.1, -0.1],
    [0.32, -0.25],
    [0.55, -0.15],
    [0.6, 0.1],
    [0.42, 0.28],
    [0.2, 0.22],
    [0.05, 0.05],
    [-0.1, -0.1],
  ];
  // Before a path that was drawn the arm lies on a straight line and comes in along it. The first
  // path has such a line itself.
  let comesIn = false;
  const reach = arm.spacings.reduce((sum, spacing) => sum + spacing, 0);
  const lead = () => {
    const [[x, y], [nextX, nextY]] = points;
    const away = Math.hypot(nextX - x, nextY - y);
    const count = comesIn ? Math.ceil(reach / before) : 0;
    return Array.from({ length: count }, (_, i) => {
      const back = ((count - i) * before) / away;
      return /** @type {Point} */ ([x - back * (nextX - x), y - back * (nextY - y)]);
    });
  };
  /** @type {DrawnPath} */
  let path;
  let stale = true; // the points have changed since the path was made
  /** @type {number} */
  let begin;
  /** @type {number | null} */
  let stop;
  /** @type {number[]} */
  let hit;
  /** @type {number} */
  let total;
  /** @type {Point[] | null} */
  let drawn;
  /** @type {Chain} */
  let chain;
  let tooShort = false;
  // The smallest and the largest speed of a joint since the path was made, m/s.
  let slowest = Infinity;
  let fastest = 0;

  // The arm with its tip at a coordinate: the smallest gap between two links, and which. It is -1
  // where a joint has no place on the path, or would go back.
  /** @type {(s: number) => { gap: number, links: number[] }} */
  const closest = (s) => {
    const { points: joints, ratios } = chainAt(path, arm, s);
    if (ratios.length <= arm.benches || !ratios.every((ratio) => ratio > 0)) {
      return { gap: -1, links: [] };
    }
    const links = benchesBetween(arm, joints);
    /** @type {NearestBench | null} */
    let nearest = null;
    let other = 0;
    for (let i = 2; i < arm.benches; i++) {
      const nearer = links.nearest(i, nearest, i - 1);
      if (nearer !== nearest) other = i;
      nearest = nearer;
    }
    const { gap, bench } = /** @type {NearestBench} */ (nearest);
    return { gap, links: [bench, other] };
  };
  const follow = () => {
    path = new DrawnPath([...lead(), ...points]);
    stale = false;
    slowest = Infinity;
    fastest = 0;
    // All of the arm is on the path at the start: each
    // joint is the next one ahead of that behind it.
    begin = arm.spacings.reduceRight((s, spacing) => neighbour(path, s, spacing, 1), clear);
    if (Number.isNaN(begin)) return;
    stop = firstContact((s) => closest(s).gap, begin, path.end, 0.02, 0.01);
    hit = stop === null ? [] : closest(stop).links;
    total = (path.length(stop ?? path.end) - path.length(begin)) / speed;
    time.max = Math.ceil(1000 * total) / 1000;
  };

  lab.label = ["The arm on a path, which you draw", "机械臂和由你画出的路线"];
  lab.update = () => {
    if (stale) follow();
    if (Number.isNaN(begin)) return;
    chain = chainAt(
      path,
      arm,
      path.atLength(path.length(begin) + speed * Math.min(time.value, total)) - clear,
    );
    const speeds = chain.ratios.map((each) => speed * Math.abs(each));
    slowest = Math.min(slowest, ...speeds);
    fastest = Math.max(fastest, ...speeds);
  };
  const ground = lab.pane(
    1,
    () => ({ x: -0.6, y: 0, size: 1.9, wide: 2.9 }),
    (pane) => {
      const words = lab.say(["draw a new path here", "在这里画一条新路线"]);
      if (!comesIn) pane.text([-0.6, -0.85], words, { colour: "quiet" });
      pane.line(drawn ?? curvePoints(path, 0, path.end, 0.01), { colour: "curve", width: 2 });
      if (drawn || Number.isNaN(begin)) return;
      /** @type {(i: number) => string} */
      const colour = (i) =>
        time.value >= total && hit.includes(i) ? "contact" : i === 0 ? "head" : "body";
      pane.benches(benchesBetween(arm, chain.points), colour);
      for (const joint of chain.points) pane.dot(joint, { radius: 2.5 });
    },
  );
  lab.pen(ground, (line, ended) => {
    drawn = ended ? null : line;
    const kept = line.slice(0, 1);
    for (const [x, y] of line) {
      const [lastX, lastY] = lastOf(kept);
      if (Math.hypot(x - lastX, y - lastY) >= apart) kept.push([x, y]);
    }
    tooShort = ended && kept.length < fewest;
    if (!ended || tooShort) return;
    points = kept.slice(0, most);
    comesIn = true;
    stale = true;
    time.value = 0;
  });
  for (let i = 0; i < most; i++) {
    lab.knob([`Point ${i + 1} of the path: drag it`, `路线的第 ${i + 1} 个点：拖动`], {
      small: true,
      step: 0.02,
      at: () => points[i] ?? [NaN, NaN],
      moved: (point) => {
        points[i] = point;
        stale = true;
        tooShort = false;
      },
    });
  }
  lab.keep(
    "path",
    () => points,
    (given) => {
      if (given.length >= fewest) points = given.slice(0, most);
      stale = true;
    },
  );
  lab.keep(
    "drawn",
    () => Number(comesIn),
    (given) => {
      comesIn = given === 1;
      stale = true;
    },
  );
  lab.legend([
    ["head", ["tip", "末端"]],
    ["body", ["arm", "机械臂"]],
    ["contact", ["links that touch", "相碰的连杆"]],
  ]);
  lab.readout = () => {
    if (tooShort) {
      return ["The line that you drew is too short for a path.", "画出的线太短，不能作为路线。"];
    }
    if (Number.isNaN(begin)) {
      return ["The arm does not fit on this path.", "这条路线放不下机械臂。"];
    }
    const at = total.toFixed(3);
    const low = slowest.toFixed(3);
    const high = fastest.toFixed(3);
    const [english, chinese] =
      time.value < total
        ? ["", ""]
        : stop === null
          ? [`The tip reaches the end after ${at} s.`, `${at} s 后末端到达终点。`]
          : hit.length
            ? [
                `Link ${hit[0]} runs into link ${hit[1]} at ${at} s.`,
                `${at} s 时 ${hit[0]} 号连杆碰到 ${hit[1]} 号。`,
              ]
            : [
                `At ${at} s a bend is too narrow for a link.`,
                `${at} s 时弯太急，有一节连杆转不过去。`,
              ];
    return [
      `The tip goes at 0.200 m/s, the joints so far at ${low} to ${high} m/s. ${english}`,
      `末端 0.200 m/s，至此各关节 ${low} 到 ${high} m/s。${chinese}`,
    ];
  };
};
