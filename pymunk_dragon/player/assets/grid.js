// The paper's grid for the search for contacts: its lines, the cells that benches cover, and their names.

const SMALLEST_CELL = 5; // pixels: smallest cell that is drawn
const NUMBERED_CELL = 22; // pixels: smallest cell with numbers at the sides of the canvas
const NAMED_CELL = 120; // pixels: smallest cell with a name
const CELL_OPACITY = 0.1; // of covered cells, as in the films
const LINE_OPACITY = 0.28; // of lines, as in the films
const FROM_LEFT = 14; // pixels: distance of row numbers from the left side
const FROM_TOP = 10; // pixels: distance of column numbers from the top
const FIRST_ROW = 24; // pixels: least distance of row numbers from the top

function drawGrid(painter, benches, visible) {
  const { context, colours, view, payload } = painter;
  const { cell, origin } = payload.grid;
  const size = cell * view.scale;
  if (size < SMALLEST_CELL) return;
  const corner = (row, column) => view.toScreen(origin[0] + column * cell, origin[1] - row * cell);
  const covered = new Path2D();
  for (const i of visible) {
    for (const [row, column] of benches.cells(i, payload.grid)) covered.rect(...corner(row, column), size, size);
  }
  context.fillStyle = context.strokeStyle = colours.grid;
  context.globalAlpha = CELL_OPACITY;
  context.fill(covered);
  const [west, north] = view.toWorld(0, 0), [east, south] = view.toWorld(view.width, view.height);
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
  context.globalAlpha = LINE_OPACITY;
  context.stroke(lines);
  context.globalAlpha = 1;
}

// Numbers of the grid, above everything else: rows at the left, columns at the top, both in large cells.
function drawGridNames(painter) {
  const { context, view, payload } = painter;
  const { cell, origin } = payload.grid;
  const size = cell * view.scale;
  if (size < NUMBERED_CELL) return;
  const [west, north] = view.toWorld(0, 0), [east, south] = view.toWorld(view.width, view.height);
  const rows = numbersBetween((origin[1] - north) / cell, (origin[1] - south) / cell);
  const columns = numbersBetween((west - origin[0]) / cell, (east - origin[0]) / cell);
  const middle = (row, column) => view.toScreen(origin[0] + (column + 0.5) * cell, origin[1] - (row + 0.5) * cell);
  context.font = `11px ${painter.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const row of rows) if (middle(row, 0)[1] > FIRST_ROW) painter.drawText(signed(row), FROM_LEFT, middle(row, 0)[1]);
  for (const column of columns) painter.drawText(signed(column), middle(0, column)[0], FROM_TOP);
  if (size < NAMED_CELL) return;
  for (const row of rows) {
    for (const column of columns) {
      const [px, py] = middle(row, column);
      painter.drawText(`${signed(row)}, ${signed(column)}`, px, py);
    }
  }
}

// Integers from floor(from) to floor(to).
function numbersBetween(from, to) {
  const first = Math.floor(from);
  return Array.from({ length: Math.floor(to) - first + 1 }, (_, i) => first + i);
}
