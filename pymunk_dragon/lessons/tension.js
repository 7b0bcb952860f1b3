// The force in every joint of a chain that its head pulls: benches are pulled, and joints cut.
stages.tension = (lab) => {
  const most = 24; // benches
  const usual = 180; // N: above the drag on all of them
  const mostShown = 1000; // N: a hand is far stronger than the drag
  /** @type {number[]} */
  let numbers = []; // of the joints that are left, from the head on
  const engine = new Played(lab, {
    scene: "tension",
    plays: true,
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

  lab.label = [
    "A chain behind its head, and the force in each joint",
    "龙头拖着一串板凳，以及每个铰接处中的力",
  ];
  const floor = lab.pane(
    0.35,
    () => ({ x: -24, y: 0, size: 10, wide: 54 }),
    (pane) => {
      engine.draw(pane);
      const marked = chosen();
      if (marked) pane.dot(marked.point, { colour: "contact", radius: 5 });
    },
  );
  lab.pane(
    0.65,
    () => {
      const largest = Math.max(usual, ...joints().map(({ force }) => force));
      return {
        across: [-0.7, most - 0.3],
        up: [0, largest > usual ? Math.min(roundUp(largest), mostShown) : usual],
        name: ["force (N) over the joints, from head to tail", "从龙头到龙尾各铰接处中的力（N）"],
        tick: (value) => (Number.isInteger(value) ? `${value}` : ""),
      };
    },
    (pane) => {
      for (const { number, force } of joints()) {
        pane.line(
          [
            [number, 0],
            [number, force],
          ],
          { colour: "force", width: 3 },
        );
        const colour = number === joint.value ? "contact" : "force";
        pane.dot([number, force], { colour, radius: 4 });
      }
    },
  );
  engine.hand(
    floor,
    ["The last bench: pull it", "最后一节板凳：可以拉动"],
    () => engine.bodies.length - 1,
  );
  lab.readout = () =>
    engine.says(() => {
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

  engine.runs();
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
  engine.slider("dancers", ["dancers who push", "推着走的舞龙者"], { ...whole, value: 0 });
  engine.slider("damping", ["speed kept in 1 s", "1 秒后保留的速度"], {
    min: 0.2,
    max: 1,
    step: 0.05,
    value: 0.5,
    digits: 2,
  });
  const joint = lab.slider(["joint to read and cut", "要读数、要剪断的铰接处"], {
    ...whole,
    max: most - 1,
    value: 12,
  });
};
