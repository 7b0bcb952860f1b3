// Drag the point where both arcs meet: who leaves the circle first, the contest's dragon or yours?
stages["u-turn"] = (lab) => {
  const radius = 4.5; // m
  const farthest = 2 / 3; // share of the radius up to which the point may be dragged
  const time = lab.slider(["time", "时间"], {
    min: -5,
    max: 20,
    step: 0.02,
    value: -2,
    unit: "s",
    digits: 2,
    play: () => 1.25,
  });
  const dragon = makeDragon({ benches: 60 });
  const contest = new UTurn({ ratio: 2 });
  let share = 0;
  let bent = false; // whether the point was dragged
  /** @type {UTurn} */
  let own;
  /** @type {number} */
  let jam;

  const bend = () => {
    own = new UTurn({ ratio: (1 - share) / (1 + share) });
    // Where, in an arc narrower than it, the head's bench would push its rear handle back.
    jam = range(0, 20, 1000).find((s) => !(chainAt(own, dragon, s, 2).ratios[1] > 0)) ?? Infinity;
  };
  bend();
  lab.keep(
    "share",
    () => share,
    (given) => {
      share = bounded(given, -farthest, farthest);
      bent = true;
      bend();
    },
  );

  // Lengths of the arcs, once they say no more of the guess than the learner has seen.
  const measured = () => bent || time.value > contest.length;
  /** @type {(pane: StagePane, curve: UTurn, colour: string) => void} */
  const drawLengths = (pane, curve, colour) => {
    const [first, second] = curve.lengths;
    for (const [middle, length] of [
      [first / 2, first],
      [first + second / 2, second],
    ]) {
      pane.text(curve.frame(middle), `${length.toFixed(2)} m`, { colour });
    }
  };

  // A dragon on its curve; from the time `last` on only the head's handle.
  /** @type {(pane: StagePane, curve: UTurn, colour: string, last: number) => void} */
  const drawDragon = (pane, curve, colour, last) => {
    pane.line(curvePoints(curve, -40, 54), { colour: "curve" });
    pane.line(curvePoints(curve, 0, curve.length), { colour, width: 3 });
    const handles = time.value < last ? dragon.benches + 1 : 1;
    const { points } = chainAt(curve, dragon, time.value, handles);
    pane.benches(benchesBetween(dragon, points), (i) => (i === 0 ? "head" : colour), 0.85);
    pane.dot(points[0], { colour, radius: 7 });
  };

  lab.legend([
    ["body", ["contest", "竞赛题"]],
    ["tail", ["you", "你"]],
    ["rule", ["circle of 9 m", "直径 9 m 的圆"]],
  ]);
  lab.label = [
    "Two dragons that turn inside the circle along different arcs",
    "两条板凳龙沿不同的圆弧在圆内调头",
  ];
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 11.6 }),
    (pane) => {
      pane.line(circlePoints([0, 0], radius), { colour: "rule", width: 2 });
      pane.line([own.points[0], own.points[2]], { colour: "quiet", dash: [5, 5] });
      drawDragon(pane, contest, "body", Infinity);
      drawDragon(pane, own, "tail", jam);
      if (measured()) drawLengths(pane, own, "tail");
      pane.text(contest.frame(time.value), lab.say(["contest", "竞赛题"]), { dy: -16 });
      pane.text(own.frame(time.value), lab.say(["you", "你"]), { dy: 18 });
    },
  );
  lab.knob(
    [
      "The point where your arcs meet: drag it along the diameter",
      "你的两段圆弧的切点：沿直径拖动",
    ],
    {
      at: () => own.points[1],
      moved: ([x, y], way) => {
        const [ex, ey] = own.points[0];
        const given = way ? share + 0.02 * way : (x * ex + y * ey) / radius ** 2;
        share = bounded(given, -farthest, farthest);
        bent = true;
        bend();
      },
    },
  );
  lab.readout = () => {
    /** @type {(curve: UTurn) => string} */
    const sum = ({ lengths: [first, second] }) => {
      // what the head has walked
      const one = bounded(time.value, 0, first);
      const two = bounded(time.value - first, 0, second);
      return (
        [one, two].map((each) => each.toFixed(2)).join(" + ") + ` = ${(one + two).toFixed(2)} m`
      );
    };
    const english = [`Walked: the contest's ${sum(contest)}, yours ${sum(own)}.`];
    const chinese = [`走过的路：竞赛题 ${sum(contest)}，你的 ${sum(own)}。`];
    // At the end they are what was walked.
    if (bent && time.value < own.length) {
      const arcs = own.lengths.map((each) => each.toFixed(2)).join(" + ");
      const all = own.length.toFixed(2);
      english.push(`Your arcs: ${arcs} = ${all} m.`);
      chinese.push(`你的两段弧：${arcs} = ${all} m。`);
    }
    if (time.value >= jam) {
      english.push("But your head's bench would push its rear handle back.");
      chinese.push("但是你的龙头会把后把手往回推。");
    }
    return [english.join(" "), chinese.join("")];
  };
};
