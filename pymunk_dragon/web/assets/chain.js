// The exact chain on a curve, as in the package's model: lengths in m, angles in rad. A curve has
// its first and last coordinate `begin` and `end`, the arc length along it, and `frame(s)`: x, y,
// and the unit tangent's x and y there.

// Share of a chord in which its end is sought step by step;
// a step of Newton's method below the other one is the last.
const SEARCH_STEP = 1 / 16;
const STEP_TOLERANCE = 1e-8;
// Cells between two points of a drawn path, and nodes and
// weights of the integral of the length in a cell.
const CELLS = 8;
const GAUSS = [
  [0, 0.5688888888888889],
  [-0.5384693101056831, 0.47862867049936647],
  [0.5384693101056831, 0.47862867049936647],
  [-0.906179845938664, 0.23692688505618908],
  [0.906179845938664, 0.23692688505618908],
];
const ROOT_TOLERANCE = 1e-12; // m or s: width of an interval in which a root is found
const GOLDEN = (Math.sqrt(5) - 1) / 2; // ratio of the golden section

// The spiral r = k theta, travelled inward; the coordinate
// is the arc length from the centre, negative.
class Spiral {
  /** @param {number} pitch */
  constructor(pitch) {
    this.k = pitch / TURN;
    this.begin = -Infinity;
    this.end = 0;
    /** @type {[number, number]} */
    this.known = [0, 0];
  }

  /** @type {(theta: number) => number} */
  atAngle(theta) {
    const rise = Math.sqrt(theta * theta + 1);
    return (-this.k / 2) * (theta * rise + Math.log(theta + rise));
  }

  /** @type {(radius: number) => number} */
  atRadius(radius) {
    return this.atAngle(radius / this.k);
  }

  // Polar angle, counted from the centre: Newton's method from the asymptotic form.
  // The last one is known.
  /** @type {(s: number) => number} */
  angle(s) {
    if (s === this.known[0]) return this.known[1];
    const target = (-2 * s) / this.k;
    let theta = target > 8 ? Math.sqrt(target - 0.5 - Math.log(4 * target) / 2) : target / 2;
    for (let pass = 0; pass < 20; pass++) {
      const rise = Math.sqrt(theta * theta + 1);
      const step = (theta * rise + Math.log(theta + rise) - target) / (2 * rise);
      theta = Math.max(theta - step, 0);
      // The error that is left is the square of the step over twice the angle.
      if (Math.abs(step) <= 1e-7 * theta) break;
    }
    this.known = [s, theta];
    return theta;
  }

  // Coordinate of the first point behind `s` at the straight distance `chord`, if it is within half
  // a turn, in which the distance grows all the time; otherwise NaN. Newton's method for the angle
  // between both, from about `guess` m.
  /** @type {(s: number, chord: number, guess?: number) => number} */
  behind(s, chord, guess = chord) {
    const { k } = this;
    const theta = this.angle(s);
    const square = (chord / k) ** 2;
    if (chord > k * (2 * theta + Math.PI)) return NaN;
    let turn = Math.min(Math.sqrt(theta * theta + (2 * guess) / k) - theta, Math.PI);
    for (let pass = 0; pass < 60; pass++) {
      const sin = Math.sin(turn / 2);
      const cos = Math.cos(turn / 2);
      const far = theta + turn;
      const off = turn * turn + 4 * theta * far * sin * sin - square;
      const step = off / (2 * turn + 4 * theta * sin * (sin + far * cos));
      turn = bounded(turn - step, 0, Math.PI);
      if (Math.abs(step) <= STEP_TOLERANCE * turn) break;
    }
    this.known = [this.atAngle(theta + turn), theta + turn];
    return this.known[0];
  }

  /** @type {(s: number) => Frame} */
  frame(s) {
    const theta = this.angle(s);
    const radius = this.k * theta;
    const rise = -Math.sqrt(theta * theta + 1);
    const cos = Math.cos(theta);
    const sin = Math.sin(theta);
    return [radius * cos, radius * sin, (cos - theta * sin) / rise, (sin + theta * cos) / rise];
  }
}

