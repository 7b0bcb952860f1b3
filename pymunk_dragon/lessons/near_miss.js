// Time, zoom, and decimals of the coordinates: does the head hit bench 11?
stages["near-miss"] = (lab) => {
  const time = lab.slider({
    label: { en: "time", zh: "时间" }, min: 405, max: 412.6, step: 0.01, value: 405, play: () => 0.5, show: (t) => `${t.toFixed(2)} s`,
  });
  const decimals = lab.slider({
    label: { en: "coordinates", zh: "坐标" }, min: 1, max: 6, step: 1, value: 6,
    show: (n) => (n === 6 ? lab.say({ en: "exact", zh: "精确" }) : lab.say({ en: `cut to ${10 ** (3 - n)} mm`, zh: `截到 ${10 ** (3 - n)} mm` })),
  });
  const span = lab.slider({ label: { en: "zoom", zh: "放大" }, min: 0, max: 3.2, step: 0.1, value: 0, show: (x) => `× ${(10 ** x).toFixed(0)}` });
  const spiral = new Spiral(0.55), begin = spiral.atAngle(16 * ROUND), dragon = makeDragon({ benches: 60 });
  const points = curvePoints(spiral, begin + 340, 0);
  const cut = (value) => (decimals.value === 6 ? value : Math.trunc(value * 10 ** decimals.value) / 10 ** decimals.value);
  const benchesAt = (t, handles = 14) =>
    benchesBetween(dragon, chainAt(spiral, dragon, begin + t, handles).points.map((point) => point.map(cut)));
  const gapAt = (t) => closest(benchesAt(t), 0, 2, 12);
  let gaps, gapsFor, benches, now, ends;

  lab.label = { en: "The head and the benches that it passes; below, its gap over time", zh: "龙头和它经过的板凳；下方是空隙随时间的变化" };
  lab.update = () => {
    if (gapsFor !== decimals.value) {
      gapsFor = decimals.value;
      gaps = Array.from({ length: 761 }, (_, i) => [405 + i / 100, 1000 * gapAt(405 + i / 100).gap]);
    }
    benches = benchesAt(time.value, 61);
    now = closest(benches, 0, 2, 12);
    ends = benches.gap(0, now.bench).ends;
  };
  lab.pane(0.6, () => {
    const size = 7 / 10 ** span.value;
    return { x: ends[0][0], y: ends[0][1], width: size, height: size };
  }, (pane) => {
    pane.line(points, { colour: "curve" });
    pane.benches(benches, { colour: (i) => (i === 0 ? "head" : i === now.bench && now.gap <= 0 ? "contact" : "body") });
    pane.line(ends, { colour: "contact", width: 2 });
  });
  const chart = lab.pane(0.4, () => ({
    across: [404.9, 412.7], up: [-8, 30], name: { en: "gap of the head (mm) by the time (s)", zh: "龙头的空隙 (mm) 随时间 (s) 的变化" },
  }), (pane) => {
    pane.fill([[404.9, 0], [412.7, 0], [412.7, -8], [404.9, -8]], { colour: "contact", alpha: 0.15 });
    pane.line(gaps, { colour: "body", width: 2 });
    for (const hit of gaps.filter(([, gap]) => gap <= 0)) pane.dot(hit, { colour: "contact", radius: 3 });
  });
  lab.knob({
    pane: chart, step: 0.01, label: { en: "The time: drag it along the chart", zh: "时间：沿图表拖动" },
    at: () => [time.value, Math.min(Math.max(1000 * now.gap, -8), 30)],
    moved: ([t]) => { time.value = t; },
  });
  lab.readout = () => {
    const size = Math.abs(1000 * now.gap).toFixed(3), t = time.value.toFixed(2), { bench } = now;
    const first = gaps.find(([, gap]) => gap <= 0)[0].toFixed(2);
    return {
      en: (now.gap > 0 ? `${t} s: the gap to bench ${bench} is ${size} mm. ` : `${t} s: the head overlaps bench ${bench} by ${size} mm. `)
        + `First overlap on the chart: ${first} s.`,
      zh: (now.gap > 0 ? `${t} s：与 ${bench} 号板凳的空隙为 ${size} mm。` : `${t} s：龙头与 ${bench} 号板凳重叠 ${size} mm。`)
        + `图上第一次重叠：${first} s。`,
    };
  };
};
