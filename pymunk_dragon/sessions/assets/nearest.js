// Distances of points from shapes, in m and in the coordinates of the shape's body.

function localPoint({ x, y, cos, sin }, i, [px, py]) {
  const dx = px - x[i], dy = py - y[i];
  return [dx * cos[i] + dy * sin[i], dy * cos[i] - dx * sin[i]];
}

function nearestOnSegment([ax, ay], [bx, by], [px, py]) {
  const dx = bx - ax, dy = by - ay;
  const share = Math.min(Math.max(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1), 0), 1);
  const point = [ax + share * dx, ay + share * dy];
  return { point, distance: Math.hypot(px - point[0], py - point[1]) };
}

// Corners of a polygon as points.
function cornersOf({ polygon }) {
  return Array.from({ length: polygon.length / 2 }, (_, i) => [polygon[2 * i], polygon[2 * i + 1]]);
}

// Pymunk's polygons are convex, with their corners counter-clockwise; either direction is accepted.
function isInside(corners, [px, py]) {
  const signs = corners.map(([ax, ay], i) => {
    const [bx, by] = corners[(i + 1) % corners.length];
    return Math.sign((bx - ax) * (py - ay) - (by - ay) * (px - ax));
  });
  return !(signs.includes(1) && signs.includes(-1));
}

// The part of a shape within `radius` of a point of its core: that point or the given one, if the given one is inside.
function within({ point, distance }, radius, given) {
  if (distance <= radius) return { point: given, distance: 0 };
  const share = radius / distance;
  return {
    point: [0, 1].map((axis) => point[axis] + share * (given[axis] - point[axis])),
    distance: distance - radius,
  };
}

// Point of a shape that is closest to a point, and the distance; 0 within the shape.
function nearestOnShape(shape, point) {
  if (shape.circle) {
    const [x, y, radius] = shape.circle;
    return within(nearestOnSegment([x, y], [x, y], point), radius, point);
  }
  if (shape.segment) {
    const [ax, ay, bx, by, radius] = shape.segment;
    return within(nearestOnSegment([ax, ay], [bx, by], point), radius, point);
  }
  const corners = cornersOf(shape);
  if (isInside(corners, point)) return { point, distance: 0 };
  const sides = corners.map((corner, i) => nearestOnSegment(corner, corners[(i + 1) % corners.length], point));
  return within(sides.reduce((one, two) => (two.distance < one.distance ? two : one)), shape.radius ?? 0, point);
}

// Smallest size of a shape, m.
function thicknessOf(shape) {
  if (shape.circle) return 2 * shape.circle[2];
  if (shape.segment) return Math.max(2 * shape.segment[4], SMALLEST_SIZE);
  const corners = cornersOf(shape);
  const sizes = [0, 1].map((axis) => {
    const values = corners.map((corner) => corner[axis]);
    return Math.max(...values) - Math.min(...values);
  });
  return Math.min(...sizes) + 2 * (shape.radius ?? 0);
}
