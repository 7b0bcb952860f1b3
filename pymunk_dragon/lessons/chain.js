// Drag the next handle round handle 0, on the circle of a bench: where on the spiral does it belong?
stages.chain = (lab) => {
  const snap = 0.05; // m: a handle so close to a point of the spiral is put on it
  const time = lab.slider({ label: { en: "time", zh: "时间" }, unit: "s", min: 0, max: 420, step: 1, value: 300, play: () => 10 });
  const bench = lab.slider({ label: { en: "bench, hole to hole", zh: "板凳的孔距" }, unit: "m", min: 1, max: 2.86, step: 0.01, value: 2.86 });
  const spiral = new Spiral(0.55), begin = spiral.atAngle(16 * ROUND), points = curvePoints(spiral, begin - 200, 0, 0.05);
  let angle = 0.5, head, from, right, met, own;

  const round = (turn) => [from[0] + bench.value * Math.cos(turn), from[1] + bench.value * Math.sin(turn)];
  const apart = ([x, y], [otherX, otherY]) => Math.hypot(x - otherX, y - otherY);
  const onSpiral = () => met.find((s) => apart(spiral.frame(s), round(angle)) < snap);
  // Coordinates, from the outside in, at which the distance from handle 0 passes the bench.
  const meetings = () => {
    const excess = (s) => apart(spiral.frame(s), from) - bench.value;
    const found = [], theta = spiral.angle(head), reach = bench.value / spiral.k;
    for (let s = spiral.atAngle(theta + reach + 1), last = excess(s); s < 0; s += 0.02) {
      const here = excess(s + 0.02);
      if (last * here < 0) found.push(rootBetween((at) => excess(at) * Math.sign(last), s, s + 0.02));
      last = here;
      if (spiral.k * spiral.angle(s) < Math.abs(spiral.k * theta - bench.value) - 1) break;
    }
    return found;
  };

  lab.label = {
    en: "The spiral, handle 0 on it, the circle of a bench about it, and the next handle, which you drag",
    zh: "螺线和线上的 0 号把手，以它为圆心、孔距为半径的圆，以及由你拖动的下一个把手",
  };
  lab.update = () => {
    head = begin + time.value;
    from = spiral.frame(head).slice(0, 2);
    right = neighbour(spiral, head, bench.value);
    met = meetings();
    own = onSpiral();
  };
  lab.pane(1, () => ({ x: from[0], y: from[1], width: 2.4 * bench.value, height: 2.4 * bench.value }), (pane) => {
    pane.line(points, { colour: "curve", width: 1.5 });
    pane.line(Array.from({ length: 180 }, (_, i) => round(i * ROUND / 180)), { colour: "quiet", dash: [4, 4], closed: true });
    pane.benches(benchesBetween(makeDragon({ benches: 1, head: bench.value }), [from, round(angle)]));
    const colour = own === right ? "tail" : "contact";
    if (own) pane.line(curvePoints(spiral, Math.min(own, head), Math.max(own, head), 0.03), { colour, width: 4 });
    for (const s of met) pane.dot(spiral.frame(s), { colour: "quiet" });
    pane.arrow(from, spiral.frame(head).slice(2), 42);
    pane.dot(from, { radius: 6 });
    pane.text(from, lab.say({ en: "handle 0", zh: "0 号把手" }), { dy: 18 });
  });
  lab.knob({
    label: { en: "The next handle: drag it round the circle", zh: "下一个把手：沿圆周拖动" },
    at: () => round(angle),
    moved: ([x, y], key) => {
      angle = key ? angle + 3 * snap / bench.value * (key[1] - key[0]) : Math.atan2(y - from[1], x - from[0]);
      const [px, py] = spiral.frame(onSpiral() ?? NaN);
      if (px) angle = Math.atan2(py - from[1], px - from[0]);
    },
  });
  lab.readout = () => {
    const off = apart(spiral.frame(right), round(angle)).toFixed(2), along = Math.abs(head - own);
    const number = { en: `The circle meets the spiral at ${met.length} points. `, zh: `圆与螺线有 ${met.length} 个交点。` };
    const where = !own ? { en: `Your handle is not on the spiral, and ${off} m from where it belongs.`, zh: `你的把手不在螺线上，离正确位置 ${off} m。` }
      : own === right ? { en: `This is the next handle: ${along.toFixed(3)} m back along the path.`, zh: `这就是下一个把手：沿路径往回 ${along.toFixed(3)} m。` }
      : own > head ? { en: `This point is ahead of handle 0, ${along.toFixed(1)} m along the path.`, zh: `这一点在 0 号把手前面，沿路径相距 ${along.toFixed(1)} m。` }
      : { en: `This point is ${along.toFixed(1)} m back along the path, ${off} m from where it belongs.`, zh: `这一点沿路径往回 ${along.toFixed(1)} m，离正确位置 ${off} m。` };
    return { en: number.en + where.en, zh: number.zh + where.zh };
  };
};
