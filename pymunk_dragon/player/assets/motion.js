// Where the benches are at any time, how fast the handles are, and who touches whom.

const TURN = 2 * Math.PI;
// Seconds by which a contact is taken to begin early: a link's time is rounded, and has to show the contact's moment.
const EARLY = 1e-6;
// Frames whose poses are kept: slow motion needs the two about a time, and their neighbours, again and again.
const KEPT_FRAMES = 8;

// An angle from -pi to pi.
const turned = (angle) => angle - TURN * Math.floor((angle + Math.PI) / TURN);

// Pose of bench `i`, and how fast it changes, on the cubic polynomial between two motions that are `interval` s apart;
// a bench turns the shorter way round.
function hermite(one, two, interval, share, i) {
  const left = 1 - share;
  const value = (from, step, v0, v1) =>
    from + share * share * (3 - 2 * share) * step + interval * share * left * (left * v0 - share * v1);
  const rate = (step, v0, v1) =>
    6 * share * left * step / (interval || 1) + left * (1 - 3 * share) * v0 + share * (3 * share - 2) * v1;
  const dx = two.x[i] - one.x[i], dy = two.y[i] - one.y[i], turn = turned(two.angle[i] - one.angle[i]);
  return {
    x: value(one.x[i], dx, one.vx[i], two.vx[i]),
    y: value(one.y[i], dy, one.vy[i], two.vy[i]),
    angle: value(one.angle[i], turn, one.spin[i], two.spin[i]),
    vx: rate(dx, one.vx[i], two.vx[i]),
    vy: rate(dy, one.vy[i], two.vy[i]),
    spin: rate(turn, one.spin[i], two.spin[i]),
  };
}

class Motion {
  constructor(told, packed, velocities) {
    const { benches, head_spacing, body_spacing, overhang, width } = told.dragon;
    this.times = Float64Array.from(told.times);
    this.begin = this.times[0];
    this.end = this.times.at(-1);
    this.packed = packed;
    this.velocities = velocities;
    [this.placeError, this.velocityError] = told.errors;
    this.benches = benches;
    // A size is one number for all benches, or one for each.
    const each = (sizes) => Float64Array.from({ length: benches }, (_, i) => Array.isArray(sizes) ? sizes[i] : sizes);
    this.widths = each(width);
    this.narrowest = Math.min(...this.widths);
    this.spacings = each(Array.isArray(body_spacing) ? [head_spacing, ...body_spacing] : body_spacing);
    this.spacings[0] = head_spacing;
    const overhangs = each(overhang);
    this.lengths = this.spacings.map((spacing, i) => spacing + 2 * overhangs[i]);
    this.windows = told.windows;
    this.kept = new Map();
  }

