// Overlays of a dragon: handles, velocities, numbers, contacts, near misses, exact benches, grid.

const SMALLEST_HANDLE = 2.2; // pixels: least radius of a handle
const HANDLE_SIZE = 0.8; // radius of a handle over the diameter of a hole
const ARROW = 0.5; // m: length of an arrow per m/s, as in the films
const SHORTEST_ARROW = 2; // pixels
const LONGEST_HEAD = 7; // pixels: longest head of an arrow
const SHAFT = 0.1; // width of an arrow's shaft over its length at 1 m/s
const THICKEST_SHAFT = 2; // pixels
const RIM = 0.9; // pixels: rim around arrows
const NUMBERED_BENCH = 10; // pixels: least width of a bench with its number inside
const NUMBER_EVERY = 25; // benches from one number to the next in a distant view
const NUMBER_SIZE = 28; // pixels: room for a number in a distant view
const RING = 9; // pixels: radius of the ring around a contact
const LABEL_OFFSET = 14; // pixels: distance of a label from the centre of its ring
const ZOOM_BUTTONS = 52; // pixels: width of the buttons at the right
const NEAR_MISS_SHOWN = 1.5; // s: a near miss is shown this long before and after its time
const GHOST_WIDTH = 1.5; // pixels: width of the lines
const GHOST_SHARE = 0.16; // largest width of the lines over that of a bench
const THINNEST_GHOST = 0.75; // pixels
const GHOST_SHOWN = 0.75; // pixels: least error that is visible
const SMALLEST_CELL = 5; // pixels: smallest cell of the grid that is drawn
const CELL_OPACITY = 0.1; // of covered cells, as in the films
const LINE_OPACITY = 0.28; // of the grid's lines, as in the films
const RIMMED_BENCH = 10; // pixels: width of a bench from which on the lines have a rim

/** @type {Layer<Picture>} */
function drawHandles(painter, { benches, show }, visible) {
  if (!show.handles) return;
  const { context, colours, view } = painter;
  const radius = Math.max(SMALLEST_HANDLE, HANDLE_SIZE * painter.model.hole * view.scale);
  const path = painter.drawHoles(benches, visible, radius, colours.background);
  strokeOnce(context, path, colours.text, Math.min(1.25, 0.4 * radius));
}

/** @type {Layer<RunPicture>} */
function drawVelocities(painter, { benches, velocities }, visible) {
  if (!velocities) return;
  const { context, colours, view } = painter;
  const path = new Path2D();
  for (const handle of new Set(visible.flatMap((i) => [i, i + 1]))) {
    const [along, up] = velocities[handle].map((each) => ARROW * each * view.scale);
    if (Math.hypot(along, up) < SHORTEST_ARROW) continue;
    addArrow(path, view.toScreen(...benches.handles[handle]), along, -view.up * up);
  }
  const width = Math.min(THICKEST_SHAFT, SHAFT * ARROW * view.scale);
  strokeTwice(context, path, colours.background, colours.motion, width, RIM);
}

// An arrow from a pixel along a vector in pixels.
/** @type {(path: Path2D, from: Point, dx: number, dy: number) => void} */
function addArrow(path, [px, py], dx, dy) {
  const length = Math.hypot(dx, dy);
  const head = Math.min(LONGEST_HEAD, 0.5 * length);
  const half = 0.45 * head;
  const qx = px + dx;
  const qy = py + dy;
  const ux = dx / length;
  const uy = dy / length;
  path.moveTo(px, py);
  path.lineTo(qx, qy);
  path.moveTo(qx - head * ux - half * uy, qy - head * uy + half * ux);
  path.lineTo(qx, qy);
  path.lineTo(qx - head * ux + half * uy, qy - head * uy - half * ux);
}

