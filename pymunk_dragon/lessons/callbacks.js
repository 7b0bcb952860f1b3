// A bench is thrown at another one; each call of a callback leaves a dot, and the impulse it reads.
stages.callbacks = (lab) => {
  const rows = ["separate", "post_solve", "pre_solve", "begin"]; // from below
  const stepLength = 0.02; // s
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
  const floor = lab.pane(
    0.55,
    () => ({ x: 0, y: 0.3, size: 5.5, wide: 8 }),
    (pane) => {
      engine.draw(pane);
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
        pane.dot([step, row], { colour: "contact", radius: 4 });
        pane.text([step, row], impulse, { dy: -13 });
      }
    },
  );
  engine.hand(floor, ["Bench A: drag it against the other", "板凳 A：拖它去碰另一节"], () => 0);
  lab.readout = () =>
    engine.says(({ step }) => {
      const { name, impulse } = calls.at(-1) ?? {};
      if (!name) return [`Step ${step}. No callback so far.`, `第 ${step} 步。还没有回调。`];
      return [
        `Step ${step}. ${calls.length} calls; the last, ${name}, read ${impulse} N s.`,
        `第 ${step} 步。共 ${calls.length} 次调用；最后的 ${name} 读到 ${impulse} N s。`,
      ];
    });

  lab.button(
    () => (thrown ? ["Throw again", "再扔一次"] : ["Throw bench A", "扔出板凳 A"]),
    () => {
      thrown = true;
      engine.send({ do: "reset" });
      engine.send({ do: "speed", value: 0.5 });
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
