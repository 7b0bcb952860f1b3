// The step between samples and the width of the benches: which contact falls between two samples?
stages["missed-window"] = (lab) => {
  const begin = 405; // s
  const end = 413; // s
  const step = lab.slider(["a sample every", "采样间隔"], {
    min: -9,
    max: 1,
    step: 1,
    value: 0,
    show: roundSeconds,
  });
  const width = lab.slider(["width", "板凳宽度"], {
    min: 300.9,
    max: 301.1,
    step: 0.001,
    value: 301,
    unit: "mm",
  });
  const zoom = lab.slider(["zoom", "放大"], {
    min: 0,
    max: 1.6,
    step: 0.02,
    value: 0,
    show: magnification,
  });
  const time = { value: begin };
  /** @type {March} */
  let march;
  /** @type { { from: number, to: number, bench: number }[]} */
  let touching;
  /** @type {number} */
  let length;

  /** @type {(t: number) => number} */
  const gap = (t) => march.gap(t);
  // Points of the chart at the multiples of a step.
  /** @type {(apart: number, limits: Numbers) => Point[]} */
  const points = (apart, [from, to]) => {
    const first = Math.ceil(from / apart);
    const last = Math.floor(to / apart);
    return range(first, last, last - first).map((k) => [k * apart, 1000 * gap(k * apart)]);
  };
  /** @type {() => ChartView} */
  const view = () => {
    const scale = 10 ** zoom.value;
    const half = (end - begin) / 2 / scale;
    const base = 1000 * now.gap * (1 - 1 / scale ** 2);
    const middle = bounded(time.value, begin + half, end - half);
    return {
      across: [middle - half, middle + half],
      up: [base - 15 / scale ** 2, base + 30 / scale ** 2],
      name: [
        "gap of the head (mm) by the time (s), and samples",
        "龙头的空隙 (mm) 随时间 (s) 的变化，以及采样",
      ],
    };
  };
  const size = () => 5 / 10 ** (2 * zoom.value);
  /** @type {(t: number, handles?: number) => Benches<BenchSizes>} */
  const benchesAt = (t, handles) => march.benches(t, handles);
  const now = gapPanes(lab, {
    time,
    size,
    benchesAt,
    view,
    draw: (pane) => {
      const [from, to] = view().across;
      const fine = (end - begin) / 256 / 2 ** Math.round(zoom.value / Math.log10(2));
      pane.line(points(fine, [from - fine, Math.min(to + fine, now.seen)]), {
        colour: "body",
        width: 2,
      });
      const samples = to - from < 100 * length ? points(length, [from, to]) : [];
      for (const sample of samples) {
        pane.dot(sample, { colour: sample[1] > 0 ? "text" : "contact" });
      }
    },
  });
  lab.label = [
    "The head beside the bench that it passes; below, its gap, with samples",
    "龙头和它经过的板凳；下方是空隙和采样",
  ];
  lab.update = () => {
    time.value = bounded(time.value, begin, end);
    length = roundNumber(step.value);
    if (march?.dragon.widths[0] !== width.value / 1000) {
      march = new March({ benches: 60, width: width.value / 1000 });
      // From when to when the head touches the benches that it passes, and from when on bench 8.
      const passes = [406, 409]
        .map((t) => minimumBetween(gap, t, t + 2))
        .filter((t) => gap(t) <= 0);
      /** @type {(t: number) => { from: number, to: number }} */
      const limits = (t) => ({ from: rootBetween(gap, t - 1, t), to: rootBetween(gap, t + 1, t) });
      touching = passes.map((t) => ({ ...limits(t), bench: march.passed(t).bench }));
      touching.push({ from: rootBetween(gap, 411, end), to: Infinity, bench: 8 });
    }
    now.update();
  };
  lab.readout = () => {
    /** @type {(times: { from: number }) => number} */
    const sampled = ({ from }) => length * Math.ceil(from / length);
    const found = touching.find((each) => sampled(each) <= each.to) ?? lastOf(touching);
    const t = sampled(found).toFixed(3);
    const missed = found === touching[0] ? null : touching[0];
    const long = missed && (missed.to - missed.from).toFixed(3);
    const [english, chinese] = !missed
      ? ["No contact was missed.", "没有漏掉接触。"]
      : missed.to > now.seen
        ? ["", ""]
        : [
            `Missed: bench ${missed.bench}, touched for ${long} s.`,
            `漏掉了与 ${missed.bench} 号板凳的接触，历时 ${long} s。`,
          ];
    const at = time.value.toFixed(3);
    const apart = (1000 * now.gap).toFixed(3).replace("-", "−");
    const { bench } = found;
    return [
      `${at} s: gap ${apart} mm. The samples find the head in bench ${bench} at ${t} s. ${english}`,
      `${at} s：空隙 ${apart} mm。采样发现龙头在 ${t} s 与 ${bench} 号板凳重叠。${chinese}`,
    ];
  };
};
