// Draws what Pymunk's debug drawing draws.

const JOINT_WIDTH = 1.5; // pixels
const DOT_SIZE = 0.6; // radius of a dot over Pymunk's
// Outlines that share a path, because drawing a path costs more than extending it. Closing a part
// takes the longer the longer the path is; circles are not closed. What is filled has a path each:
// Chromium fills a circle alone in its path in less than half the time.
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

// Copies circles.
const discs = new Discs();

/** @type {Layer<LivePicture>} */
function drawCalls({ context, view }, { calls }) {
  const ratio = context.getTransform().a;
  const visible = calls.filter(({ points, reach }) =>
    view.isVisible(points[0][0], points[0][1], reach),
  );
  /** @type {(call: Call) => boolean} */
  const isDisc = ({ kind, radius, opaque }) =>
    kind === "circle" && opaque && discs.fits(context.canvas, radius * view.scale, ratio);
  /** @type {(one: Call, two: Call) => boolean} */
  const areAlike = (one, two) =>
    isDisc(one) ? isDisc(two) && one.outline === two.outline : !isDisc(two);
  for (const some of runsOf(visible, areAlike, () => Infinity)) {
    const copies = some.length >= LEAST_DISCS && isDisc(some[0]);
    if (copies) {
      const screen = some.map((call) => pixelsOf(view, call)[0]);
      discs.draw(context, ratio, view.scale, some, screen);
    }
    for (const run of runsOf(some, copies ? areAlike : sharesPaint, mostInPath)) {
      if (copies) strokeSpokes(context, view, run);
      else paintCalls(context, view, run);
    }
  }
}

/** @type {(call: Call) => number} */
const mostInPath = ({ kind }) => (kind === "circle" ? MOST_CIRCLES : MOST_OTHERS);

// Calls that follow each other: all are like the first one, and there are at most so many.
/**
 * @param {Call[]} calls
 * @param {(one: Call, two: Call) => boolean} areAlike
 * @param {(call: Call) => number} most
 */
function* runsOf(calls, areAlike, most) {
  /** @type {Call[]} */
  let run = [];
  for (const call of calls) {
    if (run.length && (run.length >= most(call) || !areAlike(run[0], call))) {
      yield run;
      run = [];
    }
    run.push(call);
  }
  if (run.length) yield run;
}

/** @type {(one: Call, two: Call) => boolean} */
function sharesPaint(one, two) {
  const alike = one.fill === two.fill && one.outline === two.outline;
  return two.opaque && alike && (one.kind === "line") === (two.kind === "line");
}

// Paint calls of the same colours: first what is filled, then all lines.
/** @type {(context: CanvasRenderingContext2D, view: View, calls: Call[]) => void} */
function paintCalls(context, view, calls) {
  const [{ kind, fill, outline }] = calls;
  const screen = calls.map((call) => pixelsOf(view, call));
  context.fillStyle = fill;
  context.strokeStyle = outline ?? fill;
  context.lineWidth = outline ? SHAPE_OUTLINE : JOINT_WIDTH;
  if (kind !== "line") {
    calls.forEach((call, k) => {
      context.beginPath();
      if (call.points.length > 1) addCall(context, view, call, screen[k]);
      else context.arc(screen[k][0][0], screen[k][0][1], radiusOf(view, call), 0, TURN);
      context.fill();
    });
    if (!outline) return;
  }
  context.beginPath();
  calls.forEach((call, k) => {
    addCall(context, view, call, screen[k]);
    if (call.kind === "circle") addSpoke(context, view, call, screen[k][0]);
  });
  context.lineCap = outline ? "butt" : "round";
  context.stroke();
  context.lineCap = "round";
}

// The points of a call on the screen, in an array that is kept.
/** @type {(view: View, call: Call) => Point[]} */
function pixelsOf(view, call) {
  const { points } = call;
  const screen = (call.screen ??= points.map(() => [0, 0]));
  for (let k = 0; k < points.length; k++) {
    screen[k][0] = (points[k][0] - view.x) * view.scale + view.width / 2;
    screen[k][1] = (view.y - points[k][1]) * view.up * view.scale + view.height / 2;
  }
  return screen;
}

/** @type {(view: View, call: Call) => number} */
function radiusOf(view, { kind, radius }) {
  if (kind === "dot") return DOT_SIZE * radius;
  return Math.max(radius * view.scale, kind === "segment" ? 0.5 : 0);
}

/** @type {(path: CanvasPath, view: View, call: Call, corners: Point[]) => void} */
function addCall(path, view, call, corners) {
  if (call.kind === "line") {
    corners.forEach((corner, i) => path[i ? "lineTo" : "moveTo"](...corner));
  } else addOutline(path, corners, radiusOf(view, call));
}

/** @type {(context: CanvasRenderingContext2D, view: View, calls: Call[]) => void} */
function strokeSpokes(context, view, calls) {
  context.strokeStyle = calls[0].outline ?? "";
  context.lineWidth = SHAPE_OUTLINE;
  context.lineCap = "butt";
  context.beginPath();
  for (const call of calls) addSpoke(context, view, call, pixelsOf(view, call)[0]);
  context.stroke();
  context.lineCap = "round";
}

// A line from the centre shows how a circle turns.
/** @type {(path: CanvasPath, view: View, call: Call, centre: Point) => void} */
function addSpoke(path, view, { radius, angle }, [px, py]) {
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