// In on a spiral, round inside a circle on two arcs whose radii have a ratio, and out;
// s is 0 at the entry.
class UTurn {
  /** @param { { pitch?: number, radius?: number, ratio?: number }} sizes */
  constructor({ pitch = 1.7, radius = 4.5, ratio = 2 } = {}) {
    const theta = (TURN * radius) / pitch;
    const aside = Math.atan(theta);
    const heading = theta - Math.PI + aside;
    // Each arc's chord is twice its radius times the sine of half its angle;
    // together they are the diameter.
    const radii = [ratio, 1].map((share) => ((radius / Math.sin(aside)) * share) / (1 + ratio));
    /** @type {Point[]} */
    this.points = [1, (1 - ratio) / (1 + ratio), -1].map((share) => [
      share * radius * Math.cos(theta),
      share * radius * Math.sin(theta),
    ]);
    /** @type {(point: Point, r: number, side: number, angle: number) => TurnArc} */
    const arc = ([x, y], r, side, angle) => ({
      centre: [x - side * r * Math.sin(heading), y + side * r * Math.cos(heading)],
      radius: r,
      side,
      angle,
    });
    this.arcs = [
      arc(this.points[0], radii[0], -1, heading + Math.PI / 2),
      arc(this.points[2], radii[1], 1, heading - 2 * aside - Math.PI / 2),
    ];
    this.lengths = radii.map((each) => 2 * aside * each);
    this.length = this.lengths[0] + this.lengths[1];
    this.spiral = new Spiral(pitch);
    this.entry = this.spiral.atRadius(radius);
    this.begin = -Infinity;
    this.end = Infinity;
  }

  /** @type {(s: number) => Frame} */
  frame(s) {
    if (s < 0) return this.spiral.frame(this.entry + s);
    if (s < this.lengths[0]) return this.onArc(this.arcs[0], s);
    if (s < this.length) return this.onArc(this.arcs[1], s - this.lengths[0]);
    // The way out is the way in, turned by half a turn and travelled back.
    const [x, y, tx, ty] = this.spiral.frame(this.entry + this.length - s);
    return [-x, -y, tx, ty];
  }

  /** @type {(arc: TurnArc, s: number) => Frame} */
  onArc({ centre, radius, side, angle }, s) {
    const cos = Math.cos(angle + (side * s) / radius);
    const sin = Math.sin(angle + (side * s) / radius);
    return [centre[0] + radius * cos, centre[1] + radius * sin, -side * sin, side * cos];
  }
}

// A smooth path through at least four points: the cubic spline by chord length, with not-a-knot
// ends. Its coordinate is the length of the chords, and only nearly the arc length: `length` and
// `atLength` convert.
class DrawnPath {
  /** @param {Numbers[]} points */
  constructor(points) {
    const chords = points
      .slice(1)
      .map(([x, y], i) => Math.hypot(x - points[i][0], y - points[i][1]));
    this.knots = [0];
    for (const chord of chords) this.knots.push(lastOf(this.knots) + chord);
    this.cubics = [0, 1].map((axis) =>
      splineCubics(
        points.map((point) => point[axis]),
        chords,
      ),
    );
    this.begin = 0;
    this.end = lastOf(this.knots);
    // The lengths up to the knots.
    this.lengths = [0];
    for (const knot of this.knots.slice(1)) this.lengths.push(this.length(knot));
  }

  // The number of the piece with a coordinate.
  /** @type {(s: number) => number} */
  piece(s) {
    let i = 0;
    while (i < this.knots.length - 2 && s >= this.knots[i + 1]) i++;
    return i;
  }

