// The size of the cells, and a bench to pick: which benches share a cell with it?
stages.grid = (lab) => {
  const contact = 412.473837; // s: the head meets bench 8
  const cell = lab.slider({ label: { en: "side of a cell", zh: "格子的边长" }, unit: "m", min: 0.1, max: 4, step: 0.05, value: 0.55 });
  const count = lab.slider({ label: { en: "benches", zh: "板凳数" }, min: 16, max: 223, step: 1, value: 223 });
  const spiral = new Spiral(0.55), head = spiral.atAngle(16 * ROUND) + contact;
  const handles = chainAt(spiral, makeDragon(), head).points;
  let picked = 8, benches, filed, grid, partners;

  lab.label = { en: "The dragon on a grid, the cells of one bench, and the benches in these cells", zh: "网格上的板凳龙，一节板凳所在的格子，以及同在这些格子里的板凳" };
  lab.update = () => {
    benches = benchesBetween(makeDragon({ benches: count.value }), handles.slice(0, count.value + 1));
    grid = { cell: cell.value, origin: [-8.8, 8.8] };
    filed = gridPairs(benches, grid);
    picked = Math.min(picked, count.value - 1);
    partners = new Set(filed.pairs.filter((pair) => pair.includes(picked)).flat());
  };
  lab.pane(1, () => ({ x: 0, y: 0, width: 18, height: 18 }), (pane) => {
    const [left, top] = grid.origin, side = grid.cell;
    for (const [row, column] of benches.cells(picked, grid)) {
      const [x, y] = [left + column * side, top - row * side];
      pane.fill([[x, y], [x + side, y], [x + side, y - side], [x, y - side]], { colour: "head", alpha: 0.5 });
    }
    for (let at = -8.8 - Math.ceil(8 / side) * side; at < 18; at += side) {
      pane.line([[at, -18], [at, 18]], { colour: "rule" });
      pane.line([[-18, -at], [18, -at]], { colour: "rule" });
    }
    pane.benches(benches, { colour: (i) => (i === picked ? "head" : partners.has(i) ? "contact" : "body") });
  });
  lab.knob({
    label: { en: "The bench that is picked: drag to another one", zh: "选中的板凳：拖到另一节上" },
    at: () => [benches.poses.x[picked], benches.poses.y[picked]],
    moved: (point, key) => {
      picked = key ? Math.max(picked + key[0] + key[1], 0) : benches.at(point, Infinity);
    },
  });
  lab.readout = () => {
    const all = (count.value - 1) * (count.value - 2) / 2, mine = Math.max(partners.size - 1, 0);
    return {
      en: `${filed.pairs.length} of ${all} pairs share a cell; ${filed.entries} entries in cells. Bench ${picked}: ${mine} to test.`,
      zh: `${all} 对板凳中有 ${filed.pairs.length} 对同在一格；共登记 ${filed.entries} 次。${picked} 号板凳：要检测 ${mine} 节。`,
    };
  };
};
