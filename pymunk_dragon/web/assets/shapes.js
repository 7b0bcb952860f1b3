// Draws what Pymunk's debug drawing draws. Neighbours of one colour share a path,
// because drawing a path costs more than extending it.

const SHAPE_OUTLINE = 1; // pixels
const JOINT_WIDTH = 1.5; // pixels
const DOT_SIZE = 0.6; // radius of a dot over Pymunk's

// Add the outline of a convex polygon, a line or a point on the screen, at a distance around it.
/** @type {(path: Path2D, corners: Point[], distance: number) => void} */
function addOutline(path, corners, distance) {
  if (corners.length === 1) {
    path.moveTo(corners[0][0] + distance, corners[0][1]);
    path.arc(...corners[0], distance, 0, TURN);
    return;
  }
  if (distance <= 0) {
    corners.forEach(([x, y], i) => path[i ? "lineTo" : "moveTo"](x, y));
    path.closePath();
    return;
  }
  const area = corners.reduce((sum, [x, y], i) => {
    const [nextX, nextY] = corners[(i + 1) % corners.length];
    return sum + x * nextY - y * nextX;
  }, 0);
  const points = area < 0 ? [...corners].reverse() : corners;
  const headings = points.map(([x, y], i) => {
    const [nextX, nextY] = points[(i + 1) % points.length];
    return Math.atan2(nextY - y, nextX - x);
  });
  points.forEach(([x, y], i) => {
    const begin = (i ? headings[i - 1] : lastOf(headings)) - TURN / 4;
    const end = headings[i] - TURN / 4;
    if (!i) path.moveTo(x + distance * Math.cos(begin), y + distance * Math.sin(begin));
    // At a straight corner, rounding can give an angle just below a full circle.
    if ((((end - begin) % TURN) + TURN) % TURN < 0.75 * TURN) path.arc(x, y, distance, begin, end);
  });
  path.closePath();
}

/** @type {(view: View, shape: { points: Point[], radius: number }) => Path2D} */
function shapePath(view, { points, radius }) {
  const path = new Path2D();
  addOutline(
    path,
    points.map((point) => view.toScreen(...point)),
    radius * view.scale,
  );
  return path;
}

// Whether any of a call may be visible.
/** @type {(view: View, call: Shape) => boolean} */
function isCallVisible(view, { kind, points, radius }) {
  const reach = kind === "dot" ? 0 : radius;
  const [[x, y]] = points;
  let size = 0;
  for (const [px, py] of points) size = Math.max(size, Math.abs(px - x), Math.abs(py - y));
  return view.isVisible(x, y, reach + size);
}

/** @type {Layer<LivePicture>} */
function drawCalls({ context, view }, { calls }) {
  /** @type { { fill: string, outline?: string, fills: boolean, path: Path2D } | null} */
  let run = null;
  const finish = () => {
    if (!run) return;
    context.fillStyle = run.fill;
    context.strokeStyle = run.outline ?? run.fill;
    context.lineWidth = run.outline ? SHAPE_OUTLINE : JOINT_WIDTH;
    if (run.fills) context.fill(run.path);
    if (run.outline || !run.fills) context.stroke(run.path);
  };
  for (const call of calls) {
    if (!isCallVisible(view, call)) continue;
    const fills = call.kind !== "line";
    if (
      !run ||
      !call.opaque ||
      run.fill !== call.fill ||
      run.outline !== call.outline ||
      run.fills !== fills
    ) {
      finish();
      run = { fill: call.fill, outline: call.outline, fills, path: new Path2D() };
    }
    addCall(run.path, view, call);
  }
  finish();
}

/** @type {(path: Path2D, view: View, call: Call) => void} */
function addCall(path, view, { kind, points, radius, angle }) {
  const corners = points.map((point) => view.toScreen(...point));
  if (kind === "line") {
    corners.forEach((corner, i) => path[i ? "lineTo" : "moveTo"](...corner));
    return;
  }
  const distance = Math.max(radius * view.scale, kind === "segment" ? 0.5 : 0);
  addOutline(path, corners, kind === "dot" ? DOT_SIZE * radius : distance);
  if (kind !== "circle") return;
  // A line from the centre shows how a circle turns.
  const [[x, y]] = points;
  path.moveTo(...corners[0]);
  path.lineTo(...view.toScreen(x + radius * Math.cos(angle), y + radius * Math.sin(angle)));
}

/** @type {(obstacle: Obstacle) => Call} */
function obstacleCall({ shape, x, y, size }) {
  const half = size / 2;
  const round = shape === "round";
  /** @type {Point[]} */
  const square = [
    [x - half, y - half],
    [x + half, y - half],
    [x + half, y + half],
    [x - half, y + half],
  ];
  return {
    kind: round ? "circle" : "polygon",
    points: round ? [[x, y]] : square,
    radius: round ? half : 0,
    angle: 0,
    fill: STATIC_COLOUR,
    outline: OUTLINE_COLOUR,
    opaque: true,
    grip: 0,
  };
}
