// Drag the point where both arcs meet: who leaves the circle first, the contest's dragon or yours?
stages["u-turn"] = (lab) => {
  const radius = 4.5, widest = 5; // m, and the largest ratio of the radii
  const time = lab.slider({ label: { en: "time", zh: "时间" }, unit: "s", min: -5, max: 20, step: 0.02, value: -2, play: () => 1,
    show: (t) => `${t.toFixed(2)} s` });
  const dragon = makeDragon({ benches: 60 }), contest = new UTurn({ ratio: 2 });
  const circle = Array.from({ length: 120 }, (_, i) => [radius * Math.cos(i * ROUND / 120), radius * Math.sin(i * ROUND / 120)]);
  let ratio = 1, own = new UTurn({ ratio });

  lab.label = { en: "Two dragons that turn inside the circle along different arcs", zh: "两条板凳龙沿不同的圆弧在圆内调头" };
  lab.pane(1, () => ({ x: 0, y: 0, width: 11.6, height: 11.6 }), (pane) => {
    pane.line(circle, { colour: "rule", width: 2, closed: true });
    pane.line([own.points[0], own.points[2]], { colour: "quiet", dash: [5, 5] });
    for (const [curve, colour] of [[contest, "body"], [own, "tail"]]) {
      pane.line(curvePoints(curve, -40, 54), { colour: "curve" });
      pane.line(curvePoints(curve, 0, curve.length), { colour, width: 3 });
      const { points } = chainAt(curve, dragon, time.value);
      pane.benches(benchesBetween(dragon, points), { colour: (i) => (i === 0 ? "head" : colour), alpha: 0.85 });
      pane.dot(points[0], { colour, radius: 7 });
    }
    pane.text(chainAt(contest, dragon, time.value, 1).points[0], lab.say({ en: "contest", zh: "赛题" }), { dy: -16 });
    pane.text(chainAt(own, dragon, time.value, 1).points[0], lab.say({ en: "you", zh: "你" }), { dy: 18 });
  });
  lab.knob({
    label: { en: "The point where your arcs meet: drag it along the diameter", zh: "你的两段圆弧的切点：沿直径拖动" },
    at: () => own.points[1],
    moved: ([x, y], key) => {
      const [ex, ey] = own.points[0], before = (1 - ratio) / (1 + ratio);
      const share = key ? before + 0.02 * (key[0] + key[1]) : (x * ex + y * ey) / radius ** 2;
      const most = (widest - 1) / (widest + 1), bounded = Math.min(Math.max(share, -most), most);
      ratio = (1 - bounded) / (1 + bounded);
      own = new UTurn({ ratio });
    },
  });
  lab.readout = () => {
    const sum = ({ lengths: [one, two], length }) => `${one.toFixed(3)} m + ${two.toFixed(3)} m = ${length.toFixed(3)} m`;
    const fits = chainAt(own, dragon, time.value, 2).s.length === 2;
    return {
      en: `The contest's arcs: ${sum(contest)}. Yours: ${sum(own)}.` + (fits ? "" : " Your head's bench does not fit in there."),
      zh: `赛题的圆弧：${sum(contest)}。你的：${sum(own)}。` + (fits ? "" : "你的龙头板凳在那里转不过去。"),
    };
  };
};
