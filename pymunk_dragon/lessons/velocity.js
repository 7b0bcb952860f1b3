// How fast is the tail, and how wrong is a speed from two positions a time step apart?
stages.velocity = (lab) => {
  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: 412,
    step: 1,
    value: 0,
    unit: "s",
    play: () => 25,
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
    play: () => 1,
  });
  const asked = 300; // s: the time in the question
  let before = 0;
  const march = new March();
  const { spiral, dragon } = march;
  const points = curvePoints(spiral, march.begin - 370, 0);
  /** @type {Chain} */
  let chain;
  /** @type {number[]} */
  let speeds;
  /** @type {number} */
  let error;
  // The smallest error of the steps that were tried at a time.
  let best = { time: NaN, step: NaN, error: Infinity };

  lab.label = [
    "The dragon, the slower the redder, with the speeds of head and tail",
    "板凳龙，越慢越红，标有龙头和龙尾的速度",
  ];
  lab.legend([
    ["head", ["as fast as the head", "与龙头一样快"]],
    ["contact", ["as slow as the tail", "与龙尾一样慢"]],
  ]);
  lab.update = () => {
    // The time that plays stops after five minutes.
    const stops = time.value >= asked && before < asked && time.value - before < 30;
    if (stops) time.value = asked;
    before = time.value;
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
    if (best.time !== time.value || error < best.error) {
      best = { time: time.value, step: step.value, error };
    }
  };
  lab.pane(
    1,
    () => ({
      x: 0,
      y: 0,
      size: 2.25 * Math.hypot(lastOf(chain.points)[0], lastOf(chain.points)[1]),
    }),
    (pane) => {
      pane.line(points, { colour: "curve" });
      /** @type {(i: number) => number} */
      const loss = (i) => (1 - speeds[i]) / (1 - lastOf(speeds));
      pane.benches(benchesBetween(dragon, chain.points), (i) =>
        lab.mixed("head", "contact", loss(i)),
      );
      const ends = { [lab.say(["head", "龙头"])]: 0, [lab.say(["tail", "龙尾"])]: dragon.benches };
      for (const [name, i] of Object.entries(ends)) {
        pane.text(chain.points[i], `${name} ${(1000 * speeds[i]).toFixed(1)} mm/s`, { dy: -14 });
      }
    },
  );
  // 10⁻³ of -3.
  /** @type {(n: number | string) => string} */
  const tick = (n) =>
    `10${String(n).replace(/./g, (digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)])}`;
  /** @type {(value: number) => string} */
  const metresPerSecond = (value) =>
    value.toExponential(1).replace(/e(.*)/, (_, power) => `·${tick(power)} m/s`);
  lab.readout = () => {
    const tail = 1000 * lastOf(speeds);
    const last = tail.toFixed(3);
    const slower = (1000 - tail).toFixed(3);
    const length = show(step.value);
    const wrong = metresPerSecond(error);
    const least = `${show(best.step)}, ${metresPerSecond(best.error)}`;
    const [english, chinese] =
      best.step === step.value
        ? ["", ""]
        : [` The best step so far: ${least}.`, `至此最好的步长：${least}。`];
    return [
      `The tail: ${last} mm/s, ${slower} mm/s slower than the head. ` +
        `From positions ${length} apart: ${wrong} off.${english}`,
      `龙尾 ${last} mm/s，比龙头慢 ${slower} mm/s。` +
        `由相隔 ${length} 的两个位置求得：误差 ${wrong}。${chinese}`,
    ];
  };
};
