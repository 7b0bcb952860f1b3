// Rectangles of the benches: corners, distances, and the grid cells that they cover.

// Margin around a bench in cells, as in the package's grid: rounding never loses a cell.
const CELL_SLACK = 1e-8;

// Positions of the handles: handle i is the front hole of bench i, the last handle is the tail's rear hole.
function handlesOf(spacings, poses) {
  const last = spacings.length - 1;
  return Array.from({ length: last + 2 }, (_, i) => {
    const bench = Math.min(i, last);
    const half = (i <= last ? 1 : -1) * spacings[bench] / 2;
    return [poses.x[bench] + half * poses.cos[bench], poses.y[bench] + half * poses.sin[bench]];
  });
}

// Poses as columns, with cosines and sines; `poseOf` tells x, y and angle of a body.
function posesFrom(count, poseOf) {
  const poses = Object.fromEntries(["x", "y", "angle", "cos", "sin"].map((name) => [name, new Float64Array(count)]));
  for (let i = 0; i < count; i++) {
    [poses.x[i], poses.y[i], poses.angle[i]] = poseOf(i);
    poses.cos[i] = Math.cos(poses.angle[i]);
    poses.sin[i] = Math.sin(poses.angle[i]);
  }
  return poses;
}

// Benches at their poses; `motion` has their number `benches` and their `lengths`, `widths` and `spacings`.
class Benches {
  constructor(motion, poses) {
    this.motion = motion;
    this.poses = poses;
  }

  get handles() {
    return (this.cachedHandles ??= handlesOf(this.motion.spacings, this.poses));
  }

  // Corners: rear right, front right, front left, rear left.
  corners(i) {
    const { x, y, cos, sin } = this.poses;
    const along = this.motion.lengths[i] / 2, across = this.motion.widths[i] / 2;
    return [[-along, -across], [along, -across], [along, across], [-along, across]].map(
      ([a, c]) => [x[i] + a * cos[i] - c * sin[i], y[i] + a * sin[i] + c * cos[i]]);
  }

  // A point in the coordinates of bench `i`: metres ahead of its centre, and to the left.
  toLocal(i, [px, py]) {
    const { x, y, cos, sin } = this.poses;
    const dx = px - x[i], dy = py - y[i];
    return [dx * cos[i] + dy * sin[i], dy * cos[i] - dx * sin[i]];
  }

  // Point of bench `i` that is closest to a point, and the distance; 0 within the bench.
  nearestPoint(i, point) {
    const { x, y, cos, sin } = this.poses;
    const [ahead, left] = this.toLocal(i, point);
    const along = this.motion.lengths[i] / 2, across = this.motion.widths[i] / 2;
    const a = Math.min(Math.max(ahead, -along), along), c = Math.min(Math.max(left, -across), across);
    return {
      distance: Math.hypot(ahead - a, left - c),
      point: [x[i] + a * cos[i] - c * sin[i], y[i] + a * sin[i] + c * cos[i]],
    };
  }

  // Gaps between the shadows of two benches along and across the first, and the second; negative where they overlap.
  axisGaps(i, j) {
    const { x, y, cos, sin } = this.poses, { lengths, widths } = this.motion, dx = x[j] - x[i], dy = y[j] - y[i];
    const c = Math.abs(cos[i] * cos[j] + sin[i] * sin[j]), s = Math.abs(cos[i] * sin[j] - sin[i] * cos[j]);
    const along = (own, other) =>
      Math.abs(dx * cos[own] + dy * sin[own]) - (lengths[own] + c * lengths[other] + s * widths[other]) / 2;
    const across = (own, other) =>
      Math.abs(dy * cos[own] - dx * sin[own]) - (widths[own] + s * lengths[other] + c * widths[other]) / 2;
    return [along(i, j), across(i, j), along(j, i), across(j, i)];
  }

  // The gap between two benches, and its two ends. Rectangles that do not overlap are closest at a corner of one of them.
  // The gap of two that overlap is negative: the shortest way that parts them (separating axis theorem).
  gap(i, j) {
    let found = { gap: Infinity };
    for (const [own, other] of [[i, j], [j, i]]) {
      for (const corner of this.corners(own)) {
        const { distance, point } = this.nearestPoint(other, corner);
        if (distance < found.gap) found = { gap: distance, ends: [corner, point] };
      }
    }
    const widest = Math.max(...this.axisGaps(i, j));
    found.gap = widest > 0 ? Math.max(widest, found.gap) : widest;
    return found;
  }

  // The bench closest to bench `i` among those that are not its neighbours, of the first `count`, with the gap; `found` if
  // that is a smaller one.
  nearest(i, found = null, count = this.motion.benches) {
    const { x, y } = this.poses;
    const reach = (k) => Math.hypot(this.motion.lengths[k], this.motion.widths[k]) / 2;
    for (let j = 0; j < count; j++) {
      if (Math.abs(i - j) <= 1) continue;
      // Lower bound of the gap: distance of the centres less half a diagonal each.
      const least = Math.hypot(x[i] - x[j], y[i] - y[j]) - reach(i) - reach(j);
      if (found && least >= found.gap) continue;
      const between = this.gap(i, j);
      if (!found || between.gap < found.gap) found = { bench: j, ...between };
    }
    return found;
  }

  // The bench within `slip` m of a point; the lowest number if the point is on several.
  at(point, slip) {
    let found = null, nearest = slip;
    for (let i = 0; i < this.motion.benches; i++) {
      const { distance } = this.nearestPoint(i, point);
      if (distance === 0) return i;
      if (distance <= nearest) [found, nearest] = [i, distance];
    }
    return found;
  }

  // Grid cells [row, column] that bench `i` touches or covers: rows count downward, columns to the right.
  cells(i, { cell, origin }) {
    const { x, y, cos, sin } = this.poses;
    const u = (x[i] - origin[0]) / cell, v = (origin[1] - y[i]) / cell;
    const along = this.motion.lengths[i] / 2 / cell, across = this.motion.widths[i] / 2 / cell;
    const c = Math.abs(cos[i]), s = Math.abs(sin[i]);
    const reachU = along * c + across * s + CELL_SLACK, reachV = along * s + across * c + CELL_SLACK;
    const cells = [];
    for (let row = Math.floor(v - reachV); row <= Math.floor(v + reachV); row++) {
      for (let column = Math.floor(u - reachU); column <= Math.floor(u + reachU); column++) {
        // The ranges of rows and columns cover the cell's axes; the bench's axes remain to be tested.
        const du = column + 0.5 - u, dv = row + 0.5 - v;
        const half = (c + s) / 2 + CELL_SLACK;
        if (Math.abs(du * cos[i] - dv * sin[i]) <= along + half
          && Math.abs(du * sin[i] + dv * cos[i]) <= across + half) cells.push([row, column]);
      }
    }
    return cells;
  }
}
