// Drag and turn two benches: is there light between their shadows on any wall?
stages.sat = (lab) => {
  const near = 2.3, apart = 0.28, half = 2.2, farthest = 1.2, hole = 0.825; // m: walls from the centre, their halves; benches
  const count = lab.slider({ label: { en: "walls", zh: "墙的数目" }, min: 1, max: 5, step: 1, value: 4 });
  const poses = [[-0.8, -0.45, 0], [0.8, 0.45, Math.PI / 6]]; // x, y, angle
  const names = [{ en: "blue bench", zh: "蓝色板凳" }, { en: "amber bench", zh: "琥珀色板凳" }];
  let own = 0.8, benches, walls;

  // Where the shadows of both benches begin and end on a wall along an angle, and the light between them.
  const wall = (angle, side, distance) => {
    const along = [Math.cos(angle), Math.sin(angle)], out = [-side * along[1], side * along[0]];
    const shadows = [0, 1].map((each) => {
      const seen = benches.corners(each).map(([x, y]) => x * along[0] + y * along[1]);
      return [Math.min(...seen), Math.max(...seen)];
    });
    const [[a, b], [c, d]] = shadows, light = c > b ? [b, c] : a > d ? [d, a] : null;
    return { shadows, light, at: (t, away = distance) => [t * along[0] + away * out[0], t * along[1] + away * out[1]] };
  };

  lab.label = { en: "Two benches, and their shadows on walls along their sides", zh: "两节板凳，以及它们在与各边平行的墙上的影子" };
  lab.update = () => {
    benches = new Benches(makeDragon({ benches: 2, head: 2 * hole }), posesFrom(2, (i) => poses[i]));
    const [blue, amber] = poses.map((pose) => pose[2]), turn = Math.PI / 2;
    walls = [
      wall(blue, -1, near), wall(blue + turn, -1, near),
      wall(amber, 1, near + apart), wall(amber + turn, 1, near + apart), wall(own, 1, near + 2 * apart),
    ].slice(0, count.value);
  };
  lab.pane(1, () => ({ x: 0, y: 0, width: 7.2, height: 7.2 }), (pane) => {
    for (const { light, at } of walls) {
      if (light) pane.fill([at(light[0]), at(light[1]), at(light[1], -half), at(light[0], -half)], { colour: "head", alpha: 0.35 });
    }
    for (const { shadows, light, at } of walls) {
      pane.line([at(-half), at(half)], { colour: "curve", width: 2 });
      shadows.forEach(([a, b], i) => pane.line([at(a), at(b)], { colour: ["body", "head"][i], width: i === 0 ? 9 : 5 }));
      if (light) pane.line([at(light[0]), at(light[1])], { colour: "contact", width: 5 });
    }
    pane.benches(benches, { colour: (i) => ["body", "head"][i] });
  });
  const bounded = (value) => Math.min(Math.max(value, -farthest), farthest);
  for (const i of [0, 1]) {
    lab.knob({
      label: { en: `The ${names[i].en}: drag it`, zh: `拖动${names[i].zh}` },
      at: () => poses[i].slice(0, 2),
      moved: ([x, y]) => poses[i].splice(0, 2, bounded(x), bounded(y)),
    });
    lab.knob({
      label: { en: `The ${names[i].en}: turn it`, zh: `转动${names[i].zh}` },
      at: () => [poses[i][0] + hole * Math.cos(poses[i][2]), poses[i][1] + hole * Math.sin(poses[i][2])],
      moved: ([x, y]) => { poses[i][2] = Math.atan2(y - poses[i][1], x - poses[i][0]); },
    });
  }
  lab.knob({
    label: { en: "The fifth wall: drag it around", zh: "第五面墙：拖着它转" },
    at: () => (walls[4] ? walls[4].at(0) : [NaN, NaN]),
    moved: ([x, y]) => { own = Math.atan2(-x, y); },
  });
  lab.readout = () => {
    const lit = walls.filter(({ light }) => light), most = Math.max(...lit.map(({ light }) => light[1] - light[0])).toFixed(3);
    const distance = separation(benches, 0, 1), size = Math.abs(distance).toFixed(3);
    return {
      en: (lit.length ? `Light on ${lit.length} of ${count.value} walls, up to ${most} m wide. ` : `Light on none of ${count.value} walls. `)
        + (distance > 0 ? `The benches are ${size} m apart.` : `The benches overlap by ${size} m.`),
      zh: (lit.length ? `${count.value} 面墙中有 ${lit.length} 面透光，最宽 ${most} m。` : `${count.value} 面墙都不透光。`)
        + (distance > 0 ? `两节板凳相距 ${size} m。` : `两节板凳重叠 ${size} m。`),
    };
  };
};
