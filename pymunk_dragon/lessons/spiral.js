// Drag the head along the spiral, and see in which angle
// five seconds of its walk appear from the centre.
stages.spiral = (lab) => {
  const piece = 5; // s of the head's walk that are marked
  const pitch = lab.slider(["pitch", "螺距"], {
    min: 0.4,
    max: 1,
    step: 0.05,
    value: 0.55,
    unit: "m",
  });
  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: 440,
    step: 1,
    value: 0,
    unit: "s",
    play: () => 40,
  });
  const dragon = makeDragon();
  /** @type {Spiral} */
  let spiral;
  /** @type {number} */
  let begin;
  /** @type {number} */
  let end;
  /** @type {number} */
  let head;
  /** @type {Point[]} */
  let points;
  /** @type {Point[]} */
  let marks;

  lab.label = [
    "The dragon, and the angle of 5 s of its walk seen from the centre",
    "板凳龙，以及从中心看它走 5 s 所张的角",
  ];
  lab.update = () => {
    if (spiral?.k !== pitch.value / TURN) {
      spiral = new Spiral(pitch.value);
      begin = spiral.atRadius(8.8);
      // The head bench still fits on the innermost turn.
      end = spiral.atRadius(1.5);
      points = curvePoints(spiral, begin - 55, 0);
      marks = curvePoints(spiral, begin, end, piece);
      time.max = Math.floor(end - begin);
    }
    head = begin + time.value;
  };
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 18.6 }),
    (pane) => {
      pane.line(points, { colour: "curve" });
      for (const mark of marks.slice(Math.ceil(time.value / piece))) {
        pane.dot(mark, { colour: "curve", radius: 2.5 });
      }
      pane.benches(benchesBetween(dragon, chainAt(spiral, dragon, head).points));
      const walked = curvePoints(spiral, head - piece, head);
      pane.fill([[0, 0], ...walked], { colour: "head", alpha: 0.4 });
      pane.line([walked[0], [0, 0], lastOf(walked)], { width: 1.5 });
      pane.line(walked, { colour: "contact", width: 4 });
      pane.dot([0, 0], { radius: 6 });
      pane.text([0, 0], lab.say(["you", "你"]), { dy: 17 });
    },
  );
  lab.knob(["The head: drag it along the spiral", "龙头：沿螺线拖动"], {
    at: () => spiral.frame(head),
    moved: (point, way) => {
      time.value = way ? time.value + piece * way : nearestOn(spiral, point, begin, end) - begin;
    },
  });
  lab.readout = () => {
    const [x, y, tx, ty] = spiral.frame(head);
    const away = Math.hypot(x, y);
    const turning = (y * tx - x * ty) / away ** 2;
    const radius = away.toFixed(2);
    const rate = turning.toFixed(3);
    const round = (TURN / turning).toFixed(1);
    return [
      `The head walks at 1 m/s, ${radius} m from you. ` +
        `You turn at ${rate} rad/s: a round in ${round} s.`,
      `龙头以 1 m/s 前进，离你 ${radius} m。你以 ${rate} rad/s 转身：转一圈要 ${round} s。`,
    ];
  };
};