  // Position and derivative, as x, y, and x and y, with the cubic of a piece.
  /** @type {(s: number, i?: number) => Frame} */
  motion(s, i = this.piece(s)) {
    const w = s - this.knots[i];
    const [a, b, c, d] = this.cubics[0][i];
    const [e, f, g, h] = this.cubics[1][i];
    return [
      a + w * (b + w * (c + w * d)),
      e + w * (f + w * (g + w * h)),
      b + w * (2 * c + 3 * w * d),
      f + w * (2 * g + 3 * w * h),
    ];
  }

  /** @type {(s: number) => Frame} */
  frame(s) {
    const [x, y, dx, dy] = this.motion(s);
    const speed = Math.sqrt(dx * dx + dy * dy);
    return [x, y, dx / speed, dy / speed];
  }

  /** @type {(s: number) => number} */
  length(s) {
    const i = Math.min(this.piece(s), this.lengths.length - 1);
    const half = (s - this.knots[i]) / 2 / CELLS;
    let sum = this.lengths[i];
    for (let cell = 0; cell < CELLS; cell++) {
      const middle = this.knots[i] + (2 * cell + 1) * half;
      for (const [node, weight] of GAUSS) {
        const [, , dx, dy] = this.motion(middle + half * node, i);
        sum += weight * half * Math.sqrt(dx * dx + dy * dy);
      }
    }
    return sum;
  }

  /** @type {(length: number) => number} */
  atLength(length) {
    return rootBetween((s) => length - this.length(s), this.begin, this.end);
  }
}

// Coefficients of a cubic spline between knots that are `h` apart, by powers of the distance from
// the knot before: its slopes solve a tridiagonal system (C. de Boor, A Practical Guide to Splines,
// chapter IV).
/** @type {(values: number[], h: number[]) => number[][]} */
function splineCubics(values, h) {
  const n = values.length;
  const rise = h.map((each, i) => (values[i + 1] - values[i]) / each);
  const p = h[0];
  const q = h[1];
  const a = h[n - 3];
  const b = h[n - 2];
  // Rows: the factors of the slopes before, at, and after a knot, and the right side.
  const rows = values.map((_, i) => [
    h[i],
    2 * (h[i - 1] + h[i]),
    h[i - 1],
    3 * (h[i] * rise[i - 1] + h[i - 1] * rise[i]),
  ]);
  rows[0] = [0, q, p + q, ((3 * p + 2 * q) * q * rise[0] + p ** 2 * rise[1]) / (p + q)];
  rows[n - 1] = [a + b, a, 0, (b ** 2 * rise[n - 3] + (2 * a + 3 * b) * a * rise[n - 2]) / (a + b)];
  for (let i = 1; i < n; i++) {
    const share = rows[i][0] / rows[i - 1][1];
    rows[i][1] -= share * rows[i - 1][2];
    rows[i][3] -= share * rows[i - 1][3];
  }
  /** @type {number[]} */
  const slopes = [];
  for (let i = n - 1; i >= 0; i--) {
    slopes[i] = (rows[i][3] - rows[i][2] * (slopes[i + 1] ?? 0)) / rows[i][1];
  }
  return h.map((each, i) => [
    values[i],
    slopes[i],
    (3 * rise[i] - 2 * slopes[i] - slopes[i + 1]) / each,
    (slopes[i] + slopes[i + 1] - 2 * rise[i]) / each ** 2,
  ]);
}

// One of the sizes of benches, which may be a number for all of them.
/** @type {(sizes: number | number[], i: number) => number} */
const sizeOf = (sizes, i) => (typeof sizes === "number" ? sizes : sizes[i]);

// Benches as geometry.js takes them; by default the contest's dragon.
/** @type {(sizes?: DragonSizes) => Dragon} */
function makeDragon({
  benches = 223,
  head = 2.86,
  body = 1.65,
  overhang = 0.275,
  width = 0.3,
} = {}) {
  const spacings = Array.from({ length: benches }, (_, i) =>
    i === 0 ? head : sizeOf(body, i - 1),
  );
  const widths = spacings.map((_, i) => sizeOf(width, i));
  return { benches, spacings, widths, lengths: spacings.map((spacing) => spacing + 2 * overhang) };
}

