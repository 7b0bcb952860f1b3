// Draws bodies as filled shapes.

const SHAPE_OUTLINE = 1; // pixels
const OUTLINE_SHADE = 0.45; // weight of the text's colour in outlines
const CROSS = 5; // pixels: half the size of the cross at a centre of mass

// The path of a shape at the pose of body `i`; -1 for the world.
function shapePath(view, shape, poses, i) {
  const path = new Path2D();
  const at = (u, v) => view.toScreen(...placed(poses, i, [u, v]));
  if (shape.circle) {
    const [u, v, radius] = shape.circle;
    path.arc(...at(u, v), radius * view.scale, 0, TURN);
  } else if (shape.segment) {
    const [au, av, bu, bv] = shape.segment;
    path.moveTo(...at(au, av));
    path.lineTo(...at(bu, bv));
  } else {
    for (const corner of cornersOf(shape)) path.lineTo(...at(...corner));
    path.closePath();
  }
  return path;
}

function drawShape({ context, view, colours }, shape, type, poses, i) {
  const path = shapePath(view, shape, poses, i);
  const colour = shapeColour(shape, type);
  const rim = mixed(TYPE_COLOURS[type], colours.type, OUTLINE_SHADE);
  // The rounding of a polygon and the body of a segment are thick lines.
  const radius = shape.circle ? 0 : shape.segment ? shape.segment[4] : shape.radius ?? 0;
  const width = Math.max(2 * radius * view.scale, shape.segment ? 2 : 0);
  for (const [stroke, wide] of [[rim, width + 2 * SHAPE_OUTLINE], [colour, width]]) {
    context.strokeStyle = stroke;
    context.lineWidth = wide;
    if (wide > 0) context.stroke(path);
  }
  if (shape.segment) return;
  context.fillStyle = colour;
  context.fill(path);
  if (shape.circle && i >= 0) drawRadius(context, view, shape.circle, poses, i, rim);
}

// A line from the centre of a circle shows how it turns.
function drawRadius(context, view, [u, v, radius], poses, i, colour) {
  context.beginPath();
  context.moveTo(...view.toScreen(...placed(poses, i, [u, v])));
  context.lineTo(...view.toScreen(...placed(poses, i, [u + radius, v])));
  context.strokeStyle = colour;
  context.lineWidth = SHAPE_OUTLINE;
  context.stroke();
}

// Static shapes first, then the bodies after the benches.
function drawBodies(painter, poses) {
  const { model, view } = painter;
  for (const shape of model.scene.static) drawShape(painter, shape, "static", poses, -1);
  model.scene.bodies.slice(model.benches).forEach(({ type, shapes }, k) => {
    for (const shape of shapes) drawShape(painter, shape, type, poses, model.benches + k);
  });
}

function obstacleShape({ shape, x, y, size }) {
  const half = size / 2;
  if (shape === "round") return { circle: [x, y, half] };
  return { polygon: [x - half, y - half, x + half, y - half, x + half, y + half, x - half, y + half], radius: 0 };
}

function drawObstacles(painter, obstacles) {
  for (const obstacle of obstacles) drawShape(painter, obstacleShape(obstacle), "static", null, -1);
}

// Lines between the anchors of joints; a dragon's joints are the holes of its benches.
function drawJoints({ context, view, model }, poses, cuts) {
  const lines = new Path2D(), dots = new Path2D();
  for (const joint of model.joints) {
    if (cuts.has(joint.number)) continue;
    const [one, two] = model.ends(joint, poses).map((end) => view.toScreen(...end));
    lines.moveTo(...one);
    lines.lineTo(...two);
    for (const [px, py] of [one, two]) {
      dots.moveTo(px + 3, py);
      dots.arc(px, py, 3, 0, TURN);
    }
  }
  context.strokeStyle = context.fillStyle = CONSTRAINT_COLOUR;
  context.lineWidth = 1.5;
  context.stroke(lines);
  context.fill(dots);
}

// Centres of mass: the origins of the bodies.
function drawCentres({ context, view, colours }, { x, y }) {
  const path = new Path2D();
  for (let i = 0; i < x.length; i++) {
    if (!view.isVisible(x[i], y[i], 0)) continue;
    const [px, py] = view.toScreen(x[i], y[i]);
    path.moveTo(px - CROSS, py);
    path.lineTo(px + CROSS, py);
    path.moveTo(px, py - CROSS);
    path.lineTo(px, py + CROSS);
  }
  strokeTwice(context, path, colours.background, colours.type, 1.5);
}
