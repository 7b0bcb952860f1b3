// A recording of a run as a source of pictures: poses of the benches, velocities of the handles and
// benches in contact at any time.

// s: a contact is shown this much before it begins, as times in links are rounded.
const LINK_TOLERANCE = 1e-6;
// Slow motion needs the two frames around a time and their neighbours in every picture.
const CACHED_FRAMES = 8;

// The same angle from -pi to pi.
/** @type {(angle: number) => number} */
const normalizeAngle = (angle) => angle - TURN * Math.floor((angle + Math.PI) / TURN);

// Pose of bench `i` and its rate of change on the cubic Hermite polynomial between two frames
// `interval` s apart. Angles change by at most half a turn.
/**
 * @type {(
 *   one: FrameMotion,
 *   two: FrameMotion,
 *   interval: number,
 *   share: number,
 *   i: number,
 * ) => BenchMotion}
 */
function hermite(one, two, interval, share, i) {
  const left = 1 - share;
  /** @type {(from: number, step: number, v0: number, v1: number) => number} */
  const value = (from, step, v0, v1) =>
    from +
    share * share * (3 - 2 * share) * step +
    interval * share * left * (left * v0 - share * v1);
  /** @type {(step: number, v0: number, v1: number) => number} */
  const rate = (step, v0, v1) =>
    (6 * share * left * step) / (interval || 1) +
    left * (1 - 3 * share) * v0 +
    share * (3 * share - 2) * v1;
  const dx = two.x[i] - one.x[i];
  const dy = two.y[i] - one.y[i];
  const turn = normalizeAngle(two.angle[i] - one.angle[i]);
  return {
    x: value(one.x[i], dx, one.vx[i], two.vx[i]),
    y: value(one.y[i], dy, one.vy[i], two.vy[i]),
    angle: value(one.angle[i], turn, one.angularRate[i], two.angularRate[i]),
    vx: rate(dx, one.vx[i], two.vx[i]),
    vy: rate(dy, one.vy[i], two.vy[i]),
    angularRate: rate(turn, one.angularRate[i], two.angularRate[i]),
  };
}

class Recording {
  /** @param {Payload} payload @param {Record<string, Packed>} packed */
  constructor(payload, { handles, velocities, exact, curve }) {
    const { benches, head_spacing, body_spacing, overhang, width } = payload.dragon;
    this.times = Float64Array.from(payload.times);
    this.begin = this.times[0];
    this.end = this.times[this.times.length - 1];
    this.packed = handles;
    this.velocities = velocities;
    this.positionError = payload.errors[0]; // m
    this.velocityError = payload.errors[1]; // m/s
    this.benches = benches;
    // A size is a number for all benches, or an array.
    /** @type {(sizes: number | number[]) => Float64Array} */
    const each = (sizes) =>
      Float64Array.from({ length: benches }, (_, i) => (Array.isArray(sizes) ? sizes[i] : sizes));
    this.widths = each(width);
    this.narrowest = Math.min(...this.widths);
    this.spacings = each(
      Array.isArray(body_spacing) ? [head_spacing, ...body_spacing] : body_spacing,
    );
    this.spacings[0] = head_spacing;
    const overhangs = each(overhang);
    this.lengths = this.spacings.map((spacing, i) => spacing + 2 * overhangs[i]);
    this.hole = payload.dragon.hole;
    this.curve = vectorsOf(curve, curve.counts);
    this.curveError = payload.curve_error; // m
    this.grid = payload.grid;
    this.nearMisses = payload.near_misses;
    this.windows = payload.windows;
    this.exact = exact && new Exact(this, exact);
    this.field = this.coveredField();
    this.up = 1;
    this.units = "m";
    this.unitOf = { force: "N", torque: "N m", impulse: "N s" };
    /** @type {Map<number, FrameMotion>} */
    this.cache = new Map();
  }

  // The area that the benches cover during the run: the handles,
  // and the ends of benches beyond them.
  coveredField() {
    const { counts, origin, step } = this.packed;
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    for (let i = 0; i < counts.length; i++) {
      const axis = i & 1;
      if (counts[i] < low[axis]) low[axis] = counts[i];
      if (counts[i] > high[axis]) high[axis] = counts[i];
    }
    const beyond = Math.max(
      ...this.lengths.map((length, i) => (length - this.spacings[i] + this.widths[i]) / 2),
    );
    return {
      centre: [0, 1].map((axis) => origin[axis] + (step * (low[axis] + high[axis])) / 2),
      size: [0, 1].map((axis) => step * (high[axis] - low[axis]) + 2 * beyond),
    };
  }

  // Poses of one frame and their rates of change: a bench's centre is midway between its holes, and
  // its direction is from the rear hole to the front hole.
  /** @type {(frame: number) => FrameMotion} */
  frameMotion(frame) {
    const cached = this.cache.get(frame);
    if (cached) return cached;
    const positions = vectorsIn(this.packed, frame);
    const velocities = this.velocities
      ? vectorsIn(this.velocities, frame)
      : new Float64Array(positions.length);
    /** @type {FrameMotion} */
    const motion = { x: [], y: [], angle: [], vx: [], vy: [], angularRate: [] };
    for (let i = 0; i < this.benches; i++) {
      const [frontX, frontY, rearX, rearY] = positions.subarray(2 * i, 2 * i + 4);
      const [frontVx, frontVy, rearVx, rearVy] = velocities.subarray(2 * i, 2 * i + 4);
      const alongX = frontX - rearX;
      const alongY = frontY - rearY;
      const dvx = frontVx - rearVx;
      const dvy = frontVy - rearVy;
      motion.x.push((frontX + rearX) / 2);
      motion.y.push((frontY + rearY) / 2);
      motion.angle.push(Math.atan2(alongY, alongX));
      motion.vx.push((frontVx + rearVx) / 2);
      motion.vy.push((frontVy + rearVy) / 2);
      motion.angularRate.push((alongX * dvy - alongY * dvx) / (alongX ** 2 + alongY ** 2));
    }
    if (this.cache.size >= CACHED_FRAMES) this.cache.clear();
    this.cache.set(frame, motion);
    return motion;
  }

