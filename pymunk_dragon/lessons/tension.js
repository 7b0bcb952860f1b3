// The force in every joint of a chain that its head pulls: benches are pushed and pulled, and
// joints cut.
stages.tension = (lab) => {
  const most = 24; // benches
  const room = 3; // benches: for the arrow of the pull
  const usual = 200; // N: above the drag on all of them
  const strongest = 200; // N
  const perMetre = 30; // N: of an arrow's length
  const kept = 0.5; // of the speed, in a second, on the ground
  /** @type {number[]} */
  let numbers = []; // of the joints that are left, from the head on
  let ice = false;
  const engine = new Played(lab, {
    scene: "tension",
    changed: (event) => {
      if (!event) numbers = [];
    },
  });

  /** @type {() => { number: number, force: number, point: Point }[]} */
  const joints = () => {
    const rows = [...rowsOf(engine.frame?.joints ?? new Float64Array(0), JOINT_SIZE)];
    if (!numbers.length) numbers = [...rows.keys()];
    return rows.map(([x0, y0, x1, y1, force], place) => ({
      number: numbers[place],
      force,
      point: [(x0 + x1) / 2, (y0 + y1) / 2],
    }));
  };
  const chosen = () => joints().find(({ number }) => number === joint.value);
  // As in the program.
  /** @type {(bench: number) => boolean} */
  const isPushed = (bench) => bench > 0 && (bench * dancers.value) % most < dancers.value;
  /** @type {() => Point} */
  const end = () => {
    const [x, y] = engine.centre(engine.bodies.length - 1);
    return [x - 1, y];
  };
  /** @type {() => Point} */
  const hand = () => [end()[0] - pull.value / perMetre, end()[1]];
  // Joints stand from right to left, as the benches do: each bar below its joint.
  /** @type {Limits} */
  const across = [0.3 - most - room, 0.7];
  const perJoint = () =>
    (lab.width - CHART_MARGINS.left - CHART_MARGINS.right) / (across[1] - across[0]);

  // A bench as a stroke, as it would be a hairline on a phone.
  /** @type {(pane: StagePane, points: Point[], colour: string) => void} */
  const drawBench = (pane, points, colour) => {
    const sides = points.map((point, i) => [point, points[(i + 1) % points.length]]);
    const [[x, y], [otherX, otherY]] = smallestOf(
      sides,
      ([one, two]) => -Math.hypot(two[0] - one[0], two[1] - one[1]),
    );
    const share = 0.44; // of the bench, on either side of its middle
    const middle = [0, 1].map((axis) => sumOf(points.map((point) => point[axis])) / points.length);
    const ends = [share, -share].map((part) => [
      middle[0] + part * (otherX - x),
      middle[1] + part * (otherY - y),
    ]);
    pane.line(ends, { colour, width: 9 });
  };

  lab.label = [
    "A chain behind its head, and the force in each joint",
    "龙头拖着一串板凳，以及每个铰接处中的力",
  ];
  lab.legend([
    ["head", ["head, which pulls", "龙头，在拉"]],
    ["force", ["force", "力"]],
    ["contact", ["joint to read and cut", "要读数、要剪断的铰接处"]],
    ["tail", ["dancer, who pushes", "推着走的舞龙者"]],
  ]);
  const floor = lab.pane(
    0.25,
    () => {
      const metre = perJoint() / 2; // pixels
      const first = CHART_MARGINS.left - across[0] * perJoint(); // of the joint at the head
      return { x: -1 + (lab.width / 2 - first) / metre, y: 0, size: 1, wide: lab.width / metre };
    },
    (pane) => {
      // The ground goes back under somebody who walks beside the head.
      const gone = (engine.frame?.time ?? 0) % 2;
      const below = -20 / pane.sx;
      for (let x = -60; x < 6; x += 2) {
        pane.dot([x - gone, below], { colour: "curve", radius: 2 });
      }
      for (const bench of engine.bodies.keys()) {
        const [x, y] = engine.centre(bench);
        if (isPushed(bench)) pane.dot([x, y - 11 / pane.sx], { colour: "tail", radius: 4 });
        drawBench(pane, engine.bodies[bench].points, headAndBodies(bench));
      }
      if (pull.value) pane.line([end(), hand()], { colour: "force", width: 3 });
      const marked = chosen();
      if (marked) pane.dot(marked.point, { colour: "contact", radius: 5 });
    },
  );
  lab.pane(
    0.75,
    () => {
      const largest = Math.max(usual, ...joints().map(({ force }) => force));
      return {
        across,
        up: [0, largest > usual ? 2 * usual : usual],
        name: ["force (N) in each joint", "各铰接处中的力（N）"],
        tick: (value) => {
          if (value > 0) return `${value}`;
          return Number.isInteger(value) && value > -most ? `${-value}` : "";
        },
      };
    },
    (pane) => {
      for (const { number, force } of joints()) {
        const colour = number === joint.value ? "contact" : "force";
        pane.line(
          [
            [-number, 0],
            [-number, force],
          ],
          { colour, width: 4 },
        );
        pane.dot([-number, force], { colour, radius: 4 });
      }
    },
  );
  lab.knob(["The last bench: pull it back", "最后一节板凳：往后拉"], {
    pane: floor,
    step: 0.5,
    at: hand,
    moved: ([x], way) => {
      pull.value = bounded(way ? pull.value - 10 * way : perMetre * (end()[0] - x), 0, strongest);
      engine.send({ do: "set", name: "pull", value: pull.value });
    },
  });
  lab.readout = () =>
    engine.says(({ step }) => {
      if (!step) return ["Press Play: the head goes at 1 m/s.", "请按播放：龙头以 1 m/s 前进。"];
      const [first] = joints();
      const force = chosen()?.force;
      const shown = `${(first?.force ?? 0).toFixed(1)} N`;
      if (force === undefined) {
        return [
          `The first joint carries ${shown}. Joint ${joint.value} is cut.`,
          `第一个铰接处受力 ${shown}。铰接处 ${joint.value} 已剪断。`,
        ];
      }
      return [
        `The first joint carries ${shown}, joint ${joint.value} ${force.toFixed(1)} N.`,
        `第一个铰接处受力 ${shown}，铰接处 ${joint.value} 受力 ${force.toFixed(1)} N。`,
      ];
    });

  lab.button(
    () => (engine.running ? ["Pause", "暂停"] : ["Play", "播放"]),
    () => engine.send({ do: engine.running ? "pause" : "play" }),
  );
  lab.button(
    () => (ice ? ["Back to the ground", "回到地面"] : ["Put it on ice", "放到冰上"]),
    () => {
      ice = !ice;
      engine.send({ do: "set", name: "damping", value: ice ? 1 : kept });
    },
  );
  lab.button(
    () => ["Cut the joint", "剪断铰接处"],
    () => {
      const found = chosen();
      if (!found) return;
      numbers = numbers.filter((number) => number !== found.number);
      engine.send({ do: "cut", x: found.point[0], y: found.point[1], slip: 0.5 });
    },
  );
  const whole = { min: 0, max: most, step: 1 };
  const dancers = engine.slider("dancers", ["dancers who push", "推着走的舞龙者"], {
    ...whole,
    value: 0,
  });
  const pull = engine.slider("pull", ["pull at the tail", "往后拉龙尾"], {
    min: 0,
    max: strongest,
    step: 10,
    value: 0,
    unit: "N",
  });
  const joint = lab.slider(["joint to read and cut", "要读数、要剪断的铰接处"], {
    ...whole,
    max: most - 1,
    value: 12,
  });
};
