// What is at a point: of benches, of shapes that Pymunk draws, and of joints. `physics/readings.py`
// finds the bodies and joints that a hand takes by the same rules.

// The nearest item within a distance, by items and distances; null if there is none.
/** @type {<T>(slip: number, items: T[], distanceOf: (item: T) => number) => T | null} */
function nearestWithin(slip, items, distanceOf) {
  /** @type {any} */
  let found = null;
  let nearest = slip;
  for (const item of items) {
    const distance = distanceOf(item);
    if (distance < nearest || (distance === nearest && found === null)) {
      found = item;
      nearest = distance;
    }
  }
  return found;
}

// The bench within `slip` m of a point; the lowest number if the point is on several.
/** @type {(benches: Benches<BenchSizes>, point: Numbers, slip: number) => number | null} */
function benchAt(benches, point, slip) {
  const last = benches.model.benches - 1;
  return nearestWithin(slip, range(0, last, last), (i) => benches.nearestPoint(i, point).distance);
}

// What a hand takes at a point: a bench, or the shape with the best grip that is drawn last there,
// or else the nearest within `slip`; and its point closest to that point. Null if there is none.
/**
 * @type {(
 *   point: Numbers,
 *   slip: number,
 *   moment: { benches: Benches<BenchSizes>, calls?: Call[] },
 * ) => (Target & { point: Numbers }) | null}
 */
function bodyAt(point, slip, { benches, calls = [] }) {
  if (benches.model.benches) {
    const bench = benchAt(benches, point, slip);
    return bench === null ? null : { bench, ...benches.nearestPoint(bench, point) };
  }
  const near = calls
    .filter(({ grip }) => grip > 0)
    .map((call) => ({ call, ...nearestOnShape(call, point) }))
    .filter(({ distance }) => distance <= slip)
    .reverse();
  const best = Math.max(...near.map(({ call }) => call.grip));
  return nearestWithin(
    slip,
    near.filter(({ call }) => call.grip === best),
    ({ distance }) => distance,
  );
}

// The joint whose line passes within `slip` of a point; null if there is none.
/** @type {(point: Numbers, slip: number, joints: Joint[]) => Joint | null} */
function jointAt(point, slip, joints) {
  return nearestWithin(slip, joints, ({ ends }) => nearestOnSegment(...ends, point).distance);
}

/** @type {(one: Numbers, two: Numbers, point: Numbers) => { point: Point, distance: number }} */
function nearestOnSegment([ax, ay], [bx, by], [px, py]) {
  const dx = bx - ax;
  const dy = by - ay;
  const share = Math.min(
    Math.max(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy || 1), 0),
    1,
  );
  /** @type {Point} */
  const point = [ax + share * dx, ay + share * dy];
  return { point, distance: Math.hypot(px - point[0], py - point[1]) };
}

// Whether a point is inside a convex polygon, whose corners may have either direction.
/** @type {(corners: Point[], point: Numbers) => boolean} */
function isInside(corners, [px, py]) {
  const signs = corners.map(([ax, ay], i) => {
    const [bx, by] = corners[(i + 1) % corners.length];
    return Math.sign((bx - ax) * (py - ay) - (by - ay) * (px - ax));
  });
  return corners.length > 2 && !(signs.includes(1) && signs.includes(-1));
}

// Point of a shape that is closest to a point, and the distance; 0 within the shape.
/**
 * @type {(
 *   shape: { points: Point[], radius: number },
 *   given: Numbers,
 * ) => { point: Numbers, distance: number }}
 */
function nearestOnShape({ points, radius }, given) {
  if (isInside(points, given)) return { point: given, distance: 0 };
  const sides = points.map((corner, i) =>
    nearestOnSegment(corner, points[(i + 1) % points.length], given),
  );
  const { point, distance } = sides.reduce((one, two) => (two.distance < one.distance ? two : one));
  if (distance <= radius) return { point: given, distance: 0 };
  /** @type {(value: number, axis: number) => number} */
  const shift = (value, axis) => value + (radius / distance) * (given[axis] - value);
  return { point: point.map(shift), distance: distance - radius };
}
