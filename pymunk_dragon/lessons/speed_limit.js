// The way through the turn, and the speed of the head: who reaches the limit?
stages["speed-limit"] = (lab) => {
  const limit = 2, followed = 12, from = -1, until = 24; // m/s; handles of the chart, of which no later one is faster; m
  const way = lab.slider({ label: { en: "way of the head", zh: "龙头的路程" }, min: from, max: until, step: 0.01, value: 0,
    play: () => speed.value, show: (s) => `${s.toFixed(2)} m` });
  const speed = lab.slider({ label: { en: "speed of the head", zh: "龙头速度" }, min: 1, max: 2, step: 0.001, value: 2, show: (v) => `${v.toFixed(3)} m/s` });
  const ratio = lab.slider({ label: { en: "ratio of the radii", zh: "半径之比" }, min: 0.5, max: 2.1, step: 0.1, value: 2 });
  const dragon = makeDragon();
  let curve, shown, points, profile, most, chain, speeds, fastest;

  const largest = (s) => Math.max(...chainAt(curve, dragon, s, followed).ratios.map(Math.abs));
  lab.label = { en: "Above: the dragon in the turn, red where it is too fast. Below: the largest speed of all handles", zh: "上：调头中的板凳龙，红色处超速。下：所有把手中最大的速度" };
  lab.update = () => {
    if (shown !== ratio.value) {
      [shown, curve] = [ratio.value, new UTurn({ ratio: ratio.value })];
      points = curvePoints(curve, -60, 74);
      profile = Array.from({ length: 501 }, (_, i) => from + (until - from) * i / 500).map((s) => [s, largest(s)]);
      const [top] = profile.reduce((one, other) => (other[1] > one[1] ? other : one));
      most = largest(minimumBetween((s) => -largest(s), top - 0.05, top + 0.05));
    }
    chain = chainAt(curve, dragon, way.value);
    speeds = chain.ratios.map((each) => speed.value * Math.abs(each));
    fastest = speeds.findIndex((each) => each > Math.max(...speeds) - 1e-9);
  };
  lab.pane(0.6, () => ({ x: 0, y: 0, width: 12, height: 12 }), (pane) => {
    pane.line(points, { colour: "curve" });
    const share = (i) => Math.max(speeds[i], speeds[i + 1]) / limit;
    const colour = (i) => (share(i) > 1 + 1e-9 ? "contact" : lab.mixed("body", "head", 2 * share(i) - 1));
    pane.benches(benchesBetween(dragon, chain.points), { colour });
    pane.text(chain.points[fastest], `${speeds[fastest].toFixed(2)} m/s`, { dy: -16 });
  });
  const chart = lab.pane(0.4, () => ({
    across: [from, until], up: [0.8, 3.4], name: { en: "fastest handle (m/s) by the head's way (m)", zh: "最快的把手 (m/s) 随龙头的路程 (m) 的变化" },
  }), (pane) => {
    pane.line([[from, limit], [until, limit]], { colour: "contact", width: 2, dash: [6, 4] });
    pane.line(profile.map(([s, share]) => [s, share * speed.value]), { colour: "body", width: 2 });
  });
  lab.knob({
    pane: chart, step: 0.1, label: { en: "The head's way: drag it along the chart", zh: "龙头的路程：沿图表拖动" },
    at: () => [way.value, speeds[fastest]],
    moved: ([s]) => { way.value = s; },
  });
  lab.readout = () => {
    const [now, times, top] = [speeds[fastest], speeds[fastest] / speed.value, most * speed.value].map((each) => each.toFixed(3));
    return {
      en: `The fastest now: handle ${fastest}, ${now} m/s, ${times} times the head's speed. In the whole turn: ${top} m/s.`,
      zh: `此刻最快的是 ${fastest} 号把手：${now} m/s，是龙头的 ${times} 倍。整个调头过程中最快：${top} m/s。`,
    };
  };
};
