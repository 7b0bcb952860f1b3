// Drag the time step: how wrong is a speed from two positions, and how fast is the tail?
stages.velocity = (lab) => {
  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: 412,
    step: 1,
    value: 0,
    unit: "s",
    play: () => 10,
  });
  const units = ["s", "ms", "µs", "ns", "ps"];
  /** @type {(exponent: number) => string} */
  const show = (exponent) => {
    const unit = Math.ceil(-exponent / 3);
    return `${Number((10 ** (exponent + 3 * unit)).toPrecision(2))} ${units[unit]}`;
  };
  const step = lab.slider(["time step", "时间步长"], {
    min: -10,
    max: 0,
    step: 0.1,
    value: 0,
    show,
  });
  const march = new March();
  const { spiral, dragon } = march;
  const points = curvePoints(spiral, march.begin - 370, 0);
  /** @type {Chain} */
  let chain;
  /** @type {number[]} */
  let speeds;
  /** @type {number} */
  let error;
  /** @type {Map<number, number>} */
  let tried;
  /** @type {number} */
  let triedAt;

  lab.label = [
    "The dragon, the slower the darker; below, the error of its speeds",
    "板凳龙，颜色越深越慢；下方是速度的误差",
  ];
  lab.update = () => {
    const length = 10 ** step.value;
    const later = march.chain(time.value + length);
    chain = march.chain(time.value);
    speeds = chain.ratios.map(Math.abs);
    // The change of the angle in the step, times the arc length of a radian.
    error = Math.max(
      ...chain.s.map((s, i) => {
        const theta = spiral.angle(s);
        const turned = Math.abs(spiral.angle(later.s[i]) - theta);
        return Math.abs((spiral.k * Math.hypot(theta, 1) * turned) / length - speeds[i]);
      }),
    );
    if (triedAt !== time.value) {
      tried = new Map();
      triedAt = time.value;
    }
    tried.set(step.value, Math.log10(error));
  };
  lab.pane(
    0.55,
    () => ({
      x: 0,
      y: 0,
      size: 2.6 * Math.hypot(lastOf(chain.points)[0], lastOf(chain.points)[1]),
    }),
    (pane) => {
      pane.line(points, { colour: "curve" });
      /** @type {(i: number) => number} */
      const loss = (i) => (1 - speeds[i]) / (1 - lastOf(speeds));
      pane.benches(benchesBetween(dragon, chain.points), (i) =>
        lab.mixed("head", "contact", loss(i)),
      );
      for (const i of [0, 223]) {
        pane.text(chain.points[i], `${(1000 * speeds[i]).toFixed(1)} mm/s`, { dy: -14 });
      }
    },
  );
  // 10⁻³ of -3.
  /** @type {(n: number | string) => string} */
  const tick = (n) =>
    `10${String(n).replace(/./g, (digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)])}`;
  const chart = lab.pane(
    0.45,
    () => ({
      across: [-10.4, 0.4],
      up: [-10, -1],
      tick,
      name: ["error (m/s) by the time step (s)", "误差 (m/s) 随时间步长 (s) 的变化"],
    }),
    (pane) => {
      for (const each of tried) pane.dot(each, { colour: "body" });
    },
  );
  lab.knob(["The time step: drag it along the chart", "时间步长：沿图表拖动"], {
    pane: chart,
    step: 0.1,
    at: () => [step.value, Math.log10(error)],
    moved: ([exponent]) => {
      step.value = exponent;
    },
  });
  lab.readout = () => {
    const tail = 1000 * lastOf(speeds);
    const last = tail.toFixed(3);
    const slower = (1000 - tail).toFixed(3);
    const length = show(step.value);
    const wrong = error.toExponential(1).replace(/e(.*)/, (_, power) => `·${tick(power)}`);
    return [
      `The tail: ${last} mm/s, ${slower} mm/s slower than the head. ` +
        `From positions ${length} apart: ${wrong} m/s off.`,
      `龙尾 ${last} mm/s，比龙头慢 ${slower} mm/s。` +
        `由相隔 ${length} 的两个位置求得：误差 ${wrong} m/s。`,
    ];
  };
};
