// A bench is thrown at another one; each call of a callback leaves a dot, and the impulse it reads.
stages.callbacks = (lab) => {
  const rows = ["separate", "post_solve", "pre_solve", "begin"]; // from below
  const stepLength = 0.02; // s
  const slowly = 0.25; // times real time: a step of the contact is seen by itself
  const column = 46; // pixels: room for an impulse
  /** @type { { step: number, name: string, impulse: string }[]} */
  let calls = [];
  let thrown = false;
  const engine = new Played(lab, {
    scene: "callbacks",
    changed: (event) => {
      if (!event) {
        calls = [];
        return;
      }
      const [, impulse, name] = event.text.match(/([\d.]+) N s +(\w+)/) ?? [];
      // The event has the time at the end of its step; steps are counted from 0, as in the program.
      calls.push({ step: Math.round(event.time / stepLength) - 1, name, impulse });
    },
  });

  lab.label = [
    "One bench flies at another, and the calls of the contact over the steps",
    "一节板凳撞向另一节，以及逐步的回调",
  ];
  lab.legend([
    ["contact", ["benches in contact", "接触中的板凳"]],
    ["force", ["call that reads an impulse", "读到冲量的调用"]],
    ["quiet", ["call that reads 0", "读到 0 的调用"]],
  ]);
  const floor = lab.pane(
    0.55,
    () => ({ x: 0, y: 0.3, size: 5.5, wide: 8 }),
    (pane) => {
      engine.draw(pane);
      // Benches in contact have a rim.
      const { step = -Infinity, name } = calls.at(-1) ?? {};
      if (name !== "separate" && step >= (engine.frame?.step ?? 0) - 1) {
        for (const { points } of engine.bodies) {
          pane.line([...points, points[0]], { colour: "contact", width: 4 });
        }
      }
      for (const [k, letter] of ["A", "B"].entries()) {
        pane.text(engine.centre(k), letter, { dy: -20 });
      }
    },
  );
  const seen = () => {
    const columns = Math.max(3, Math.floor((lab.width - 110) / column));
    const last = calls.at(-1)?.step ?? 0;
    const first = Math.max(calls[0]?.step ?? 0, last - columns + 1);
    return { first, last: Math.max(first + columns, 1) };
  };
  lab.pane(
    0.45,
    () => {
      const { first, last } = seen();
      return {
        across: [first - 2.2, last - 0.4],
        up: [-0.6, rows.length - 0.1],
        name: ["step; the impulse that each call reads", "步；各次调用读到的冲量"],
        tick: (value) => (Number.isInteger(value) && value >= first ? `${value}` : ""),
        apart: Infinity,
      };
    },
    (pane) => {
      const { first, last } = seen();
      for (const [row, name] of rows.entries()) {
        pane.line(
          [
            [first - 0.5, row],
            [last, row],
          ],
          { colour: "rule" },
        );
        pane.text([first - 2.2, row], name, { dx: 2, align: "left", colour: "quiet" });
      }
      for (const { step, name, impulse } of calls.filter((call) => call.step >= first)) {
        const row = rows.indexOf(name);
        const colour = Number(impulse) ? "force" : "quiet";
        pane.dot([step, row], { colour, radius: Number(impulse) ? 6 : 4 });
        pane.text([step, row], impulse, { dy: -13, colour });
      }
    },
  );
  engine.hand(floor, ["Bench A: drag it against the other", "板凳 A：拖它去碰另一节"], () => 0);
  lab.readout = () =>
    engine.says(({ step }) => {
      if (!calls.length) {
        return [`Step ${step}. No callback so far.`, `第 ${step} 步。还没有回调。`];
      }
      const counts = [...rows]
        .reverse()
        .map((name) => `${name} ${calls.filter((call) => call.name === name).length}`)
        .join(", ");
      const blow = calls.find(({ impulse }) => Number(impulse));
      const [english, chinese] = blow
        ? [
            ` First with an impulse: ${blow.name}, ${blow.impulse} N s.`,
            `最先读到冲量的是 ${blow.name}：${blow.impulse} N s。`,
          ]
        : ["", ""];
      return [
        `Step ${step}. Calls: ${counts}.${english}`,
        `第 ${step} 步。调用次数：${counts}。${chinese}`,
      ];
    });

  lab.button(
    () => (thrown ? ["Throw again", "再扔一次"] : ["Throw bench A", "扔出板凳 A"]),
    () => {
      thrown = true;
      engine.send({ do: "reset" });
      engine.send({ do: "speed", value: slowly });
      engine.send({ do: "play" });
    },
  );
  lab.button(
    () => ["One step", "走一步"],
    () => engine.send({ do: "step", count: 1 }),
  );
  lab.button(
    () => (engine.running ? ["Pause", "暂停"] : ["Go on", "继续"]),
    () => engine.send({ do: engine.running ? "pause" : "play" }),
  );
  engine.slider("elasticity", ["elasticity", "弹性"], {
    min: 0,
    max: 1,
    step: 0.05,
    value: 0.5,
    digits: 2,
  });
};
