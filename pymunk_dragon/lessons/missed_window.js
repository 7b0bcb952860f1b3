// The step between samples and the width of the benches: which contact falls between two samples?
stages["missed-window"] = (lab) => {
  const begin = 405, end = 413; // s
  const step = lab.slider({
    label: { en: "a sample every", zh: "取样间隔" }, min: -9, max: 1, step: 1, value: 0, show: (n) => `${roundNumber(n)} s`,
  });
  const width = lab.slider({ label: { en: "width", zh: "板凳宽度" }, unit: "mm", min: 300, max: 301.5, step: 0.01, value: 301 });
  const zoom = lab.slider({ label: { en: "zoom", zh: "放大" }, min: 0, max: 1.6, step: 0.02, value: 0, show: (x) => `× ${(10 ** x).toFixed(0)}` });
  const spiral = new Spiral(0.55), start = spiral.atAngle(16 * ROUND);
  let time = 409.2, dragon, touching, length, benches, now;

  const benchesAt = (t, handles) => benchesBetween(dragon, chainAt(spiral, dragon, start + t, handles).points);
  const gapAt = (t) => closest(benchesAt(t, 14), 0, 2, 12);
  const gap = (t) => gapAt(t).gap;
  const points = (from, to, count) =>
    Array.from({ length: count + 1 }, (_, i) => from + (to - from) * i / count).map((t) => [t, 1000 * gap(t)]);

  lab.label = { en: "The head beside the bench that it passes; below, its gap over time, with samples as dots", zh: "龙头和它经过的板凳；下方是空隙随时间的变化，圆点是取样" };
  lab.update = () => {
    if (dragon?.widths[0] !== width.value / 1000) {
      dragon = makeDragon({ benches: 60, width: width.value / 1000 });
      // From when to when the head touches the benches that it passes, and from when on bench 8.
      touching = [[406, 408], [409, 411]].map(([from, to]) => minimumBetween(gap, from, to)).filter((t) => gap(t) <= 0)
        .map((t) => ({ bench: gapAt(t).bench, from: rootBetween(gap, t - 1, t), to: rootBetween(gap, t + 1, t) }));
      touching.push({ bench: 8, from: rootBetween(gap, 411, end), to: Infinity });
    }
    length = roundNumber(step.value);
    benches = benchesAt(time, 61);
    now = gapAt(time);
  };
  lab.pane(0.45, () => {
    const [[x, y]] = benches.gap(0, now.bench).ends, size = 5 / 10 ** (2 * zoom.value);
    return { x, y, width: size, height: size };
  }, (pane) => {
    pane.benches(benches, { colour: (i) => (i === 0 ? "head" : i === now.bench && now.gap <= 0 ? "contact" : "body") });
  });
  const chart = lab.pane(0.55, () => {
    const scale = 10 ** zoom.value, half = (end - begin) / 2 / scale;
    const middle = Math.min(Math.max(time, begin + half), end - half);
    return {
      across: [middle - half, middle + half], up: [-10 / scale ** 2, 30 / scale ** 2],
      name: { en: "gap of the head (mm) by the time (s), and samples", zh: "龙头的空隙 (mm) 随时间 (s) 的变化，以及取样" },
    };
  }, (pane) => {
    const { across: [from, to], up: [bottom] } = pane.view();
    pane.fill([[from, 0], [to, 0], [to, bottom], [from, bottom]], { colour: "contact", alpha: 0.15 });
    pane.line(points(from, to, 240), { colour: "body", width: 2 });
    const [first, last] = [Math.ceil(from / length), Math.floor(to / length)];
    if (last - first > 150) return;
    for (const dot of points(first * length, last * length, last - first)) pane.dot(dot, { colour: dot[1] > 0 ? "text" : "contact" });
  });
  lab.knob({
    pane: chart, step: 0.02, label: { en: "The time: drag it along the chart", zh: "时间：沿图表拖动" },
    at: () => [time, Math.min(Math.max(1000 * now.gap, chart.view().up[0]), chart.view().up[1])],
    moved: ([t]) => { time = Math.min(Math.max(t, begin), end); },
  });
  lab.readout = () => {
    const seen = ({ from, to }) => length * Math.ceil(from / length) <= to;
    const found = touching.find(seen), at = (length * Math.ceil(found.from / length)).toFixed(3);
    const [missed] = touching.slice(0, touching.indexOf(found)), long = missed && (missed.to - missed.from).toFixed(3);
    return {
      en: `The samples find the head in bench ${found.bench} at ${at} s. `
        + (missed ? `Missed: bench ${missed.bench}, touched for ${long} s.` : "No contact was missed."),
      zh: `取样发现龙头在 ${at} s 与 ${found.bench} 号板凳重叠。`
        + (missed ? `漏掉了与 ${missed.bench} 号板凳的接触，历时 ${long} s。` : "没有漏掉接触。"),
    };
  };
};