// Coordinate of the first point behind `s` at the straight distance `chord`, or ahead with `way` 1.
// NaN if the curve ends before, or turns back so that the distance shrinks first. `guess` is about
// how far away along the curve it is. A curve may have a faster method `behind`.
/** @type {(curve: Curve, s: number, chord: number, way?: number, guess?: number) => number} */
function neighbour(curve, s, chord, way = -1, guess = chord) {
  const found = way < 0 ? (curve.behind?.(s, chord, guess) ?? NaN) : NaN;
  if (found < s) return found;
  const [x, y] = curve.frame(s);
  const room = way < 0 ? s - curve.begin : curve.end - s;
  /** @type {number} */
  let distance = 0;
  let growth = 0;
  /** @type {(offset: number) => void} */
  const evaluate = (offset) => {
    const [px, py, tx, ty] = curve.frame(s + way * offset);
    distance = Math.sqrt((px - x) ** 2 + (py - y) ** 2);
    growth = (way * ((px - x) * tx + (py - y) * ty)) / distance;
  };
  let low = 0;
  let high = Math.min(chord, room);
  let offset = high;
  for (evaluate(high); distance < chord; evaluate(high)) {
    if (high === room || !(growth > 0)) return NaN;
    const next = high + SEARCH_STEP * chord;
    low = high;
    high = Math.min(guess > high && guess < next ? guess : next, room);
    offset = high;
  }
  for (let pass = 0; pass < 60; pass++) {
    const newton = offset + (chord - distance) / growth;
    const trusted = newton >= low && newton <= high;
    const step = trusted ? newton - offset : (low + high) / 2 - offset;
    offset += step;
    if (Math.abs(step) <= (trusted ? STEP_TOLERANCE : Number.EPSILON) * chord) break;
    evaluate(offset);
    [low, high] = distance < chord ? [offset, high] : [low, offset];
  }
  return s + way * offset;
}

// The first `count` handles of a dragon with its head at the coordinate `head`, fewer if the curve
// takes no more: coordinates, points with tangents as `frame` has them, and velocities along the
// curve in units of the head's.
/** @type {(curve: Curve, dragon: Dragon, head: number, count?: number) => Chain} */
function chainAt(curve, { benches, spacings }, head, count = benches + 1) {
  /** @type {Chain} */
  const chain = { s: [head], points: [curve.frame(head)], ratios: [1] };
  for (let i = 1; i < count; i++) {
    const chord = spacings[i - 1];
    const guess = i > 1 ? ((chain.s[i - 2] - chain.s[i - 1]) * chord) / spacings[i - 2] : chord;
    const s = neighbour(curve, chain.s[i - 1], chord, -1, guess);
    if (Number.isNaN(s)) break;
    const [fx, fy, ux, uy] = chain.points[i - 1];
    const [x, y, tx, ty] = curve.frame(s);
    chain.s.push(s);
    chain.points.push([x, y, tx, ty]);
    // Both handles of a rigid bench are equally fast along it.
    chain.ratios.push(
      (chain.ratios[i - 1] * ((fx - x) * ux + (fy - y) * uy)) / ((fx - x) * tx + (fy - y) * ty),
    );
  }
  return chain;
}

// Benches between handles, from the head on.
/** @type {(dragon: Dragon, points: Numbers[]) => Benches<BenchSizes>} */
function benchesBetween(dragon, points) {
  return new Benches({ ...dragon, benches: points.length - 1 }, posesBetween(points));
}

// The bench closest to the head, and the gap; there are at least three benches.
/** @type {(benches: Benches<BenchSizes>) => NearestBench} */
function nearestToHead(benches) {
  return /** @type {NearestBench} */ (benches.nearest(0));
}