// Numbers in the benches.
/** @type {Layer<Picture>} */
function drawNumbers(painter, { benches, inContact, show }, visible) {
  if (!show.labels) return;
  const { context, colours, model, view } = painter;
  const { x, y, angle } = benches.poses;
  const thickness = model.narrowest * view.scale;
  if (thickness < NUMBERED_BENCH) {
    painter.setFont("600 12px", "center", "middle");
    /** @type {Point[]} */
    const labelled = [];
    for (const i of visible.toReversed()) {
      if (i % NUMBER_EVERY && i !== model.benches - 1 && !inContact.has(i)) continue;
      const [px, py] = view.toScreen(x[i], y[i]);
      if (
        labelled.some(
          ([qx, qy]) => Math.abs(px - qx) < NUMBER_SIZE && Math.abs(py - qy) < NUMBER_SIZE / 2,
        )
      ) {
        continue;
      }
      labelled.push([px, py]);
      painter.drawText(String(i), px, py);
    }
    return;
  }
  painter.setFont(`${Math.min(0.72 * thickness, 16)}px`, "center", "middle");
  const upright = context.getTransform();
  for (const i of visible) {
    const [px, py] = view.toScreen(x[i], y[i]);
    // Along the bench, upright.
    let turn = -angle[i] - Math.PI * Math.round(-angle[i] / Math.PI);
    if (turn <= -Math.PI / 2) turn += Math.PI;
    context.translate(px, py);
    context.rotate(turn);
    context.fillStyle =
      inContact.has(i) || i === model.benches - 1 ? colours.background : colours.ink;
    context.fillText(String(i), 0, 0.04 * thickness);
    context.setTransform(upright);
  }
}

// A ring at each contact, and each near miss about its time.
/** @type {Layer<RunPicture>} */
function drawContacts(painter, { time, benches, pairs, show }) {
  if (!show.contacts) return;
  const { view } = painter;
  for (const two of pairs) {
    drawRing(painter, view.toScreen(...benches.gap(...two).ends[0]));
  }
  for (const miss of painter.model.nearMisses) {
    if (Math.abs(miss.time - time) > NEAR_MISS_SHOWN) continue;
    const { ends } = benches.gap(...miss.benches);
    const [one, two] = ends.map((end) => view.toScreen(...end));
    const middle = [(one[0] + two[0]) / 2, (one[1] + two[1]) / 2];
    // The ring encloses both ends of the gap.
    drawRing(painter, middle, Math.hypot(one[0] - two[0], one[1] - two[1]) / 2);
    const label = localized("{gap} at {time} s", {
      gap: formatLength(miss.gap, 0),
      time: miss.time.toFixed(2),
    });
    drawLabel(painter, label, middle[0], middle[1]);
  }
}

// Text beside a point: at the right, at the left if there is no room,
// and otherwise as far to the right as there is.
/** @type {(painter: Painter, text: string, px: number, py: number) => void} */
function drawLabel(painter, text, px, py) {
  const { context, view } = painter;
  painter.setFont("600 13px", "left", "middle");
  const { width } = context.measureText(text);
  const rightmost = view.width - ZOOM_BUTTONS - width;
  const beside = [px + LABEL_OFFSET, px - LABEL_OFFSET - width].find(
    (left) => left > 0 && left <= rightmost,
  );
  painter.drawText(text, beside ?? Math.max(0, rightmost), py - LABEL_OFFSET);
}

/** @type {(painter: Painter, pixel: Numbers, inner?: number) => void} */
function drawRing({ context, colours }, [px, py], inner = 0) {
  const path = new Path2D();
  path.arc(px, py, Math.max(RING, 1.6 * inner), 0, TURN);
  strokeTwice(context, path, colours.background, colours.force, 2, 1.5);
}

// Outlines of exact benches, on top of the others: of all, or of those whose errors are visible.
/** @type {Layer<Picture>} */
function drawGhosts(painter, { ghosts }) {
  if (!ghosts) return;
  const { benches, errors } = ghosts;
  const { context, colours, view, model } = painter;
  const least = GHOST_SHOWN / view.scale;
  const path = new Path2D();
  for (const i of painter.visible(benches)) {
    if (!errors || errors[i] >= least) painter.outline(path, benches, i);
  }
  const bench = model.narrowest * view.scale;
  const width = Math.min(GHOST_WIDTH, Math.max(THINNEST_GHOST, GHOST_SHARE * bench));
  if (bench >= RIMMED_BENCH) strokeTwice(context, path, colours.background, colours.motion, width);
  else strokeOnce(context, path, colours.motion, width);
}

// The paper's grid for the search for contacts: its lines, and the cells that benches cover.
/** @type {Layer<Picture>} */
function drawGrid(painter, { benches, show }, visible) {
  const { context, colours, view, model } = painter;
  const { grid } = model;
  if (!show.grid || !grid) return;
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