  // First frame at `time` or after it.
  frameFrom(time) {
    let low = 0, high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // Poses of one frame, and how fast they change: a bench's centre is midway between its holes, and it points from the
  // rear one to the front one.
  frameMotion(frame) {
    const known = this.kept.get(frame);
    if (known) return known;
    const places = vectorsIn(this.packed, frame);
    const velocities = this.velocities ? vectorsIn(this.velocities, frame) : new Float64Array(places.length);
    const motion = { x: [], y: [], angle: [], vx: [], vy: [], spin: [] };
    for (let i = 0; i < this.benches; i++) {
      const [frontX, frontY, rearX, rearY] = places.subarray(2 * i, 2 * i + 4);
      const [frontVx, frontVy, rearVx, rearVy] = velocities.subarray(2 * i, 2 * i + 4);
      const alongX = frontX - rearX, alongY = frontY - rearY;
      motion.x.push((frontX + rearX) / 2);
      motion.y.push((frontY + rearY) / 2);
      motion.angle.push(Math.atan2(alongY, alongX));
      motion.vx.push((frontVx + rearVx) / 2);
      motion.vy.push((frontVy + rearVy) / 2);
      motion.spin.push((alongX * (frontVy - rearVy) - alongY * (frontVx - rearVx)) / (alongX ** 2 + alongY ** 2));
    }
    if (this.kept.size >= KEPT_FRAMES) this.kept.clear();
    this.kept.set(frame, motion);
    return motion;
  }

  // The two frames about a time, the seconds between them, and the share of these that has passed.
  between(time) {
    const last = this.times.length - 1;
    const after = Math.min(Math.max(this.frameFrom(time), Math.min(1, last)), last);
    const before = Math.max(after - 1, 0);
    const interval = this.times[after] - this.times[before];
    const share = Math.min(Math.max((time - this.times[before]) / (interval || 1), 0), 1);
    return { before, after, interval, share };
  }

  // About how far any point of a bench is from where the run has it, m: errors of the packed places and velocities, and
  // of the cubic between two frames. Its error is as the fourth derivative, which the cubic over two intervals tells
  // where it misses the frame in its middle. Infinity where no frame is in a middle.
  blurAt(time, bench) {
    const { before, after, interval, share } = this.between(time);
    const known = this.placeError * this.lengths[bench] / this.spacings[bench];
    if (share === 0 || share === 1) return known;
    const weight = share * (1 - share);
    const fourth = Math.max(...[before, after].map((frame) => this.fourthDerivative(frame, bench)));
    const cubic = fourth < 0 ? Infinity : weight ** 2 * interval ** 4 * fourth;
    return known + weight * interval * this.velocityError + cubic;
  }

  // A 24th of the fourth derivative of a bench's motion at a frame, m/s^4; -1 where it is not known.
  fourthDerivative(frame, bench) {
    const one = this.times[frame] - this.times[frame - 1], two = this.times[frame + 1] - this.times[frame];
    if (!(one > 0 && two > 0)) return -1;
    const here = this.frameMotion(frame);
    const cubic = hermite(this.frameMotion(frame - 1), this.frameMotion(frame + 1), one + two, one / (one + two), bench);
    const off = Math.hypot(cubic.x - here.x[bench], cubic.y - here.y[bench])
      + Math.abs(turned(cubic.angle - here.angle[bench])) * this.lengths[bench] / 2;
    return off / (one * two) ** 2;
  }

  // Poses at any time, and how fast they change: between frames, cubic Hermite polynomials, as in `Run.poses_at`.
  posesAt(time) {
    const { before, after, interval, share } = this.between(time);
    const one = this.frameMotion(before), two = this.frameMotion(after);
    const poses = Object.fromEntries(
      ["x", "y", "angle", "vx", "vy", "spin", "cos", "sin"].map((name) => [name, new Float64Array(this.benches)]));
    for (let i = 0; i < this.benches; i++) {
      const found = hermite(one, two, interval, share, i);
      for (const name in found) poses[name][i] = found[name];
      poses.cos[i] = Math.cos(found.angle);
      poses.sin[i] = Math.sin(found.angle);
    }
    return poses;
  }

  // Holes of the benches as they are drawn: handle i is the front hole of bench i, the last one the tail's rear hole.
  handlesOf(poses) {
    const places = [];
    for (let i = 0; i <= this.benches; i++) {
      const bench = Math.min(i, this.benches - 1);
      const half = (i < this.benches ? 1 : -1) * this.spacings[bench] / 2;
      places.push([poses.x[bench] + half * poses.cos[bench], poses.y[bench] + half * poses.sin[bench]]);
    }
    return places;
  }

  // Velocities of the same holes, [x, y] each in m/s. None where the run does not know them.
  velocitiesOf(poses) {
    if (!this.velocities) return null;
    return Array.from({ length: this.benches + 1 }, (_, i) => {
      const bench = Math.min(i, this.benches - 1);
      const half = (i < this.benches ? 1 : -1) * poses.spin[bench] * this.spacings[bench] / 2;
      return [poses.vx[bench] - half * poses.sin[bench], poses.vy[bench] + half * poses.cos[bench]];
    });
  }

  // Windows in which two benches touch at `time`.
  touchingAt(time) {
    return this.windows.filter(({ begin, end }) => begin - EARLY <= time && (end === null || time < end));
  }
}
