// The size of the cells, and a bench to pick: which benches share a cell with it?
stages.grid = (lab) => {
  const contact = 412.473837; // s: the head meets bench 8
  const corner = 8.8; // m: upper left corner of the grid
  const cell = lab.slider(["size of a cell", "格子的边长"], {
    min: 0.1,
    max: 4,
    step: 0.05,
    value: 4,
    unit: "m",
  });
  const count = lab.slider(["benches", "板凳数"], { min: 16, max: 223, step: 1, value: 223 });
  const handles = new March().chain(contact).points;
  let picked = 8;
  /** @type {Benches<BenchSizes>} */
  let benches;
  /** @type {Grid} */
  let grid;
  /** @type {Filed} */
  let filed;
  /** @type {Set<number>} */
  let partners;

  lab.label = [
    "The dragon on a grid, and the benches that share a cell with one",
    "网格上的板凳龙，以及与一节板凳同在一格的板凳",
  ];
  lab.update = () => {
    benches = benchesBetween(
      makeDragon({ benches: count.value }),
      handles.slice(0, count.value + 1),
    );
    grid = { cell: cell.value, origin: [-corner, corner] };
    filed = gridPairs(benches, grid);
    picked = Math.min(picked, count.value - 1);
    partners = new Set(filed.pairs.filter((pair) => pair.includes(picked)).flat());
  };
  lab.pane(
    1,
    () => ({ x: 0, y: 0, size: 18 }),
    (pane) => {
      const side = cell.value;
      for (const [row, column] of benches.cells(picked, grid)) {
        const x = column * side - corner;
        const y = corner - row * side;
        pane.fill(
          [
            [x, y],
            [x + side, y],
            [x + side, y - side],
            [x, y - side],
          ],
          { colour: "head", alpha: 0.5 },
        );
      }
      for (let at = -corner - Math.ceil(6 / side) * side; at < 15; at += side) {
        pane.line(
          [
            [at, -15],
            [at, 15],
          ],
          { colour: "rule" },
        );
        pane.line(
          [
            [-15, -at],
            [15, -at],
          ],
          { colour: "rule" },
        );
      }
      pane.benches(benches, (i) => (i === picked ? "head" : partners.has(i) ? "contact" : "body"));
    },
  );
  lab.keep(
    "bench",
    () => picked,
    (given) => {
      picked = Math.max(Math.round(given), 0);
    },
  );
  lab.knob(["The bench that is picked: drag to another one", "选中的板凳：拖到另一节上"], {
    at: () => [benches.poses.x[picked], benches.poses.y[picked]],
    moved: (point, way) => {
      picked = way ? Math.max(picked + way, 0) : (benchAt(benches, point, Infinity) ?? picked);
    },
  });
  lab.readout = () => {
    const all = ((count.value - 1) * (count.value - 2)) / 2;
    const { pairs, entries } = filed;
    const own = Math.max(partners.size - 1, 0);
    const shared = pairs.length;
    return [
      `${shared} of ${all} pairs share a cell; ${entries} entries in cells. ` +
        `Bench ${picked}: ${own} to test.`,
      `${all} 对板凳中有 ${shared} 对同在一格；共登记 ${entries} 次。` +
        `${picked} 号板凳：要检测 ${own} 节。`,
    ];
  };
};
