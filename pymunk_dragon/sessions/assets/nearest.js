// Distances of points from drawn shapes, in the units of the space.

function nearestOnSegment([ax, ay], [bx, by], [px, py]) {
  const dx = bx - ax, dy = by - ay;
  const share = Math.min(Math.max(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1), 0), 1);
  const point = [ax + share * dx, ay + share * dy];
  return { point, distance: Math.hypot(px - point[0], py - point[1]) };
}

// Whether a point is inside a convex polygon, whose corners may have either direction.
function isInside(corners, [px, py]) {
  const signs = corners.map(([ax, ay], i) => {
    const [bx, by] = corners[(i + 1) % corners.length];
    return Math.sign((bx - ax) * (py - ay) - (by - ay) * (px - ax));
  });
  return corners.length > 2 && !(signs.includes(1) && signs.includes(-1));
}

// Point of a shape that is closest to a point, and the distance; 0 within the shape.
function nearestOnShape({ points, radius }, given) {
  if (isInside(points, given)) return { point: given, distance: 0 };
  const sides = points.map((corner, i) => nearestOnSegment(corner, points[(i + 1) % points.length], given));
  const { point, distance } = sides.reduce((one, two) => (two.distance < one.distance ? two : one));
  if (distance <= radius) return { point: given, distance: 0 };
  const share = radius / distance;
  return { point: [0, 1].map((axis) => point[axis] + share * (given[axis] - point[axis])), distance: distance - radius };
}
