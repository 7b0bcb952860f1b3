// Draw a path, or drag its points: does the arm follow its tip to the end?
stages.robot = (lab) => {
  const speed = 0.2, clear = 1e-9, apart = 0.13, most = 40, sample = 0.02; // m/s, m: tail's begin; drawn points, at most so many; samples
  const arm = makeDragon({
    benches: 16, head: 0.14, overhang: 0.02,
    body: [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.13, 0.13, 0.13, 0.13, 0.13, 0.16, 0.16, 0.16, 0.16],
    width: [0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.06, 0.06, 0.06, 0.06, 0.06, 0.07, 0.07, 0.07, 0.07],
  });
  let points = [
    [-1.9, 0], [-1.6, 0], [-1.3, 0], [-1, 0], [-0.75, 0.08], [-0.5, 0.25], [-0.25, 0.3], [-0.03, 0.15],
    [0.1, -0.1], [0.32, -0.25], [0.55, -0.15], [0.6, 0.1], [0.42, 0.28], [0.2, 0.22], [0.05, 0.05], [-0.1, -0.1],
  ];
  let path, line, begin, end, hit, speeds, changed = true, drawn = null;
  const time = lab.slider({ label: { en: "time", zh: "时间" }, min: 0, max: 10, step: 0.001, value: 0, play: () => 1, show: (t) => `${t.toFixed(2)} s` });

  const armAt = (s) => benchesBetween(arm, chainAt(path, arm, s).points);
  const whole = (s) => chainAt(path, arm, s).points.length === arm.benches + 1;
  // The smallest gap between two links; none is left where the path is too narrow for one of them.
  const nearest = (s) => {
    const links = armAt(s), found = { gap: Infinity };
    for (let i = 0; i < arm.benches - 2; i++) {
      const { bench, gap } = closest(links, i, i + 2, arm.benches - 1, found.gap);
      if (bench !== null) Object.assign(found, { gap, links: [i, bench] });
    }
    return found;
  };
  const gap = (s) => (whole(s) ? nearest(s).gap : -1);
  const follow = () => {
    path = new DrawnPath(points);
    line = curvePoints(path, 0, path.end, 0.01);
    // All of the arm lies on the path at the start: from its base on, each joint is the next one ahead.
    begin = [...arm.spacings].reverse().reduce((s, spacing) => neighbour(path, s, spacing, 1), clear);
    if (Number.isNaN(begin)) return;
    const { root } = firstContact(gap, begin, path.end, sample, 0.01);
    end = root ?? path.end;
    hit = root === null ? null : whole(root) ? nearest(root).links : [];
    speeds = Array.from({ length: Math.floor((end - begin) / sample) + 1 }, (_, i) =>
      chainAt(path, arm, begin + i * sample).ratios.map((each) => speed * Math.abs(each)));
    time.limit(0, Math.ceil(1000 * (end - begin) / speed) / 1000);
  };

  lab.label = { en: "The arm on a path, which you draw", zh: "机械臂和由你画出的路径" };
  lab.update = () => {
    if (changed) follow();
    changed = false;
  };
  const ground = lab.pane(1, () => ({ x: -0.55, y: 0, width: 3.1, height: 1.9 }), (pane) => {
    pane.text([-0.55, -0.85], lab.say({ en: "draw a new path here", zh: "在这里画一条新路径" }), { colour: "quiet" });
    pane.line(drawn ?? line, { colour: "curve", width: 2 });
    if (drawn || Number.isNaN(begin)) return;
    const s = Math.min(begin + speed * time.value, end), touching = s === end && hit ? hit : [];
    const part = (i) => (touching.includes(i) ? "contact" : i === 0 ? "head" : "body");
    const links = armAt(s);
    pane.benches(links, { colour: part });
    for (const joint of links.handles) pane.dot(joint, { radius: 2.5 });
  });
  lab.pen(ground, {
    began: (point) => { drawn = [point]; },
    moved: (point) => drawn.push(point),
    ended: () => {
      const length = drawn.slice(1).reduce((sum, [x, y], i) => sum + Math.hypot(x - drawn[i][0], y - drawn[i][1]), 0);
      const step = Math.max(apart, 1.2 * length / most), kept = [drawn[0]];
      for (const point of drawn) {
        const [x, y] = kept.at(-1);
        if (Math.hypot(point[0] - x, point[1] - y) >= step) kept.push(point);
      }
      if (kept.length >= 4) [points, changed] = [kept, true];
      drawn = null;
      time.value = 0;
    },
  });
  for (let i = 0; i < most; i++) {
    lab.knob({
      small: true, step: 0.02, label: { en: `Point ${i + 1} of the path: drag it`, zh: `路径的第 ${i + 1} 个点：拖动` },
      at: () => points[i] ?? [NaN, NaN],
      moved: (point) => {
        points[i] = point;
        changed = true;
      },
    });
  }
  lab.readout = () => {
    if (Number.isNaN(begin)) {
      return {
        en: "The arm does not fit on this path: it is too short or too narrow.", zh: "这条路径放不下机械臂：太短，或者弯得太急。",
      };
    }
    const soFar = speeds.slice(0, Math.floor(speed * time.value / sample + 1e-6) + 1).flat();
    const [low, high] = [Math.min(...soFar), Math.max(...soFar)].map((each) => each.toFixed(3));
    const joints = {
      en: `The tip goes at 0.200 m/s, the joints until now at ${low} to ${high} m/s. `, zh: `臂端 0.200 m/s，各关节至今 ${low} 到 ${high} m/s。`,
    };
    const at = ((end - begin) / speed).toFixed(3), arrived = begin + speed * time.value >= end;
    const [en, zh] = !arrived ? ["", ""]
      : hit === null ? [`The tip reaches the end after ${at} s.`, `${at} s 后臂端到达终点。`]
      : hit.length ? [`Link ${hit[0]} runs into link ${hit[1]} at ${at} s.`, `${at} s 时 ${hit[0]} 号连杆碰到 ${hit[1]} 号。`]
      : [`At ${at} s a link does not get round a narrow bend.`, `${at} s 时有一节连杆转不过急弯。`];
    return { en: joints.en + en, zh: joints.zh + zh };
  };
};
