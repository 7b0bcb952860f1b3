// The step between samples and the width of the benches: which contact falls between two samples?
stages["missed-window"] = (lab) => {
  const begin = 405; // s
  const end = 413; // s
  const flash = 0.25; // s: how long a sample is seen on the floor
  const most = 200; // samples that are drawn one by one
  const time = lab.slider(["time", "时间"], {
    min: begin,
    max: end,
    step: 0.001,
    value: begin,
    unit: "s",
    digits: 3,
    play: () => 0.5,
  });
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
  /** @type {March} */
  let march;
  /** @type { { from: number, to: number, bench: number }[]} */
  let touching;
  /** @type {number} */
  let length;

  /** @type {(t: number) => number} */
  const gap = (t) => march.gap(t);
  let seen = begin;
  /** @type {NearestBench} */
  let now;

  lab.label = [
    "The head beside the benches that it passes; below, the samples until now",
    "龙头和它经过的板凳；下方是至此的采样",
  ];
  lab.legend([
    ["head", ["head", "龙头"]],
    ["contact", ["overlap", "重叠"]],
    ["text", ["sample without an overlap", "没有发现重叠的采样"]],
  ]);
  lab.update = () => {
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
    now = march.passed(time.value);
    seen = Math.max(seen, time.value);
  };
  lab.pane(
    0.76,
    () => ({ x: now.ends[0][0], y: now.ends[0][1], size: 4, wide: 4.5 }),
    (pane) => {
      const hit = now.gap <= 0 ? now.bench : null;
      pane.benches(march.benches(time.value, 61), (i) =>
        i === hit ? "contact" : headAndBodies(i),
      );
      const last = length * Math.floor(time.value / length + 1e-9);
      if (length < flash || time.value > last + flash) return;
      const overlaps = gap(last) <= 0;
      const words = lab.say(
        overlaps
          ? [`${last} s: overlap`, `${last} s：重叠`]
          : [`${last} s: no overlap`, `${last} s：没有重叠`],
      );
      const colour = overlaps ? "contact" : "text";
      pane.text(pane.toWorld(pane.width / 2, pane.top + 24), words, { colour });
    },
  );
  const strip = lab.pane(
    0.24,
    () => ({
      across: [begin, end],
      up: [0, 1],
      name: ["samples by the time (s)", "采样随时间 (s) 的分布"],
      apart: Infinity,
    }),
    (pane) => {
      /** @type {(from: number, to: number, look: { colour: string, width: number }) => void} */
      const bar = (from, to, look) =>
        pane.line(
          [
            [from, 0.5],
            [Math.min(to, seen), 0.5],
          ],
          look,
        );
      bar(begin, seen, { colour: "body", width: 2 });
      for (const { from, to } of touching) {
        if (from < seen) bar(from, to, { colour: "contact", width: 16 });
      }
      const count = Math.floor((seen - begin) / length + 1e-9);
      if (count > most) bar(begin, seen, { colour: "text", width: 4 });
      else {
        for (const k of range(0, count, count)) {
          const t = begin + k * length;
          pane.dot([t, 0.5], { colour: gap(t) > 0 ? "text" : "contact", radius: 5 });
        }
      }
    },
  );
  lab.knob(["The time: drag it along the strip", "时间：沿时间轴拖动"], {
    pane: strip,
    step: 0.01,
    at: () => [time.value, 0.5],
    moved: ([t]) => {
      time.value = t;
    },
  });
  lab.readout = () => {
    /** @type {(times: { from: number }) => number} */
    const sampled = ({ from }) => length * Math.ceil(from / length);
    const found = touching.find((each) => sampled(each) <= each.to) ?? lastOf(touching);
    const missed = found === touching[0] ? null : touching[0];
    const at = time.value.toFixed(3);
    const apart = (1000 * now.gap).toFixed(3).replace("-", "−");
    const english = [`${at} s: gap ${apart} mm.`];
    const chinese = [`${at} s：空隙 ${apart} mm。`];
    // Only what the time has come to.
    if (sampled(found) <= seen) {
      const t = sampled(found).toFixed(3);
      english.push(`The samples find the head in bench ${found.bench} at ${t} s.`);
      chinese.push(`采样发现龙头在 ${t} s 与 ${found.bench} 号板凳重叠。`);
      if (!missed) {
        english.push("No contact was missed.");
        chinese.push("没有漏掉接触。");
      }
    }
    if (missed && missed.to <= seen) {
      const long = (missed.to - missed.from).toFixed(3);
      english.push(`Missed: bench ${missed.bench}, touched for ${long} s.`);
      chinese.push(`漏掉了与 ${missed.bench} 号板凳的接触，历时 ${long} s。`);
    }
    return [english.join(" "), chinese.join("")];
  };
};