// The contest's march from turn 16 of a spiral on, at 1 m/s; `sizes` are those of `makeDragon`.
class March {
  /** @param {DragonSizes & { pitch?: number }} sizes */
  constructor({ pitch = 0.55, ...sizes } = {}) {
    this.pitch = pitch;
    this.dragon = makeDragon(sizes);
    this.spiral = new Spiral(pitch);
    this.begin = this.spiral.atAngle(16 * TURN);
    /** @type {Map<number, number>} */
    this.gaps = new Map();
  }

  /** @type {(t: number, handles?: number) => Chain} */
  chain(t, handles) {
    return chainAt(this.spiral, this.dragon, this.begin + t, handles);
  }

  /** @type {(t: number, handles?: number) => Benches<BenchSizes>} */
  benches(t, handles) {
    return benchesBetween(this.dragon, this.chain(t, handles).points);
  }

  // The bench closest to the head, of those that it passes, and the gap.
  /** @type {(t: number, handles?: number) => NearestBench} */
  passed(t, handles = 14) {
    return nearestToHead(this.benches(t, handles));
  }

  // Only the gap; each time is computed once.
  /** @type {(t: number, handles?: number) => number} */
  gap(t, handles) {
    const gap = this.gaps.get(t) ?? this.passed(t, handles).gap;
    this.gaps.set(t, gap);
    return gap;
  }
}

// Pairs of benches, other than neighbours, that share a cell of a grid,
// and the number of entries in cells.
/** @type {(benches: Benches<BenchSizes>, grid: Grid) => Filed} */
function gridPairs(benches, grid) {
  /** @type {Map<string, number[]>} */
  const cells = new Map();
  /** @type {Set<number>} */
  const pairs = new Set();
  const count = benches.model.benches;
  let entries = 0;
  for (let i = 0; i < count; i++) {
    for (const cell of benches.cells(i, grid)) {
      const key = cell.join();
      const filed = cells.get(key) ?? [];
      for (const j of filed) if (i - j > 1) pairs.add(j * count + i);
      cells.set(key, [...filed, i]);
      entries++;
    }
  }
  return {
    cells,
    entries,
    pairs: Array.from(pairs, (code) => [Math.floor(code / count), code % count]),
  };
}

// A root of a function between `before`, where it is positive, and `after`, where it is not,
// by bisection.
/** @type {(f: (x: number) => number, before: number, after: number) => number} */
function rootBetween(f, before, after) {
  while (Math.abs(after - before) > ROOT_TOLERANCE) {
    const middle = (before + after) / 2;
    if (f(middle) > 0) before = middle;
    else after = middle;
  }
  return after;
}

// Where a function is smallest between two arguments, if it has one minimum there.
/** @type {(f: (x: number) => number, a: number, b: number) => number} */
function minimumBetween(f, a, b) {
  for (let pass = 0; pass < 36; pass++) {
    const c = b - GOLDEN * (b - a);
    const d = a + GOLDEN * (b - a);
    if (f(c) < f(d)) b = d;
    else a = c;
  }
  return (a + b) / 2;
}

// The argument of those given for which a function is smallest.
/** @type {<T>(all: T[], f: (each: T) => number) => T} */
function smallestOf(all, f) {
  const values = all.map(f);
  return all[values.indexOf(Math.min(...values))];
}

// The first root of a gap between two arguments, in steps
// that see each of its minima below `near`; null if none.
/**
 * @type {(
 *   gap: (at: number) => number,
 *   begin: number,
 *   end: number,
 *   step: number,
 *   near: number,
 * ) => number | null}
 */
function firstContact(gap, begin, end, step, near) {
  let before = Infinity;
  let last = gap(begin);
  let at = begin;
  if (last <= 0) return begin;
  while (at < end) {
    const next = Math.min(at + step, end);
    const here = gap(next);
    if (before > last && last < here && last < near) {
      const least = minimumBetween(gap, at - step, next);
      if (gap(least) <= 0) return rootBetween(gap, at - step, least);
    }
    if (here <= 0) return rootBetween(gap, at, next);
    before = last;
    last = here;
    at = next;
  }
  return null;
}