  // The two frames around a time, the interval between them in s,
  // and the fraction of it that has passed.
  /**
   * @type {(
   *   time: number,
   * ) => { before: number, after: number, interval: number, share: number }}
   */
  between(time) {
    const last = this.times.length - 1;
    const found = this.times.findIndex((each) => each >= time);
    const after = found < 0 ? last : Math.max(found, Math.min(1, last));
    const before = Math.max(after - 1, 0);
    const interval = this.times[after] - this.times[before];
    const share = Math.min(Math.max((time - this.times[before]) / (interval || 1), 0), 1);
    return { before, after, interval, share };
  }

  // Estimated error of a bench's position, m: rounding of the packed positions and velocities, and
  // the error of the cubic between two frames. The latter is proportional to the fourth derivative,
  // which is estimated from the distance between the cubic over two intervals and the frame between
  // them. Infinity if there is no such frame.
  /** @type {(time: number, bench: number) => number} */
  errorAt(time, bench) {
    const { before, after, interval, share } = this.between(time);
    const known = (this.positionError * this.lengths[bench]) / this.spacings[bench];
    if (share === 0 || share === 1) return known;
    const weight = share * (1 - share);
    const fourth = Math.max(...[before, after].map((frame) => this.fourthDerivative(frame, bench)));
    const cubic = fourth < 0 ? Infinity : weight ** 2 * interval ** 4 * fourth;
    return known + weight * interval * this.velocityError + cubic;
  }

  // The fourth derivative of a bench's motion at a frame, divided by 24, m/s^4; -1 if unknown.
  /** @type {(frame: number, bench: number) => number} */
  fourthDerivative(frame, bench) {
    const one = this.times[frame] - this.times[frame - 1];
    const two = this.times[frame + 1] - this.times[frame];
    if (!(one > 0 && two > 0)) return -1;
    const before = this.frameMotion(frame - 1);
    const here = this.frameMotion(frame);
    const after = this.frameMotion(frame + 1);
    const cubic = hermite(before, after, one + two, one / (one + two), bench);
    const off =
      Math.hypot(cubic.x - here.x[bench], cubic.y - here.y[bench]) +
      (Math.abs(normalizeAngle(cubic.angle - here.angle[bench])) * this.lengths[bench]) / 2;
    return off / (one * two) ** 2;
  }

  // Poses at any time and their rates of change: between frames, cubic Hermite polynomials,
  // as in `Run.poses_at`.
  /** @type {(time: number) => Poses & Rates} */
  posesAt(time) {
    const { before, after, interval, share } = this.between(time);
    const one = this.frameMotion(before);
    const two = this.frameMotion(after);
    const found = one.x.map((_, i) => hermite(one, two, interval, share, i));
    return {
      ...posesFrom(this.benches, (i) => [found[i].x, found[i].y, found[i].angle]),
      vx: found.map(({ vx }) => vx),
      vy: found.map(({ vy }) => vy),
      angularRate: found.map(({ angularRate }) => angularRate),
    };
  }

  // What there is to see at a time; exact benches and velocities not included.
  /** @type {(time: number) => RecordedMoment} */
  momentAt(time) {
    const benches = new Benches(this, this.posesAt(time));
    const pairs = this.touchingAt(time).map(({ benches: two }) => two);
    return { time, benches, pairs, inContact: new Set(pairs.flat()), freeFrom: null };
  }

  // Exact benches at a time beside `benches`, with magnified distances from these; null if unknown.
  /**
   * @type {(
   *   time: number,
   *   benches: Benches<DrawnModel>,
   *   magnification: number,
   * ) => Ghosts | null}
   */
  ghostsAt(time, benches, magnification) {
    const poses = this.exact?.posesBeside(benches, time, magnification);
    return poses ? { benches: new Benches(this, poses), errors: null } : null;
  }

  // Velocities of the handles, [x, y] in m/s; null if unknown.
  /** @type {(poses: Poses & Rates) => Point[] | null} */
  velocitiesOf(poses) {
    if (!this.velocities) return null;
    return Array.from({ length: this.benches + 1 }, (_, i) => {
      const bench = Math.min(i, this.benches - 1);
      const half =
        ((i < this.benches ? 1 : -1) * poses.angularRate[bench] * this.spacings[bench]) / 2;
      return [poses.vx[bench] - half * poses.sin[bench], poses.vy[bench] + half * poses.cos[bench]];
    });
  }

  // Contact windows that include `time`.
  /** @type {(time: number) => ContactWindow[]} */
  touchingAt(time) {
    return this.windows.filter(
      ({ begin, end }) => begin - LINK_TOLERANCE <= time && (end === null || time < end),
    );
  }
}
