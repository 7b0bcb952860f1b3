// The step between samples and the width of the benches: which contact falls between two samples?
stages["missed-window"] = (lab) => {
  const [begin, end] = [405, 413]; // s
  const step = lab.slider(["a sample every", "取样间隔"], { min: -9, max: 1, step: 1, value: 0, show: (n) => `${roundNumber(n)} s` });
  const width = lab.slider(["width", "板凳宽度"], { min: 300, max: 301.5, step: 0.01, value: 301, unit: "mm" });
  const zoom = lab.slider(["zoom", "放大"], { min: 0, max: 1.6, step: 0.02, value: 0, show: (x) => `× ${(10 ** x).toFixed(0)}` });
  const spiral = new Spiral(0.55), start = spiral.atAngle(16 * ROUND);
  let time = 409.2, dragon, touching, length, benches, now;

  const benchesAt = (t, handles) => benchesBetween(dragon, chainAt(spiral, dragon, start + t, handles).points);
  const gapAt = (t) => closest(benchesAt(t, 14), 0, 2, 12);
  const gap = (t) => gapAt(t).gap;
  const points = (...times) => range(...times).map((t) => [t, 1000 * gap(t)]);

  lab.label = [
    "The head beside the bench that it passes; below, its gap over time, with samples as dots",
    "龙头和它经过的板凳；下方是空隙随时间的变化，圆点是取样",
  ];
  lab.update = () => {
    if (dragon?.widths[0] !== width.value / 1000) {
      dragon = makeDragon({ benches: 60, width: width.value / 1000 });
      // From when to when the head touches the benches that it passes, and from when on bench 8.
      const passes = [406, 409].map((t) => minimumBetween(gap, t, t + 2)).filter((t) => gap(t) <= 0);
      touching = passes.map((t) => ({ from: rootBetween(gap, t - 1, t), to: rootBetween(gap, t + 1, t), bench: gapAt(t).bench }));
      touching.push({ from: rootBetween(gap, 411, end), to: Infinity, bench: 8 });
    }
    length = roundNumber(step.value);
    benches = benchesAt(time, dragon.benches + 1);
    now = gapAt(time);
  };
  lab.pane(0.45, () => {
    const [[x, y]] = benches.gap(0, now.bench).ends, size = 5 / 10 ** (2 * zoom.value);
    return { x, y, width: size, height: size };
  }, (pane) => {
    pane.benches(benches, (i) => (i === 0 ? "head" : i === now.bench && now.gap <= 0 ? "contact" : "body"));
  });
  const chart = lab.pane(0.55, () => {
    const scale = 10 ** zoom.value, half = (end - begin) / 2 / scale, middle = bounded(time, begin + half, end - half);
    return {
      across: [middle - half, middle + half], up: [-10 / scale ** 2, 30 / scale ** 2],
      name: ["gap of the head (mm) by the time (s), and samples", "龙头的空隙 (mm) 随时间 (s) 的变化，以及取样"],
    };
  }, (pane) => {
    const { across: [from, to], up: [bottom] } = pane.view();
    pane.fill([[from, 0], [to, 0], [to, bottom], [from, bottom]], { colour: "contact", alpha: 0.15 });
    pane.line(points(from, to, 120), { colour: "body", width: 2 });
    const [first, last] = [Math.ceil(from / length), Math.floor(to / length)], count = last - first;
    const samples = count >= 0 && count < 100 ? points(first * length, last * length, count) : [];
    for (const sample of samples) pane.dot(sample, { colour: sample[1] > 0 ? "text" : "contact" });
  });
  lab.knob(["The time: drag it along the chart", "时间：沿图表拖动"], {
    pane: chart, step: 0.02,
    at: () => [time, bounded(1000 * now.gap, ...chart.view().up)],
    moved: ([t]) => { time = bounded(t, begin, end); },
  });
  lab.readout = () => {
    const sampled = ({ from }) => length * Math.ceil(from / length), found = touching.find((each) => sampled(each) <= each.to);
    const [missed] = touching.slice(0, touching.indexOf(found)), long = missed && (missed.to - missed.from).toFixed(3);
    const [english, chinese] = missed ? [`Missed: bench ${missed.bench}, touched for ${long} s.`, `漏掉了与 ${missed.bench} 号板凳的接触，历时 ${long} s。`]
      : ["No contact was missed.", "没有漏掉接触。"];
    const t = sampled(found).toFixed(3);
    return [
      `The samples find the head in bench ${found.bench} at ${t} s. ${english}`,
      `取样发现龙头在 ${t} s 与 ${found.bench} 号板凳重叠。${chinese}`,
    ];
  };
};
