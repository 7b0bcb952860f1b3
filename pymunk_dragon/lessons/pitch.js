// Make the pitch smaller until the dragon just gets in; and what do samples say?
stages.pitch = (lab) => {
  const radius = 4.5, last = 20, handles = 40; // m, s: samples are taken in the last seconds
  const coarse = lab.slider({ label: { en: "pitch", zh: "螺距" }, unit: "mm", min: 310, max: 600, step: 1, value: 550 });
  const fine = lab.slider({ label: { en: "and more", zh: "再加" }, unit: "mm", min: 0, max: 1, step: 0.001, value: 0 });
  const step = lab.slider({
    label: { en: "a sample every", zh: "取样间隔" }, min: -6, max: 0, step: 1, value: 0, show: (n) => `${roundNumber(n)} s`,
  });
  const dragon = makeDragon();
  let pitch, spiral, begin, arrival, stop, head, least, points;

  const gapAt = (s) => closest(benchesBetween(dragon, chainAt(spiral, dragon, s, handles).points), 0, 2, handles);
  const gap = (s) => gapAt(s).gap;
  lab.label = { en: "The dragon on its way to the circle, as far as it gets", zh: "盘入的板凳龙，停在它能到达的地方" };
  lab.update = () => {
    if (pitch === (coarse.value + fine.value) / 1000) return;
    pitch = (coarse.value + fine.value) / 1000;
    spiral = new Spiral(pitch);
    [begin, arrival] = [spiral.atAngle(16 * ROUND), spiral.atRadius(radius)];
    points = curvePoints(spiral, begin - 60, 0);
    stop = firstContact(gap, begin, arrival, 0.5, 0.005).root;
    head = stop ?? arrival;
    // The smallest gaps of the last seconds, whether benches overlap or not.
    const from = begin + Math.max(0, Math.floor(arrival - begin) - last);
    least = [from, ...firstContact((s) => gap(s) + 1, from, arrival, 0.5, 1.02).minima, arrival];
  };
  lab.pane(1, () => ({ x: 0, y: 0, width: 19, height: 19 }), (pane) => {
    pane.line(points, { colour: "curve" });
    pane.line(Array.from({ length: 120 }, (_, i) => [radius * Math.cos(i * ROUND / 120), radius * Math.sin(i * ROUND / 120)]), { closed: true, width: 2 });
    const hit = stop !== null && head >= stop ? gapAt(stop).bench : null;
    const part = (i) => (i === 0 ? "head" : i === hit ? "contact" : "body");
    pane.benches(benchesBetween(dragon, chainAt(spiral, dragon, head).points), { colour: part });
  });
  lab.knob({
    label: { en: "The head: drag it along the spiral", zh: "龙头：沿螺线拖动" },
    at: () => spiral.frame(head).slice(0, 2),
    moved: (point, key) => {
      const [from, to] = [begin, stop ?? arrival];
      head = key ? Math.min(Math.max(head + (key[0] + key[1]) / 2, from), to) : nearestOn(spiral, point, from, to);
    },
  });
  lab.readout = () => {
    const length = roundNumber(step.value), beside = (s, round) => begin + length * round((s - begin) / length);
    const samples = least.flatMap((s) => [beside(s, Math.floor), beside(s, Math.ceil)]).filter((s) => s >= least[0] && s < arrival);
    const [exact, sampled] = [least, samples].map((all) => (1000 * Math.min(...all.map(gap))).toFixed(3));
    const away = (spiral.k * spiral.angle(stop ?? arrival)).toFixed(3), bench = stop && gapAt(stop).bench;
    const [en, zh] = stop === null ? ["The dragon gets in.", "板凳龙能进去。"]
      : stop === begin ? ["Benches overlap at the start.", "一开始就有板凳重叠。"]
      : [`The head meets bench ${bench}, ${away} m from the centre.`, `龙头在离中心 ${away} m 处碰到 ${bench} 号板凳。`];
    return {
      en: `${en} Smallest gap of the last ${last} s: ${exact} mm; in the samples: ${sampled} mm.`,
      zh: `${zh}最后 ${last} s 的最小空隙：${exact} mm；取样所见：${sampled} mm。`,
    };
  };
};
