// Make the pitch smaller until the dragon just gets in; and what do samples say?
stages.pitch = (lab) => {
  const radius = 4.5, last = 20, handles = 33; // m; s in which samples are taken; handles up to more than a turn back
  const coarse = lab.slider(["pitch", "螺距"], { min: 310, max: 600, step: 1, value: 550, unit: "mm" });
  const fine = lab.slider(["and more", "再加"], { min: 0, max: 1, step: 0.001, value: 0, unit: "mm" });
  const step = lab.slider(["a sample every", "取样间隔"], { min: -3, max: 0, step: 1, value: 0, show: (n) => `${roundNumber(n)} s` });
  const dragon = makeDragon();
  let pitch, spiral, begin, arrival, stop, head, first, exact, points;

  const gapAt = (s) => closest(benchesBetween(dragon, chainAt(spiral, dragon, s, handles).points), 0, 2, handles);
  const gap = (s) => gapAt(s).gap;
  const smallest = (places) => places.reduce((one, other) => (gap(other) < gap(one) ? other : one));
  lab.label = ["The dragon on its way to the circle, as far as it gets", "盘入的板凳龙，停在它能到达的地方"];
  lab.update = () => {
    if (pitch === (coarse.value + fine.value) / 1000) return;
    pitch = (coarse.value + fine.value) / 1000;
    spiral = new Spiral(pitch);
    [begin, arrival] = [spiral.atAngle(16 * ROUND), spiral.atRadius(radius)];
    points = curvePoints(spiral, begin - 60, 0);
    stop = firstContact(gap, begin, arrival, 0.8, 0.005);
    head = stop ?? arrival;
    first = begin + Math.max(0, Math.floor(arrival - begin) - last);
    const near = smallest(range(first, arrival, 2 * last));
    exact = Math.min(gap(minimumBetween(gap, near - 0.5, Math.min(near + 0.5, arrival))), gap(arrival));
  };
  lab.pane(1, () => ({ x: 0, y: 0, width: 19, height: 19 }), (pane) => {
    pane.line(points, { colour: "curve" });
    pane.line(circlePoints([0, 0], radius), { width: 2 });
    const hit = stop !== null && head >= stop ? gapAt(stop).bench : null;
    const colour = (i) => (i === 0 ? "head" : i === hit ? "contact" : "body");
    pane.benches(benchesBetween(dragon, chainAt(spiral, dragon, head).points), colour);
  });
  lab.knob(["The head: drag it along the spiral", "龙头：沿螺线拖动"], {
    at: () => spiral.frame(head).slice(0, 2),
    moved: (point, way) => {
      const to = stop ?? arrival;
      head = way ? bounded(head + way / 2, begin, to) : nearestOn(spiral, point, begin, to);
    },
  });
  lab.readout = () => {
    const length = roundNumber(step.value), count = Math.ceil((arrival - first) / length) - 1;
    const sampled = gap(smallest(range(first, first + count * length, count)));
    const [all, seen] = [exact, sampled].map((each) => (1000 * each).toFixed(3));
    const away = (spiral.k * spiral.angle(stop ?? arrival)).toFixed(3), bench = stop && gapAt(stop).bench;
    const [english, chinese] = stop === null ? ["The dragon gets in.", "板凳龙能进去。"]
      : stop === begin ? ["Benches overlap at the start.", "一开始就有板凳重叠。"]
      : [`The head meets bench ${bench}, ${away} m from the centre.`, `龙头在离中心 ${away} m 处碰到 ${bench} 号板凳。`];
    return [
      `${english} Smallest gap of the last ${last} s: ${all} mm; in the samples: ${seen} mm.`,
      `${chinese}最后 ${last} s 的最小空隙：${all} mm；取样所见：${seen} mm。`,
    ];
  };
};
