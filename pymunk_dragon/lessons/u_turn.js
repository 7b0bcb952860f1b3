// Drag the point where both arcs meet: who leaves the circle first, the contest's dragon or yours?
stages["u-turn"] = (lab) => {
  const radius = 4.5, farthest = 2 / 3; // m; share of it up to which the point may be dragged
  const time = lab.slider(["time", "时间"], {
    min: -5, max: 20, step: 0.02, value: -2, unit: "s", digits: 2, play: () => 1,
  });
  const dragon = makeDragon({ benches: 60 }), contest = new UTurn({ ratio: 2 });
  let share = 0, own = new UTurn({ ratio: 1 });

  lab.label = ["Two dragons that turn inside the circle along different arcs", "两条板凳龙沿不同的圆弧在圆内调头"];
  lab.pane(1, () => ({ x: 0, y: 0, size: 11.6 }), (pane) => {
    pane.line(circlePoints([0, 0], radius), { colour: "rule", width: 2 });
    pane.line([own.points[0], own.points[2]], { colour: "quiet", dash: [5, 5] });
    for (const [curve, colour] of [[contest, "body"], [own, "tail"]]) {
      pane.line(curvePoints(curve, -40, 54), { colour: "curve" });
      pane.line(curvePoints(curve, 0, curve.length), { colour, width: 3 });
      const { points } = chainAt(curve, dragon, time.value);
      pane.benches(benchesBetween(dragon, points), (i) => (i === 0 ? "head" : colour), 0.85);
      pane.dot(points[0], { colour, radius: 7 });
    }
    pane.text(contest.frame(time.value), lab.say(["contest", "赛题"]), { dy: -16 });
    pane.text(own.frame(time.value), lab.say(["you", "你"]), { dy: 18 });
  });
  lab.knob(["The point where your arcs meet: drag it along the diameter", "你的两段圆弧的切点：沿直径拖动"], {
    at: () => own.points[1],
    moved: ([x, y], way) => {
      const [ex, ey] = own.points[0], given = way ? share + 0.02 * way : (x * ex + y * ey) / radius ** 2;
      share = bounded(given, -farthest, farthest);
      own = new UTurn({ ratio: (1 - share) / (1 + share) });
    },
  });
  lab.readout = () => {
    const sum = ({ lengths, length }) => `${lengths.map((each) => `${each.toFixed(3)} m`).join(" + ")} = ${length.toFixed(3)} m`;
    const [english, chinese] = chainAt(own, dragon, time.value, 2).s.length === 2 ? ["", ""]
      : [" Your head's bench does not get round there.", "你的龙头在那里转不过去。"];
    return [
      `The contest's arcs: ${sum(contest)}. Yours: ${sum(own)}.${english}`,
      `赛题的圆弧：${sum(contest)}。你的：${sum(own)}。${chinese}`,
    ];
  };
};
