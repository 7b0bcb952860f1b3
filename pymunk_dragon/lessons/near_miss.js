// Time, zoom, and decimals of the coordinates: does the head hit bench 11?
stages["near-miss"] = (lab) => {
  const begin = 405; // s
  const end = 412.6; // s
  const exact = 6; // decimals from which on coordinates are not cut
  const time = lab.slider(["time", "时间"], {
    min: begin,
    max: end,
    step: 0.01,
    value: begin,
    unit: "s",
    digits: 2,
    play: () => 0.5,
  });
  const decimals = lab.slider(["coordinates", "坐标"], {
    min: 1,
    max: exact,
    step: 1,
    value: exact,
    show: (n) =>
      lab.say(
        n === exact
          ? ["exact", "精确"]
          : [`cut to ${10 ** (3 - n)} mm`, `截到 ${10 ** (3 - n)} mm`],
      ),
  });
  const zoom = lab.slider(["zoom", "放大"], {
    min: 0,
    max: 3.2,
    step: 0.1,
    value: 0,
    show: magnification,
  });
  const march = new March({ benches: 60 });
  /** @type {number} */
  let cutTo;
  /** @type {number} */
  let scale;
  /** @type {Point[]} */
  let gaps;

  /** @type {(value: number) => number} */
  const cut = (value) => (cutTo === exact ? value : Math.trunc(value * scale) / scale);
  /** @type {(t: number, handles?: number) => Benches<BenchSizes>} */
  const benchesAt = (t, handles) =>
    benchesBetween(
      march.dragon,
      march.chain(t, handles).points.map((point) => point.map(cut)),
    );
  const upToNow = () => gaps.filter(([t]) => t < now.seen + 1e-9);
  /** @type {() => ChartView} */
  const view = () => ({
    across: [begin, end],
    up: [-8, 30],
    name: ["gap of the head (mm) by the time (s)", "龙头的空隙 (mm) 随时间 (s) 的变化"],
  });
  const now = gapPanes(lab, {
    time,
    size: () => 5 / 10 ** zoom.value,
    benchesAt,
    view,
    draw: (pane) => {
      pane.line(upToNow(), { colour: "body", width: 2 });
      for (const hit of upToNow().filter(([, gap]) => gap <= 0)) {
        pane.dot(hit, { colour: "contact", radius: 3 });
      }
    },
  });
  lab.label = [
    "The head and the benches that it passes; below, its gap",
    "龙头和它经过的板凳；下方是空隙",
  ];
  lab.legend([
    ["head", ["head", "龙头"]],
    ["body", ["gap above 0", "空隙大于 0"]],
    ["contact", ["smallest gap; overlap", "最小的空隙；重叠"]],
  ]);
  lab.update = () => {
    if (cutTo !== decimals.value) {
      cutTo = decimals.value;
      scale = 10 ** cutTo;
      gaps = range(begin, end, 760).map((t) => [t, 1000 * nearestToHead(benchesAt(t, 14)).gap]);
    }
    now.update();
  };
  lab.readout = () => {
    const { bench, gap } = now;
    const size = Math.abs(1000 * gap).toFixed(3);
    const t = time.value.toFixed(2);
    const first = upToNow()
      .find((each) => each[1] <= 0)?.[0]
      .toFixed(2);
    const [english, chinese] =
      gap > 0
        ? [`the gap to bench ${bench} is ${size} mm`, `与 ${bench} 号板凳的空隙为 ${size} mm`]
        : [
            `the head overlaps bench ${bench} by ${size} mm`,
            `龙头与 ${bench} 号板凳重叠 ${size} mm`,
          ];
    const hit = first ? [`the first at ${first} s`, `第一次在 ${first} s`] : ["none", "无"];
    return [
      `${t} s: ${english}. Overlaps until now: ${hit[0]}.`,
      `${t} s：${chinese}。至此的重叠：${hit[1]}。`,
    ];
  };
};
