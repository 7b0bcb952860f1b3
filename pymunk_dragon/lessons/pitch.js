// Make the pitch smaller until the dragon just gets in; and what do samples say?
stages.pitch = (lab) => {
  const radius = 4.5; // m
  const last = 20; // s in which samples are taken
  const coarse = lab.slider(["pitch", "螺距"], {
    min: 310,
    max: 600,
    step: 1,
    value: 550,
    unit: "mm",
  });
  const fine = lab.slider(["fine adjustment", "微调"], {
    min: 0,
    max: 1,
    step: 0.001,
    value: 0,
    unit: "mm",
  });
  const step = lab.slider(["a sample every", "采样间隔"], {
    min: -3,
    max: 0,
    step: 1,
    value: 0,
    show: roundSeconds,
  });
  /** @type {March} */
  let march;
  /** @type {number} */
  let arrival;
  /** @type {number | null} */
  let stop;
  /** @type {number} */
  let time;
  /** @type {number} */
  let exact;
  /** @type {number} */
  let sampled;
  /** @type {number} */
  let sampledBy;
  /** @type {Point[]} */
  let points;

  // More than a turn back there are no benches that the head passes.
  /** @type {(t: number) => number} */
  const gap = (t) => march.gap(t, 30);
  lab.label = [
    "The dragon on its way to the circle, as far as it gets",
    "盘入的板凳龙，停在它能到达的地方",
  ];
  lab.update = () => {
    const pitch = (coarse.value + fine.value) / 1000;
    const length = roundNumber(step.value);
    const same = march?.pitch === pitch;
    if (!same) {
      march = new March({ pitch });
      points = curvePoints(march.spiral, march.begin - 60, 0);
      arrival = march.spiral.atRadius(radius) - march.begin;
      stop = firstContact(gap, 0, arrival, 1.2, 0.008);
      time = stop ?? arrival;
    }
    if (same && sampledBy === length) return;
    sampledBy = length;
    const first = Math.max(0, Math.floor(arrival) - last);
    const count = Math.ceil((arrival - first) / length) - 1;
    const near = smallestOf(range(first, arrival, 2 * last), gap);
    const least = minimumBetween(gap, near - 0.5, Math.min(near + 0.5, arrival));
    exact = Math.min(gap(least), gap(arrival));
    // Of dense samples, only those beside the minimum and the last one can be the smallest.
    const dense = length < 0.1;
    /** @type {(k: number) => boolean} */
    const beside = (k) => Math.abs(first + k * length - least) < 50 * length || k === count;
    const samples = range(0, count, count).filter((k) => !dense || beside(k));
    sampled = Math.min(...samples.map((k) => gap(first + k * length)));
  };
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 19 }),
    (pane) => {
      pane.line(points, { colour: "curve" });
      pane.line(circlePoints([0, 0], radius), { width: 2 });
      const hit = stop !== null && time >= stop ? march.passed(stop, 30).bench : null;
      pane.benches(march.benches(time), (i) => (i === 0 ? "head" : i === hit ? "contact" : "body"));
    },
  );
  lab.keep(
    "head",
    () => time,
    (given) => {
      time = bounded(given, 0, stop ?? arrival);
    },
  );
  lab.knob(["The head: drag it along the spiral", "龙头：沿螺线拖动"], {
    at: () => march.spiral.frame(march.begin + time),
    moved: (point, way) => {
      const { spiral, begin } = march;
      const end = stop ?? arrival;
      time = way
        ? bounded(time + way / 2, 0, end)
        : nearestOn(spiral, point, begin, begin + end) - begin;
    },
  });
  lab.readout = () => {
    const all = (1000 * exact).toFixed(3);
    const seen = (1000 * sampled).toFixed(3);
    const { spiral, begin } = march;
    const away = (spiral.k * spiral.angle(begin + (stop ?? 0))).toFixed(3);
    const bench = stop && march.passed(stop, 30).bench;
    const [english, chinese] =
      stop === null
        ? ["The dragon gets in.", "板凳龙能进去。"]
        : stop === 0
          ? ["Benches overlap at the start.", "一开始就有板凳重叠。"]
          : [
              `The head meets bench ${bench}, ${away} m from the centre.`,
              `龙头在离中心 ${away} m 处碰到 ${bench} 号板凳。`,
            ];
    return [
      `${english} Smallest gap of the last ${last} s: ${all} mm; in the samples: ${seen} mm.`,
      `${chinese}最后 ${last} s 的最小空隙：${all} mm；采样所见：${seen} mm。`,
    ];
  };
};
