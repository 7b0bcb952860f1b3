// Drag the time step: how wrong is a speed from two positions, and how fast is the tail?
stages.velocity = (lab) => {
  const time = lab.slider({ label: { en: "time", zh: "时间" }, unit: "s", min: 0, max: 412, step: 1, value: 300, play: () => 10 });
  const step = lab.slider({
    label: { en: "time step", zh: "时间步长" }, min: -10, max: 0, step: 0.1, value: 0, show: (x) => `${(10 ** x).toExponential(1)} s`,
  });
  const dragon = makeDragon(), spiral = new Spiral(0.55), begin = spiral.atAngle(16 * ROUND);
  const points = curvePoints(spiral, begin - 370, 0);
  let now, later, speeds, error, tried, triedAt;

  lab.label = {
    en: "Above: the dragon, the slower the darker. Below: the error of the speeds by the time step",
    zh: "上：板凳龙，颜色越深越慢。下：速度误差随时间步长的变化",
  };
  lab.update = () => {
    const head = begin + time.value, length = 10 ** step.value;
    [now, later] = [chainAt(spiral, dragon, head), chainAt(spiral, dragon, head + length)];
    speeds = now.ratios.map(Math.abs);
    // The change of the angle over the step, times the arc length of a radian.
    const quotient = now.s.map((s, i) => {
      const theta = spiral.angle(s);
      return spiral.k * Math.sqrt(theta * theta + 1) * Math.abs(spiral.angle(later.s[i]) - theta) / length;
    });
    error = Math.max(...quotient.map((speed, i) => Math.abs(speed - speeds[i])));
    if (triedAt !== time.value) [tried, triedAt] = [new Map(), time.value];
    tried.set(step.value, Math.log10(error));
  };
  lab.pane(0.55, () => ({ x: 0, y: 0, width: 26, height: 26 }), (pane) => {
    pane.line(points, { colour: "curve" });
    const loss = (i) => (1 - speeds[i]) / (1 - speeds.at(-1));
    pane.benches(benchesBetween(dragon, now.points), { colour: (i) => lab.mixed("head", "contact", loss(i)) });
    for (const i of [0, 223]) pane.text(now.points[i], `${(1000 * speeds[i]).toFixed(1)} mm/s`, { dy: -14 });
  });
  const chart = lab.pane(0.45, () => ({
    across: [-10.4, 0.4], up: [-10, -1], name: { en: "error (m/s) by the time step (s)", zh: "误差 (m/s) 随时间步长 (s) 的变化" },
    tickAcross: power, tickUp: power,
  }), (pane) => {
    for (const each of tried) pane.dot(each, { colour: "body", radius: 3.5 });
  });
  lab.knob({
    pane: chart, step: 0.1, label: { en: "The time step: drag it along the chart", zh: "时间步长：沿图表拖动" },
    at: () => [step.value, Math.log10(error)],
    moved: ([x]) => { step.value = x; },
  });
  lab.readout = () => {
    const [tail, slower] = [1000 * speeds.at(-1), 1000 - 1000 * speeds.at(-1)].map((speed) => speed.toFixed(3));
    const [length, wrong] = [10 ** step.value, error].map((value) => value.toExponential(1));
    return {
      en: `The tail: ${tail} mm/s, ${slower} mm/s slower than the head. From positions ${length} s apart: wrong by ${wrong} m/s.`,
      zh: `龙尾 ${tail} mm/s，比龙头慢 ${slower} mm/s。由相隔 ${length} s 的两个位置求得：误差 ${wrong} m/s。`,
    };
  };
};
