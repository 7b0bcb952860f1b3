// Where the benches are at any time, how fast the handles are, and who touches whom.

const TURN = 2 * Math.PI;
// Frames that a speed is worked out from. Four give the seed's to 0.1 mm/s, and at its two ends to 0.3 mm/s, which is the
// rounding of places.
const SPEED_FRAMES = 4;
// Seconds by which a contact is taken to begin early: a link's time is rounded, and has to show the contact's moment.
const EARLY = 1e-6;
// Frames whose poses are kept: slow motion asks for the same two again and again.
const KEPT_FRAMES = 4;

class Motion {
  constructor(told, packed) {
    const { benches, head_spacing, body_spacing, overhang, width } = told.dragon;
    this.times = Float64Array.from(told.times);
    this.begin = this.times[0];
    this.end = this.times.at(-1);
    this.packed = packed;
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
    const steps = Array.from(this.times.subarray(1), (time, i) => time - this.times[i]).filter((step) => step > 0);
    this.interval = steps.sort((a, b) => a - b)[steps.length >> 1] ?? 0;
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

  // Poses of one frame: a bench's centre is midway between its holes, and it points from the rear one to the front one.
  framePoses(frame) {
    const known = this.kept.get(frame);
    if (known) return known;
    const places = placesIn(this.packed, frame);
    const poses = { x: [], y: [], angle: [] };
    for (let i = 0; i < this.benches; i++) {
      const frontX = places[2 * i], frontY = places[2 * i + 1], rearX = places[2 * i + 2], rearY = places[2 * i + 3];
      poses.x.push((frontX + rearX) / 2);
      poses.y.push((frontY + rearY) / 2);
      poses.angle.push(Math.atan2(frontY - rearY, frontX - rearX));
    }
    if (this.kept.size >= KEPT_FRAMES) this.kept.clear();
    this.kept.set(frame, poses);
    return poses;
  }

  // The two frames about a time, and which share of the way from one to the other it is.
  between(time) {
    const last = this.times.length - 1;
    const after = Math.min(Math.max(this.frameFrom(time), Math.min(1, last)), last);
    const before = Math.max(after - 1, 0);
    const span = this.times[after] - this.times[before];
    return { before, after, share: Math.min(Math.max((time - this.times[before]) / (span > 0 ? span : 1), 0), 1) };
  }

  // About how far a bench is from its true place, m, because it goes straight between two frames: the way of a bent
  // path from its chord, as four frames tell it that are taken to be evenly apart.
  blurAt(time, bench) {
    const { before, share } = this.between(time);
    if (share === 0 || share === 1) return 0;
    if (this.times.length < 4) return Infinity;
    const first = Math.max(Math.min(before - 1, this.times.length - 4), 0);
    const { points, step, counts } = this.packed;
    const bends = [0, 1].map((axis) => [1, -1, -1, 1].reduce((sum, sign, k) =>
      sum + sign * counts[2 * ((first + k) * points + bench) + axis], 0));
    return share * (1 - share) / 4 * step * Math.hypot(...bends);
  }

  // Poses at any time: between frames, centres go straight and benches turn evenly, the shorter way round.
  posesAt(time) {
    const { before, after, share } = this.between(time);
    const one = this.framePoses(before), two = this.framePoses(after);
    const n = this.benches;
    const poses = {
      x: new Float64Array(n), y: new Float64Array(n), angle: new Float64Array(n),
      cos: new Float64Array(n), sin: new Float64Array(n),
    };
    for (let i = 0; i < n; i++) {
      let turn = two.angle[i] - one.angle[i];
      turn -= TURN * Math.floor((turn + Math.PI) / TURN);
      poses.x[i] = one.x[i] + share * (two.x[i] - one.x[i]);
      poses.y[i] = one.y[i] + share * (two.y[i] - one.y[i]);
      const angle = one.angle[i] + share * turn;
      poses.angle[i] = angle;
      poses.cos[i] = Math.cos(angle);
      poses.sin[i] = Math.sin(angle);
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

  // Velocities of the handles, [x, y] each in m/s: those of the polynomial through the frames about `time`. None where
  // the run has but one moment.
  velocitiesAt(time) {
    const frames = this.framesAbout(time);
    if (frames.length < 2) return null;
    const at = frames.map((frame) => this.times[frame]);
    const weights = at.map((own, j) => {
      let weight = 0;
      for (let m = 0; m < at.length; m++) {
        if (m === j) continue;
        let product = 1 / (own - at[m]);
        for (let l = 0; l < at.length; l++) if (l !== j && l !== m) product *= (time - at[l]) / (own - at[l]);
        weight += product;
      }
      return weight;
    });
    const { points, step, counts } = this.packed;
    return Array.from({ length: points }, (_, i) =>
      [0, 1].map((axis) => step * weights.reduce(
        (sum, weight, j) => sum + weight * counts[2 * (frames[j] * points + i) + axis], 0)));
  }

  // The frames nearest to `time`. Of two that nearly share a time, as a contact's and the one before may, only one is
  // taken: over so short a time rounding is faster than any bench.
  framesAbout(time) {
    const least = this.interval / 2;
    const last = this.times.length - 1;
    let right = this.frameFrom(time), left = right - 1;
    const chosen = [];
    while (chosen.length < SPEED_FRAMES && (left >= 0 || right <= last)) {
      const rightIsNearer = left < 0 || (right <= last && this.times[right] - time < time - this.times[left]);
      const next = rightIsNearer ? right++ : left--;
      if (chosen.every((frame) => Math.abs(this.times[frame] - this.times[next]) >= least && frame !== next
        && this.times[frame] !== this.times[next])) chosen.push(next);
    }
    return chosen;
  }

  // Windows in which two benches touch at `time`.
  touchingAt(time) {
    return this.windows.filter(({ begin, end }) => begin - EARLY <= time && (end === null || time < end));
  }
}
