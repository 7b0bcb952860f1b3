// From ice to mud: where do the benches go that only the head pulls, and which ones touch first?
stages.unguided = (lab) => {
  /** @type {PulledRun[]} */
  const recorded = JSON.parse(block("unguided-data"));
  const last = recorded[0].until;
  /** @type {(i: number) => Words} */
  const ground = (i) => {
    if (i === 0) return ["(ice)", "（冰面）"];
    return i === recorded.length - 1 ? ["(mud)", "（泥地）"] : ["", ""];
  };
  const time = lab.slider(["time", "时间"], {
    min: 0,
    max: last,
    step: 0.02,
    value: 0,
    unit: "s",
    digits: 2,
    play: () => 1.5,
  });
  const drag = lab.slider(["drag of the ground", "地面的阻力"], {
    min: 0,
    max: recorded.length - 1,
    step: 1,
    value: 0,
    show: (i) => `${recorded[i].drag} /m ${lab.say(ground(i))}`.trim(),
  });
  const march = new March();
  const { dragon, spiral, begin } = march;
  const path = curvePoints(spiral, begin - 372, begin + last, 0.25);
  /** @type {Packed[]} */
  const packed = [];
  recorded.forEach(async ({ shape, text }, i) => {
    packed[i] = await unpack(shape, text);
    lab.requestDraw();
  });

  const contact = () => {
    const { contact: found } = recorded[drag.value];
    return found && found.time <= time.value ? found : null;
  };
  // Handles between two frames are on a straight line.
  /** @type {(t: number) => Point[]} */
  const handlesAt = (t) => {
    const found = packed[drag.value];
    if (!found) return march.chain(t).points.map(([x, y]) => [x, y]);
    const frame = (t / last) * (found.frames - 1);
    const before = Math.min(Math.floor(frame), found.frames - 2);
    const one = vectorsIn(found, before);
    const two = vectorsIn(found, before + 1);
    /** @type {(i: number) => number} */
    const between = (i) => one[i] + (frame - before) * (two[i] - one[i]);
    return Array.from({ length: found.points }, (_, i) => [between(2 * i), between(2 * i + 1)]);
  };

  lab.label = [
    "The dragon that only its head pulls, and the spiral that it would keep to",
    "只有龙头拉的板凳龙，以及它本来的螺线",
  ];
  /** @type {Benches<BenchSizes>} */
  let benches;
  lab.legend([
    ["head", ["head, which pulls", "龙头，在拉"]],
    ["curve", ["path of the dancers", "有人扶时的路线"]],
    ["contact", ["benches that touch", "相碰的板凳"]],
  ]);
  lab.update = () => {
    benches = benchesBetween(dragon, handlesAt(contact()?.time ?? time.value));
  };
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 25 }),
    (pane) => {
      pane.line(path, { colour: "curve" });
      /** @type {readonly number[]} */
      const pair = contact()?.benches ?? [];
      pane.benches(benches, (i) => (pair.includes(i) ? "contact" : headAndBodies(i)));
      for (const i of pair) {
        pane.dot([benches.poses.x[i], benches.poses.y[i]], { colour: "contact", radius: 5 });
      }
    },
  );
  lab.readout = () => {
    const found = contact();
    const t = (found?.time ?? time.value).toFixed(2);
    const off = offPath(march.chain(Number(t)).points, benches.handles);
    const far = off.filter((each) => each > 0.3).length;
    const [i, j] = found?.benches ?? [];
    const hit = found ? [` Benches ${i} and ${j} touch.`, `${i} 号和 ${j} 号板凳相碰。`] : ["", ""];
    return [
      `${t} s: ${far} of ${off.length} handles are not where dancers would have them.${hit[0]}`,
      `${t} s：${off.length} 个把手中有 ${far} 个不在有人扶时的位置上。${hit[1]}`,
    ];
  };
};

// Distances of handles from where they would be on the path.
/** @type {(path: Frame[], handles: Point[]) => number[]} */
const offPath = (path, handles) =>
  handles.map(([x, y], i) => Math.hypot(x - path[i][0], y - path[i][1]));
