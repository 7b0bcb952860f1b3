// Draws what Pymunk's debug drawing draws.

const SHAPE_OUTLINE = 1; // pixels
const JOINT_WIDTH = 1.5; // pixels
const DOT_SIZE = 0.6; // radius of a dot over Pymunk's
// Outlines that share a path, because drawing a path costs more than extending it. Closing a part
// takes the longer the longer the path is; circles are not closed.
const MOST_CIRCLES = 1000;
const MOST_OTHERS = 50;

// Add the outline of a convex polygon, a line or a point on the screen, at a distance around it.
/** @type {(path: CanvasPath, corners: Point[], distance: number) => void} */
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

/** @type {Layer<LivePicture>} */
function drawCalls({ context, view }, { calls }) {
  /** @type {Call[]} */
  let run = [];
  for (const call of calls) {
    const [[x, y]] = call.points;
    if (!view.isVisible(x, y, call.reach)) continue;
    const most = call.kind === "circle" ? MOST_CIRCLES : MOST_OTHERS;
    if (run.length >= most || !(run.length && sharesPaint(run[0], call))) {
      paintCalls(context, view, run);
      run = [];
    }
    run.push(call);
  }
  paintCalls(context, view, run);
}

/** @type {(one: Call, two: Call) => boolean} */
function sharesPaint(one, two) {
  const alike = one.fill === two.fill && one.outline === two.outline;
  return two.opaque && alike && (one.kind === "line") === (two.kind === "line");
}

// Paint calls of the same colours: first what is filled, where the browser is fast at convex shapes
// one by one, and at circles together, then all lines.
/** @type {(context: CanvasRenderingContext2D, view: View, calls: Call[]) => void} */
function paintCalls(context, view, calls) {
  if (!calls.length) return;
  const [{ kind, fill, outline }] = calls;
  const screen = calls.map(({ points }) => points.map((point) => view.toScreen(...point)));
  context.fillStyle = fill;
  context.strokeStyle = outline ?? fill;
  context.lineWidth = outline ? SHAPE_OUTLINE : JOINT_WIDTH;
  if (kind !== "line") {
    const discs = new Path2D();
    calls.forEach((call, k) => {
      const isRound = call.points.length === 1;
      if (!isRound) context.beginPath();
      addCall(isRound ? discs : context, view, call, screen[k]);
      if (!isRound) context.fill();
    });
    context.fill(discs);
    if (!outline) return;
  }
  context.beginPath();
  calls.forEach((call, k) => {
    addCall(context, view, call, screen[k]);
    if (call.kind === "circle") addSpoke(context, view, call, screen[k]);
  });
  context.lineCap = outline ? "butt" : "round";
  context.stroke();
  context.lineCap = "round";
}

/** @type {(path: CanvasPath, view: View, call: Call, corners: Point[]) => void} */
function addCall(path, view, { kind, radius }, corners) {
  if (kind === "line") {
    corners.forEach((corner, i) => path[i ? "lineTo" : "moveTo"](...corner));
    return;
  }
  const distance = Math.max(radius * view.scale, kind === "segment" ? 0.5 : 0);
  addOutline(path, corners, kind === "dot" ? DOT_SIZE * radius : distance);
}

// A line from the centre shows how a circle turns.
/** @type {(path: CanvasPath, view: View, call: Call, centre: Point[]) => void} */
function addSpoke(path, view, { radius, angle }, [[px, py]]) {
  const length = radius * view.scale;
  path.moveTo(px, py);
  path.lineTo(px + length * Math.cos(angle), py - view.up * length * Math.sin(angle));
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
  const place = {
    kind: round ? "circle" : "polygon",
    points: round ? [/** @type {Point} */ ([x, y])] : square,
    radius: round ? half : 0,
  };
  return {
    ...place,
    reach: reachOf(place),
    angle: 0,
    fill: STATIC_COLOUR,
    outline: OUTLINE_COLOUR,
    opaque: true,
    grip: 0,
  };
}
