// Draws a moment of a run with its overlays, and the paper's grid for the search for contacts:
// its lines, and the cells that benches cover.

const SMALLEST_CELL = 5; // pixels: smallest cell that is drawn
const CELL_OPACITY = 0.1; // of covered cells, as in the films
const LINE_OPACITY = 0.28; // of lines, as in the films

/**
 * @type {(
 *   painter: RunPainter,
 *   benches: Benches<MovingBenches>,
 *   visible: number[],
 *   grid: Grid,
 * ) => void}
 */
function drawGrid(painter, benches, visible, grid) {
  const { context, colours, view } = painter;
  const { cell, origin } = grid;
  const size = cell * view.scale;
  if (size < SMALLEST_CELL) return;
  /** @type {(row: number, column: number) => Point} */
  const corner = (row, column) => view.toScreen(origin[0] + column * cell, origin[1] - row * cell);
  const covered = new Path2D();
  for (const i of visible) {
    for (const [row, column] of benches.cells(i, grid)) {
      covered.rect(...corner(row, column), size, size);
    }
  }
  context.fillStyle = context.strokeStyle = colours.grid;
  context.globalAlpha = CELL_OPACITY;
  context.fill(covered);
  const [west, north] = view.toWorld(0, 0);
  const lines = new Path2D();
  for (
    let [, py] = corner(Math.ceil((origin[1] - north) / cell), 0);
    py <= view.height;
    py += size
  ) {
    lines.moveTo(0, py);
    lines.lineTo(view.width, py);
  }
  for (let [px] = corner(0, Math.ceil((west - origin[0]) / cell)); px <= view.width; px += size) {
    lines.moveTo(px, 0);
    lines.lineTo(px, view.height);
  }
  context.lineWidth = 1;
  context.globalAlpha = LINE_OPACITY;
  context.stroke(lines);
  context.globalAlpha = 1;
}

/** @extends {Painter<Motion>} */
class RunPainter extends Painter {
  // Draw `benches` at `time` with the overlays in `show` and the bench `pointed` highlighted. The
  // exact benches are drawn at their distances from these times `magnification`.
  /** @type {(picture: {
   *   time: number, benches: Benches<Motion>, show: Record<string, boolean>,
   *   pointed: number | null, exact: Exact | undefined, magnification: number
   * }) => void} */
  draw({ time, benches, show, pointed, exact, magnification }) {
    this.clear();
    const visible = this.visible(benches);
    const touching = this.motion.touchingAt(time);
    const inContact = new Set(touching.flatMap(({ benches: two }) => two));
    const { grid } = this.payload;
    if (show.grid && grid) drawGrid(this, benches, visible, grid);
    if (show.curve) this.drawCurve();
    this.drawBenches(benches, visible, inContact);
    if (pointed !== null) this.drawPointed(benches, pointed, inContact);
    const ghosts = show.exact && exact?.posesBeside(benches, time, magnification);
    if (ghosts) drawGhosts(this, new Benches(this.motion, ghosts), visible);
    if (show.handles) drawHandles(this, benches, visible);
    if (show.velocities) drawVelocities(this, benches, visible);
    if (show.labels) drawNumbers(this, benches, visible, inContact);
    if (show.contacts) drawContacts(this, time, benches, touching);
  }
}
