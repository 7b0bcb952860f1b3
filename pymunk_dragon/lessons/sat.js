// Drag and turn two benches: is there light between their shadows on any wall?
stages.sat = (lab) => {
  const near = 2.3; // m from the centre to the nearest wall
  const apart = 0.28; // m between parallel walls
  const half = 2.2; // m: half the length of a wall
  const farthest = 1.2; // m: most from the centre to that of a bench
  const hole = 0.825; // m from the centre of a bench to its holes
  const count = lab.slider(["walls", "墙的面数"], { min: 1, max: 5, step: 1, value: 1 });
  const poses = [
    [-0.8, -0.45, 0],
    [0.8, 0.45, Math.PI / 6],
  ]; // x, y, angle
  let own = -0.8;
  /** @type {Benches<BenchSizes>} */
  let benches;
  /** @type {Wall[]} */
  let walls;

  // A wall along an angle, on its left or right side: the shadows of both benches on it,
  // and the light between them.
  /** @type {(angle: number, side: number, distance: number) => Wall} */
  const wall = (angle, side, distance) => {
    const cos = Math.cos(angle);
    const sin = Math.sin(angle);
    const shadows = [0, 1].map((i) => {
      const seen = benches.corners(i).map(([x, y]) => x * cos + y * sin);
      return [Math.min(...seen), Math.max(...seen)];
    });
    const [[a, b], [c, d]] = shadows;
    const light = c > b ? [b, c] : a > d ? [d, a] : undefined;
    /** @type {(along: number, away?: number) => Point} */
    const at = (along, away = distance) => [
      along * cos - side * away * sin,
      along * sin + side * away * cos,
    ];
    return { shadows, light, at };
  };

  lab.label = [
    "Two benches, and their shadows on walls along their sides",
    "两节板凳，以及它们在与各边平行的墙上的影子",
  ];
  lab.update = () => {
    benches = new Benches(
      makeDragon({ benches: 2, head: 2 * hole }),
      posesFrom(2, (i) => poses[i]),
    );
    const [blue, amber] = poses.map((pose) => pose[2]);
    const turn = Math.PI / 2;
    walls = [
      wall(blue, -1, near),
      wall(blue + turn, -1, near),
      wall(amber, 1, near + apart),
      wall(amber + turn, 1, near + apart),
      wall(own, 1, near + 2 * apart),
    ].slice(0, count.value);
  };
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 7.2 }),
    (pane) => {
      for (const { light: [from, to] = [], at } of walls) {
        pane.fill([at(from), at(to), at(to, -half), at(from, -half)], {
          colour: "head",
          alpha: 0.35,
        });
      }
      for (const { shadows, light, at } of walls) {
        pane.line([at(-half), at(half)], { colour: "curve", width: 2 });
        shadows.forEach(([a, b], i) =>
          pane.line([at(a), at(b)], { colour: ["body", "head"][i], width: [9, 5][i] }),
        );
        if (light) {
          pane.line(
            light.map((each) => at(each)),
            { colour: "contact", width: 5 },
          );
        }
      }
      pane.benches(benches, (i) => ["body", "head"][i]);
    },
  );
  poses.forEach((pose, i) => {
    /** @type {(given: Numbers) => void} */
    const put = ([x, y, angle]) =>
      pose.splice(0, 3, ...[x, y].map((each) => bounded(each, -farthest, farthest)), angle);
    lab.keep(["blue", "amber"][i], () => [...pose], put);
    const [english, chinese] = [
      ["blue", "蓝"],
      ["amber", "琥珀"],
    ][i];
    lab.knob([`The ${english} bench: drag it`, `拖动${chinese}色板凳`], {
      at: () => pose.slice(0, 2),
      moved: (point) =>
        pose.splice(0, 2, ...point.map((each) => bounded(each, -farthest, farthest))),
    });
    lab.knob([`The ${english} bench: turn it`, `转动${chinese}色板凳`], {
      at: () => [pose[0] + hole * Math.cos(pose[2]), pose[1] + hole * Math.sin(pose[2])],
      moved: ([x, y]) => {
        pose[2] = Math.atan2(y - pose[1], x - pose[0]);
      },
    });
  });
  lab.keep(
    "fifth wall",
    () => own,
    (angle) => {
      own = angle;
    },
  );
  lab.knob(["The fifth wall: drag it around", "第五面墙：拖着它转"], {
    step: 0.2,
    at: () => walls[4]?.at(0) ?? [NaN, NaN],
    moved: ([x, y]) => {
      own = Math.atan2(-x, y);
    },
  });
  lab.readout = () => {
    const lights = walls.flatMap(({ light }) => (light ? [light[1] - light[0]] : []));
    const n = lights.length;
    const all = count.value;
    const distance = benches.gap(0, 1).gap;
    const size = Math.abs(distance).toFixed(3);
    const most = Math.max(...lights).toFixed(3);
    const lit =
      n === 0
        ? [`Walls with light: none of ${all}.`, `${all} 面墙上都没有光。`]
        : [
            `Walls with light: ${n} of ${all}, up to ${most} m wide.`,
            `${all} 面墙中 ${n} 面有光，最宽 ${most} m。`,
          ];
    const turned = Math.round(((poses[1][2] - poses[0][2]) / Math.PI) * 180 + 720) % 180;
    const verdict =
      distance > 0
        ? [`are ${size} m apart`, `相距 ${size} m`]
        : [`overlap by ${size} m`, `重叠 ${size} m`];
    return [
      `${lit[0]} The benches, at ${turned}°, ${verdict[0]}.`,
      `${lit[1]}两节板凳成 ${turned}°，${verdict[1]}。`,
    ];
  };
};
