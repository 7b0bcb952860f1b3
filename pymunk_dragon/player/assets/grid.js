// The paper's grid for the search for contacts: its lines, the cells under which benches are filed, and their names.

// Pixels: smallest cell that is drawn, and cells that are large enough for a number at the side, and for a name.
const SMALLEST_CELL = 5, NUMBERED_CELL = 22, NAMED_CELL = 120;
// How much of the grid's colour is laid over the ground for a cell that benches are filed under, and for a line, as in
// the films.
const FILED_TINT = 0.1, LINE_TINT = 0.28;
// Pixels from the sides to the middle of their numbers, and from the top to the first one at the left.
const FROM_LEFT = 14, FROM_TOP = 10, FIRST_ROW = 24;

function drawGrid(painter, benches, seen) {
  const { context, colours, view, told } = painter;
  const { cell, origin } = told.grid;
  const size = cell * view.scale;
  if (size < SMALLEST_CELL) return;
  const corner = (row, column) => view.toScreen(origin[0] + column * cell, origin[1] - row * cell);
  const filed = new Path2D();
  for (const i of seen) {
    for (const [row, column] of benches.cells(i, told.grid)) filed.rect(...corner(row, column), size, size);
  }
  context.fillStyle = context.strokeStyle = colours.grid;
  context.globalAlpha = FILED_TINT;
  context.fill(filed);
  const [west, north] = view.toFloor(0, 0), [east, south] = view.toFloor(view.width, view.height);
  const lines = new Path2D();
  for (const row of numbersBetween((origin[1] - north) / cell, (origin[1] - south) / cell)) {
    const py = corner(row, 0)[1];
    lines.moveTo(0, py);
    lines.lineTo(view.width, py);
  }
  for (const column of numbersBetween((west - origin[0]) / cell, (east - origin[0]) / cell)) {
    const px = corner(0, column)[0];
    lines.moveTo(px, 0);
    lines.lineTo(px, view.height);
  }
  context.lineWidth = 1;
  context.globalAlpha = LINE_TINT;
  context.stroke(lines);
  context.globalAlpha = 1;
}

// The grid's numbers, on top of everything: rows along the left side, columns along the top, and in large cells both.
function drawGridNames(painter) {
  const { context, view, told } = painter;
  const { cell, origin } = told.grid;
  const size = cell * view.scale;
  if (size < NUMBERED_CELL) return;
  const [west, north] = view.toFloor(0, 0), [east, south] = view.toFloor(view.width, view.height);
  const rows = numbersBetween((origin[1] - north) / cell, (origin[1] - south) / cell);
  const columns = numbersBetween((west - origin[0]) / cell, (east - origin[0]) / cell);
  const middle = (row, column) => view.toScreen(origin[0] + (column + 0.5) * cell, origin[1] - (row + 0.5) * cell);
  context.font = `11px ${painter.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const row of rows) if (middle(row, 0)[1] > FIRST_ROW) painter.write(signed(row), FROM_LEFT, middle(row, 0)[1]);
  for (const column of columns) painter.write(signed(column), middle(0, column)[0], FROM_TOP);
  if (size < NAMED_CELL) return;
  for (const row of rows) {
    for (const column of columns) {
      const [px, py] = middle(row, column);
      painter.write(`${signed(row)}, ${signed(column)}`, px, py);
    }
  }
}

// The whole numbers from that of `from` to that of `to`.
function numbersBetween(from, to) {
  const first = Math.floor(from);
  return Array.from({ length: Math.floor(to) - first + 1 }, (_, i) => first + i);
}

const signed = (number) => String(number).replace("-", "−");
